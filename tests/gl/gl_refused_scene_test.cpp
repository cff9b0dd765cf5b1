// SPDX-License-Identifier: MIT
//
// Scenes that a device cannot take: it goes on with the one before, as if it had not been asked.
#include <filesystem>
#include <fstream>
#include <utility>

#include "device/slice_tables.h"
#include "gl/compute/compute_device.h"
#include "gl/fragment/fragment_device.h"
#include "support/gl_touching_bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

/// For a device of a test's own.
FloatTools tools_of(const Scene& scene) {
  FloatTools tools(gl::Device::most_steps);
  tools.follow(scene);
  return tools;
}

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
    scene.add_tool("ball", {.shape = Sphere{0.004}, .pose = {.position = {0.0123, 0.0131, 0.0242}}});
    return scene.copy();
  }
  /// As DeviceSolver decides.
  static bool acts_on_host(const Scene& scene) {
    return GetParam() == GlBackend::fragment && scene.contacts().has_value();
  }
  std::unique_ptr<gl::Device> make(const Scene& scene, const gl::ShaderLibrary& library) const {
    std::unique_ptr<gl::Device> device;
    if (GetParam() == GlBackend::fragment) {
      device = std::make_unique<gl::FragmentDevice>(pack_floats(*tables_), scene, tools_of(scene), acts_on_host(scene),
                                                    library);
    } else {
      device = std::make_unique<gl::ComputeDevice>(pack_slices(pack_floats(*tables_), *tables_), scene, tools_of(scene),
                                                   acts_on_host(scene), library, gl::ComputeLimits::of_context());
    }
    device->write(tables_->rest, rest_state(model_));
    return device;
  }
  /// A batch of four steps.
  void go(gl::Device& device, FloatTools& tools) const {
    tools.begin_batch(4, dt_);
    device.begin_batch({.dt = dt_, .largest_acceleration = 1e30, .runaway_speed = 1e9},
                       {0.0, dt_, 2 * dt_, 3 * dt_, 4 * dt_}, tools);
    device.run(4);
    const gl::BatchReport report = device.report();
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
          asked->set_scene(other, tools_of(other), acts_on_host(other));
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
  offer("push_rows", [](Scene& other) { other.contacts({}); });
  offer("joint_ends", [](Scene& other) { other.add_joint({at_particle(0), at_world({0, 0, 1})}, 10.0); });
}

TEST_P(GlRefusedScene, ShadersThatDoNotCompileChangeNothing) {
  const std::filesystem::path folder = testing::TempDir() + "refused_" + name_of(GetParam());
  std::filesystem::remove_all(folder);
  std::filesystem::copy(PHYMUL_GLSL_SOURCES, folder, std::filesystem::copy_options::recursive);
  const bool draws = GetParam() == GlBackend::fragment;
  std::ofstream(folder / (draws ? "step/host_pushes.glsl" : "contact/contact_law.glsl"))
      << "float broken() { return; }\n";
  Scene other = pressed();
  other.contacts({});
  const gl::ShaderLibrary library(folder.string(), context_->info().es);
  context_->run([&] { expect_to_go_on(pressed(), other, library, "does not compile", ""); });
  std::filesystem::remove_all(folder);
}

/// Sweeps over more contacts and rounds than shaders count.
using GlComputeRefusedScene = RefusedScene;
INSTANTIATE_TEST_SUITE_P(gl_compute, GlComputeRefusedScene, testing::Values(GlBackend::compute));

TEST_P(GlComputeRefusedScene, ContactsThatAreTooManyAreRefusedBeforeAnythingIsMade) {
  Scene other = pressed();
  other.contacts({.rounds = 100'000'000});
  const gl::ShaderLibrary library("", context_->info().es);
  context_->run([&] {
    expect_to_go_on(pressed(), other, library, "use fewer rounds", "");
    const std::unique_ptr<gl::Device> device = make(pressed(), library);
    const ThingsMade made;
    EXPECT_NE(message_of([&] { device->set_scene(other, tools_of(other), false); }), "(no error)");
    EXPECT_EQ(made.count(), 0);
    device->set_scene(pressed(), tools_of(pressed()), false);
    EXPECT_GT(made.count(), 0);
  });
}

/// A host that takes back what was refused.
TEST_P(GlComputeRefusedScene, ASolverGoesOnOnceTheSceneFitsAgain) {
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

}  // namespace
}  // namespace phymul::test
