// SPDX-License-Identifier: MIT
//
// How the library loads its GL part, and does without it.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"

namespace phymul {
namespace {

bool process_has(const std::string& library) {
  std::ifstream maps("/proc/self/maps");
  const std::string text{std::istreambuf_iterator<char>(maps), {}};
  return text.find(library) != std::string::npos;
}

Model large_body() {
  return test::with_material(make_block({0.1, 0.1, 0.1}, 9, 9, 9), {.young = 5e3, .poisson = 0.3, .density = 1000});
}

TEST(GlModule, IsLoadedOnlyWhenItMayBeOfUse) {
  ASSERT_FALSE(process_has("libphymul_gl"));
  const Model small = make_tetrahedron(0.01);
  const Scene small_scene(small);
  const auto solver = make_solver("auto", small, small_scene);
  EXPECT_EQ(solver->backend_reason(),
            "cpu: 4 particles are too few for a GPU to gain on; processor: " + solver->device() + ", bases by table");
  EXPECT_FALSE(process_has("libphymul_gl"));
  EXPECT_FALSE(process_has("libGLEW"));

  const Model large = large_body();
  const Scene large_scene(large);
  make_solver("auto", large, large_scene);
  EXPECT_TRUE(process_has("libphymul_gl"));
}

TEST(GlModule, AutoSaysWhyItTookWhatItTook) {
  const Model model = large_body();
  const Scene scene(model);
  const auto solver = make_solver("auto", model, scene);
  const std::string choice(solver->backend_reason());
  const std::string why_not = why_unavailable("gl");
  EXPECT_TRUE(choice.starts_with(std::string(solver->name()) + ": ")) << choice;
  if (!why_not.empty()) {
    EXPECT_TRUE(says(choice, why_not));
  } else {
    const bool software = choice.find("GL has a software renderer only (") != std::string::npos;
    EXPECT_NE(software, choice.find("a step took ") != std::string::npos) << choice;
    EXPECT_FALSE(software && solver->name() != "cpu") << choice;
  }
  EXPECT_EQ(make_solver("reference", model, scene)->backend_reason(), "");
}

TEST(GlModule, ReasonsAreOfTheDriver) {
  PHYMUL_SKIP_OR_FAIL(phymul::test::why_not_here("gl"));
  const SolverOptions options{.gl = {.device = "device:999"}};
  EXPECT_TRUE(says(why_unavailable("gl", options), "expected a device below"));
  const Model model = large_body();
  const Scene scene(model);
  const std::string message = message_of([&] { make_solver("gl", model, scene, {}, options); });
  EXPECT_TRUE(message.starts_with("backend \"gl\": GlOptions::device: expected a device below")) << message;
  // auto takes another backend, and never fails for GL's sake.
  const auto solver = make_solver("auto", model, scene, {}, options);
  EXPECT_EQ(solver->name(), "cpu");
  EXPECT_TRUE(says(solver->backend_reason(), "GL is not available: GlOptions::device"));
}

/// gl_tests.cmake runs these with PHYMUL_GL_MODULE set to something that is no module of this library.
class GlModuleFaulty : public testing::Test {
 protected:
  void SetUp() override {
    const char* reason = std::getenv("PHYMUL_TEST_REASON");
    if (!reason) GTEST_SKIP() << "PHYMUL_TEST_REASON is not set; ctest sets it";
    reason_ = reason;
  }
  std::string reason_;
};

TEST_F(GlModuleFaulty, TheReasonIsTold) {
  const std::vector<std::string> names = backend_names();
  EXPECT_TRUE(std::find(names.begin(), names.end(), "gl") != names.end());
  const std::string why_not = why_unavailable("gl");
  EXPECT_TRUE(says(why_not, reason_));
  const Model model = large_body();
  const Scene scene(model);
  EXPECT_EQ(message_of([&] { make_solver("gl", model, scene); }), "backend \"gl\": " + why_not);
}

TEST_F(GlModuleFaulty, EverythingElseWorks) {
  const Model model = large_body();
  Scene scene = Scene(model).gravity({0, 0, -9.81});
  EXPECT_EQ(why_unavailable("reference"), "");
  const auto solver = make_solver("auto", model, scene);
  EXPECT_EQ(solver->name(), "cpu");
  EXPECT_TRUE(says(solver->backend_reason(), reason_));
  EXPECT_TRUE(solver->step(5, 0.2 * solver->stable_step()).ok());
  EXPECT_FALSE(process_has("libGLEW"));
}

/// gl_tests.cmake runs this with a driver held to OpenGL 3.3 and to the desktop dialect.
TEST(GlModuleOld, ComputingIsRefusedByNameAndDrawingIsNot) {
  if (!std::getenv("PHYMUL_TEST_OLD_GL")) GTEST_SKIP() << "PHYMUL_TEST_OLD_GL is not set; ctest sets it";
  PHYMUL_SKIP_OR_FAIL(phymul::test::why_not_here("gl"));
  const std::string why_not = why_unavailable("gl-compute");
  EXPECT_TRUE(says(why_not, "4.3"));
  const Model model = make_tetrahedron(0.01);
  const Scene scene(model);
  EXPECT_EQ(message_of([&] { make_solver("gl-compute", model, scene); }), "backend \"gl-compute\": " + why_not);
  const auto solver = make_solver("gl", model, scene);
  EXPECT_TRUE(solver->step(5, 0.2 * solver->stable_step()).ok());
}

/// gl_tests.cmake runs these with PHYMUL_GL_MODULE set to a module of a GPU that takes no time.
class GlModuleInstant : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::getenv("PHYMUL_TEST_INSTANT_GPU")) GTEST_SKIP() << "PHYMUL_TEST_INSTANT_GPU is not set; ctest sets it";
    unsetenv("PHYMUL_TEST_OLD_GPU");
    unsetenv("PHYMUL_TEST_SLOW_GPU");
  }
  std::unique_ptr<Solver> chosen(const TopologyOptions& topology = {}) {
    return make_solver("auto", model_, scene_, topology);
  }
  Model model_ = make_block({0.1, 0.1, 0.1}, 9, 9, 9, 6);
  Scene scene_{model_};
};

