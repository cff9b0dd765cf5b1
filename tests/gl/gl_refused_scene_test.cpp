// SPDX-License-Identifier: MIT
//
// Scenes that a device cannot take: it goes on with the one before, as if it had not been asked.
#include <filesystem>
#include <fstream>
#include <utility>

#include "device/slice_tables.h"
#include "gl/compute/compute_device.h"
#include "gl/fragment/fragment_device.h"
#include "support/gl_needles.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

PFNGLGETUNIFORMLOCATIONPROC driver_location = nullptr;
std::string refused_name;  // of a uniform

GLint GLAPIENTRY location_unless_refused(GLuint program, const GLchar* name) {
  if (refused_name == name) throw Error("refused: " + refused_name);
  return driver_location(program, name);
}

/// A device that fails where a pass is given what is behind one name, as one does whose textures are too few.
class RefusedName {
 public:
  explicit RefusedName(const char* name) {
    driver_location = glGetUniformLocation;
    glGetUniformLocation = location_unless_refused;
    refused_name = name;
  }
  ~RefusedName() { glGetUniformLocation = driver_location; }
  RefusedName(const RefusedName&) = delete;
  RefusedName& operator=(const RefusedName&) = delete;
};

PFNGLGENFRAMEBUFFERSPROC driver_framebuffers = nullptr;
PFNGLGENBUFFERSPROC driver_buffers = nullptr;
int things_made = 0;

void GLAPIENTRY count_framebuffers(GLsizei count, GLuint* names) {
  things_made += count;
  driver_framebuffers(count, names);
}
void GLAPIENTRY count_buffers(GLsizei count, GLuint* names) {
  things_made += count;
  driver_buffers(count, names);
}

/// Counts what a device makes: buffers, and framebuffers as most of its textures have one.
class ThingsMade {
 public:
  ThingsMade() {
    driver_framebuffers = std::exchange(glGenFramebuffers, count_framebuffers);
    driver_buffers = std::exchange(glGenBuffers, count_buffers);
    things_made = 0;
  }
  ~ThingsMade() {
    glGenFramebuffers = driver_framebuffers;
    glGenBuffers = driver_buffers;
  }
  ThingsMade(const ThingsMade&) = delete;
  ThingsMade& operator=(const ThingsMade&) = delete;
  static int count() { return things_made; }
};

/// A block on another one, a ball that presses, and a device of its own.
class RefusedScene : public OnBothDevices {
 protected:
  void set_up() override {
    tables_ = tables_of(model_, {});
    context_ = gl::Context::open({}, GetParam());
    dt_ = 0.4 * stable_step(estimate_spectrum(*tables_, tables_->rest), 1.0);
  }

  Scene pressed() const {
    Scene scene = Scene(model_).fix("low/z0").gravity({0, 0, -9.81});
    return scene.add_tool("ball", {.shape = Sphere{0.004}, .pose = {.position = {0.0123, 0.0131, 0.0242}}});
  }
  void add_needle(Scene& scene, double stiffness) const {
    Needle needle = bending(stiffness);
    needle.spread = 0.009;
    scene.add_tool("needle", {.shape = needle, .pose = {.position = {0.0103, 0.0121, 0.012}}, .friction = 0.5});
  }
  std::unique_ptr<gl::Device> make(const Scene& scene, const gl::ShaderLibrary& library) const {
    std::unique_ptr<gl::Device> device;
    if (GetParam() == GlBackend::fragment) {
      device = std::make_unique<gl::FragmentDevice>(pack_floats(*tables_), scene, tools_of(scene), library);
    } else {
      device = std::make_unique<gl::ComputeDevice>(pack_slices(pack_floats(*tables_), *tables_), scene, tools_of(scene),
                                                   library, gl::ComputeLimits::of_context());
    }
    device->write(tables_->rest, rest_state(model_));
    return device;
  }
  /// A batch of four steps.
  void go(gl::Device& device, FloatTools& tools) const {
    begin_batch(device, tools, 4, dt_);
    device.run(4);
    gl::BatchReport report = device.report();
    while (report.unfinished) {
      device.give_more_passes();
      device.run(4);
      report = device.report();
    }
    EXPECT_EQ(report.runaway_step, 0);
  }
  State read(gl::Device& device) const {
    State state;
    device.read(tables_->rest, state);
    return state;
  }

  /// Of two devices with `scene` one is offered `other`, which it refuses; both go on as one. `refused`: a uniform's
  /// name, or none.
  void expect_to_go_on(const Scene& scene, const Scene& other, const gl::ShaderLibrary& library, const char* cause,
                       const char* refused) const {
    const std::unique_ptr<gl::Device> asked = make(scene, library), alone = make(scene, library);
    FloatTools asked_tools = tools_of(scene), alone_tools = tools_of(scene);
    go(*asked, asked_tools);
    go(*alone, alone_tools);
    EXPECT_TRUE(refuses(
        [&] {
          const RefusedName guard(refused);
          asked->set_scene(other, tools_of(other));
        },
        cause));
    for (int batch = 0; batch < 2; ++batch) {
      go(*asked, asked_tools);
      go(*alone, alone_tools);
    }
    EXPECT_EQ(difference(read(*asked), read(*alone)), "");
    EXPECT_GT(largest_distance(read(*asked).position, tables_->rest), 1e-6);
  }

  Model model_ = stacked(0.0002);
  std::shared_ptr<const TopologyTextures> tables_;
  std::shared_ptr<gl::Context> context_;
  double dt_ = 0.0;
};

using GlRefusedScene = RefusedScene;
PHYMUL_ON_BOTH_DEVICES(GlRefusedScene);

