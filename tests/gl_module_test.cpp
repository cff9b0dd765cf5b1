// SPDX-License-Identifier: MIT
//
// How the library loads its GL part, and does without it.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "gl_needed.h"
#include "message_of.h"

namespace phymul {
namespace {

bool process_has(const std::string& library) {
  std::ifstream maps("/proc/self/maps");
  const std::string text{std::istreambuf_iterator<char>(maps), {}};
  return text.find(library) != std::string::npos;
}

Model large_body() {
  Model model = make_block({0.1, 0.1, 0.1}, 9, 9, 9);
  set_material(model, {.young = 5e3, .poisson = 0.3, .density = 1000});
  return model;
}

TEST(GlModule, IsLoadedOnlyWhenItMayBeOfUse) {
  ASSERT_FALSE(process_has("libphymul_gl"));
  const Model small = make_tetrahedron(0.01);
  const Scene small_scene(small);
  EXPECT_EQ(make_solver("auto", small, small_scene)->choice(), "cpu: 4 particles are too few for a GPU to gain on");
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
  const std::string choice(solver->choice());
  const std::string why_not = why_unavailable("gl");
  EXPECT_TRUE(choice.starts_with(std::string(solver->name()) + ": ")) << choice;
  if (!why_not.empty()) {
    EXPECT_NE(choice.find(why_not), std::string::npos) << choice;
  } else {
    const bool gpu = solver->name() == "gl";
    EXPECT_NE(choice.find(gpu ? "a step took " : "GL has a software renderer only ("), std::string::npos) << choice;
  }
  EXPECT_EQ(make_solver("reference", model, scene)->choice(), "");
}

TEST(GlModule, ReasonsAreOfTheDriver) {
  PHYMUL_SKIP_OR_FAIL(why_unavailable("gl"));
  SolverOptions options;
  options.gl.device = "device:999";
  EXPECT_NE(why_unavailable("gl", options).find("expected a device below"), std::string::npos);
  const Model model = large_body();
  const Scene scene(model);
  const std::string message = message_of([&] { make_solver("gl", model, scene, {}, options); });
  EXPECT_TRUE(message.starts_with("backend \"gl\": GlOptions::device: expected a device below")) << message;
  // auto takes another backend, and never fails for GL's sake.
  const auto solver = make_solver("auto", model, scene, {}, options);
  EXPECT_EQ(solver->name(), "cpu");
  EXPECT_NE(solver->choice().find("GL is not available: GlOptions::device"), std::string::npos) << solver->choice();
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
  EXPECT_NE(why_not.find(reason_), std::string::npos) << why_not;
  const Model model = large_body();
  const Scene scene(model);
  EXPECT_EQ(message_of([&] { make_solver("gl", model, scene); }), "backend \"gl\": " + why_not);
}

TEST_F(GlModuleFaulty, EverythingElseWorks) {
  const Model model = large_body();
  Scene scene(model);
  scene.gravity({0, 0, -9.81});
  EXPECT_EQ(why_unavailable("reference"), "");
  const auto solver = make_solver("auto", model, scene);
  EXPECT_EQ(solver->name(), "cpu");
  EXPECT_NE(solver->choice().find(reason_), std::string::npos) << solver->choice();
  EXPECT_TRUE(solver->step(5, 0.2 * solver->stable_step()).ok());
  EXPECT_FALSE(process_has("libGLEW"));
}

}  // namespace
}  // namespace phymul