TEST_F(GlModuleInstant, ComputeShadersAreTakenWhereTheGpuIsFaster) {
  const auto solver = chosen();
  const std::string choice(solver->backend_reason());
  EXPECT_EQ(solver->name(), "gl-compute");
  EXPECT_TRUE(choice.starts_with("gl-compute: a step took ")) << choice;
  EXPECT_TRUE(says(choice, " us, by cpu ", " thread", "GPU: Instant GPU, bases by table"));
  const std::string enumerated(chosen({.reaction = Reaction::shared, .bases = BaseSelection::all})->backend_reason());
  EXPECT_TRUE(says(enumerated, "single precision, bases enumerated; GPU", "Instant GPU, bases enumerated"));
}

TEST_F(GlModuleInstant, TheProcessorIsTakenWhereItIsFaster) {
  setenv("PHYMUL_TEST_SLOW_GPU", "1", 1);
  const auto solver = chosen();
  EXPECT_EQ(solver->name(), "cpu");
  EXPECT_TRUE(solver->backend_reason().starts_with("cpu: a step took ")) << solver->backend_reason();
  EXPECT_TRUE(says(solver->backend_reason(), " us, by gl-compute "));
}

TEST_F(GlModuleInstant, FragmentShadersAreMeasuredWhereThereAreNoOthers) {
  setenv("PHYMUL_TEST_OLD_GPU", "1", 1);
  const auto solver = chosen();
  const std::string choice(solver->backend_reason());
  EXPECT_EQ(solver->name(), "gl");
  EXPECT_TRUE(choice.starts_with("gl: a step took ")) << choice;
  EXPECT_TRUE(choice.ends_with("; not gl-compute: GL is not available: Instant GPU is too old")) << choice;
}

TEST_F(GlModuleInstant, JointsAreMeasuredWithTheirBody) {
  scene_.add_joint({at_particle(0), at_world({0, 0, -0.1})}, 10.0);
  EXPECT_EQ(chosen()->name(), "gl-compute");
}

TEST_F(GlModuleInstant, SmallBodiesAreNotMeasured) {
  const Model small = make_block({0.1, 0.1, 0.1}, 8, 8, 8, 6);  // 729 particles
  const Scene scene(small);
  EXPECT_EQ(make_solver("auto", small, scene)->name(), "cpu");
}

}  // namespace
}  // namespace phymul