/// Of gl alone, whose passes look for their textures when they are given them.
using GlFragmentRefusedScene = RefusedScene;
INSTANTIATE_TEST_SUITE_P(gl, GlFragmentRefusedScene, testing::Values(GlBackend::fragment));

TEST_P(GlFragmentRefusedScene, WhatAPassCannotBeGivenChangesNothing) {
  const gl::ShaderLibrary library("", context_->info().es);
  const auto offer = [&](const char* name, auto&& change) {
    SCOPED_TRACE(name);
    Scene scene = pressed(), other = pressed();
    change(other);
    context_->run([&] { expect_to_go_on(scene, other, library, name, name); });
  };
  offer("kept_facets", [](Scene& other) { other.constrain_volume("low"); });
  offer("tree_roots", [](Scene& other) { other.contacts({}); });
  offer("joint_ends", [](Scene& other) { other.add_joint({at_particle(0), at_world({0, 0, 1})}, 10.0); });
}

/// Passes of contacts are made once; those of needles that bend take the place of others, but not before they are
/// there.
TEST_P(GlRefusedScene, ShadersThatDoNotCompileChangeNothing) {
  const std::filesystem::path folder = testing::TempDir() + "refused_" + name_of(GetParam());
  std::filesystem::remove_all(folder);
  std::filesystem::copy(PHYMUL_GLSL_SOURCES, folder, std::filesystem::copy_options::recursive);
  const bool draws = GetParam() == GlBackend::fragment;
  std::ofstream(folder / (draws ? "contact/contact_phase_pass.glsl" : "needle/needle_bend.glsl"))
      << "float broken() { return; }\n";
  Scene scene = pressed(), other = pressed();
  if (draws) {
    other.contacts({});
  } else {
    add_needle(scene, 0.0);
    add_needle(other, 5e-3);
  }
  const gl::ShaderLibrary library(folder.string(), context_->info().es);
  context_->run([&] { expect_to_go_on(scene, other, library, "does not compile", ""); });
  std::filesystem::remove_all(folder);
}

/// Sweeps over more contacts and rounds than either backend counts.
TEST_P(GlRefusedScene, ContactsThatAreTooManyAreRefusedBeforeAnythingIsMade) {
  Scene other = pressed();
  if (GetParam() == GlBackend::compute) add_needle(other, 0.0);
  other.contacts({.rounds = 100'000'000});
  const gl::ShaderLibrary library("", context_->info().es);
  context_->run([&] {
    expect_to_go_on(pressed(), other, library, "use fewer rounds", "");
    const std::unique_ptr<gl::Device> device = make(pressed(), library);
    const ThingsMade made;
    EXPECT_NE(message_of([&] { device->set_scene(other, tools_of(other)); }), "(no error)");
    EXPECT_EQ(made.count(), 0);
    device->set_scene(pressed(), tools_of(pressed()));
    EXPECT_GT(made.count(), 0);
  });
}

/// A host that takes back what was refused.
TEST_P(GlRefusedScene, ASolverGoesOnOnceTheSceneFitsAgain) {
  Scene asked = pressed(), left = pressed();
  gl::DeviceSolver solver(GetParam(), tables_, asked, {}), alone(GetParam(), tables_, left, {});
  ASSERT_TRUE(all_step(20, dt_, solver, alone));
  const State before = solver.read();
  asked.contacts({.rounds = 100'000'000});
  for (int k = 0; k < 2; ++k) {
    EXPECT_TRUE(refuses([&] { solver.step(5, dt_); }, "use fewer rounds"));
    EXPECT_EQ(solver.read(), before);
  }
  asked.no_contacts();
  ASSERT_TRUE(all_step(20, dt_, solver, alone));
  EXPECT_EQ(difference(solver.read(), alone.read()), "");
}

using GlRefusedNeedle = GlTest;

/// Of gl alone. The scene before is left as it was, and goes on once the needle is gone.
TEST_F(GlRefusedNeedle, IsNamedAndTheSceneBeforeGoesOn) {
  const Model model = with_material(make_block({0.02, 0.02, 0.02}, 3, 3, 3));
  Scene scene(model), alone(model);
  const Tool ball{.shape = Sphere{0.005}, .pose = {.position = {0.01, 0.01, 0.024}}};
  for (Scene* one : {&scene, &alone}) one->fix("z0").gravity({0, 0, -9.81}).add_tool("ball", ball);
  const auto solver = make_solver("gl", model, scene), plain = make_solver("gl", model, alone);
  const double dt = 0.1 * solver->stable_step();
  ASSERT_TRUE(all_step(20, dt, solver, plain));
  const State before = solver->read();
  scene.add_tool("needle", {.shape = Needle{}, .pose = {.position = {0.01, 0.01, 0.03}}});
  const StepReport refused = solver->step(1, dt);
  EXPECT_EQ(refused.status, StepStatus::not_supported);
  for (const std::string& message : {refused.message(), message_of([&] { make_solver("gl", model, scene); }),
                                     message_of([&] { solver->reset(); })}) {
    for (const char* part : {"needle", "\"gl\"", "\"gl-compute\"", "\"cpu\"", "\"reference\""}) {
      EXPECT_TRUE(says(message, part));
    }
  }
  EXPECT_EQ(solver->read(), before);
  scene.remove_tool("needle");
  ASSERT_TRUE(all_step(20, dt, solver, plain));
  EXPECT_EQ(solver->read(), plain->read());
  EXPECT_EQ(solver->tool_force("ball").mean_force, plain->tool_force("ball").mean_force);
  scene.add_tool("needle", {.shape = Needle{}, .pose = {.position = {0.01, 0.01, 0.03}}});
  EXPECT_NE(make_solver("auto", model, scene)->name(), "gl");
}

}  // namespace
}  // namespace phymul::test
