// SPDX-License-Identifier: MIT
//
// Scenes that a device cannot take: it keeps the one before, as if it had not been asked. The richest scenes
// that passes of fragments are made for: none of them reads more textures than every driver binds at a time.
// Pass::input refuses more.
#include <filesystem>
#include <fstream>
#include <utility>

#include "device/slice_tables.h"
#include "gl/compute/compute_device.h"
#include "gl/fragment/fragment_device.h"
#include "support/cut_bodies.h"
#include "support/gl_bodies.h"
#include "support/message_of.h"
#include "support/run_scenes.h"

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

const Vec3 rich_size{0.03, 0.02, 0.02};  // m

struct RichBody {
  std::string name;
  Model model;
  TopologyOptions options;
};

/// Two materials that dissipate, one of which has fibres, in a capsule: particles with several domains, and walls.
Model in_capsule() {
  Material soft = soft_tissue(), stiff{50e3, 0.2, 1500.0};
  for (Material* const material : {&soft, &stiff}) {
    material->retardation_time = 2e-3;
    material->relaxation_strength = 1.5;
    material->relaxation_time = 0.01;
  }
  soft.fibre_ratio = 3.0;
  Model model = with_harder_half(make_block(rich_size, 4, 2, 2), soft, stiff);
  for (Cell& cell : model.cells) cell.fibre = {0.6, 0.0, 0.8};
  add_capsule(model, film);
  return model;
}

/// With a particle that has springs, because it has too few neighbours for a base.
Model with_springs() {
  Model model = make_block(rich_size, 4, 2, 2);
  add_particle(model, Vec3(-0.005, -0.005, 0), {0, 1});
  model.mass.assign(model.mass.size(), 1e-3);
  model.stiffness.assign(model.mass.size(), 100.0);
  return model;
}

std::vector<RichBody> rich_bodies() {
  std::vector<RichBody> all{{"averaged_particles", in_capsule(), {}}};
  for (const auto& [name, reaction] : {std::pair{"conservative", Reaction::conservative},
                                       {"averaged", Reaction::averaged},
                                       {"shared", Reaction::shared}})
    all.push_back({name, with_springs(), {.reaction = reaction, .volume_stiffness = 1000.0}});
  return all;
}

class GlTextureUnits : public GlTest {
 protected:
  explicit GlTextureUnits(RichBody body = rich_bodies().front()) : body_(std::move(body)) {}
  void set_up() override {
    tables_ = tables_of(model(), body_.options);
    options_.damping.rate = 30.0;
    options_.spectrum = estimate_spectrum(*tables_, tables_->rest);
    options_.gl.debug = true;
    dt_ = 0.2 * stable_step(*options_.spectrum, 1.0);
  }
  const Model& model() const { return body_.model; }

  /// Imposed coordinates, forces, springs and a volume that is kept.
  void enrich(Scene& scene) const {
    scene.fix("x0").gravity({0, 0, -9.81}).constrain_volume();
    scene.add(pull(model(), "z0", {0, 1, 0}, {{0, 0}, {100 * dt_, 1e-4}}));
    scene.add(pull(model(), "z1", {1, 0, 0}, {{0, 0}, {100 * dt_, 0.01}}, LoadType::force));
    scene.attach(model().group("x1"), World{}, {.stiffness = 1e4, .damping = 5.0});
  }
  /// Of every shape, near the top; one is pulled by the body.
  void add_tools(Scene& scene) const {
    int row = 0;
    for (Tool tool : tools_of_each_shape()) {
      tool.pose = above({0.005 + 0.004 * row, 0.01, 0.025});
      scene.add_tool("tool " + std::to_string(row++), tool);
    }
    scene.add_joint({at_tool("tool 0", {0.001, 0, 0}), at_mean(model().group("x1")), 0.005}, 5.0);
  }

  RichBody body_;
  std::shared_ptr<const TopologyTextures> tables_;
  SolverOptions options_;
  double dt_ = 0.0;
};

class GlTextureUnitsOf : public GlTextureUnits, public testing::WithParamInterface<RichBody> {
 protected:
  GlTextureUnitsOf() : GlTextureUnits(GetParam()) {}
};

INSTANTIATE_TEST_SUITE_P(All, GlTextureUnitsOf, testing::ValuesIn(rich_bodies()),
                         [](const auto& body) { return body.param.name; });

TEST_P(GlTextureUnitsOf, SufficeForLoadsJointsAndVolumes) {
  Scene scene(model());
  enrich(scene);
  const GlTwins twins(tables_, scene, options_);
  ASSERT_TRUE(all_step(4, dt_, twins.gl, twins.mirror));
  twins.expect_same_bits("without tools");
}

/// The limit on displacements acts, so that tools bear what it withholds.
TEST_F(GlTextureUnits, SufficeForToolsOfEveryShape) {
  Scene scene(model());
  enrich(scene);
  add_tools(scene);
  options_.max_displacement_per_step = 1e-3;
  const GlTwins twins(tables_, scene, options_);
  twins.reset(random_state(model(), 0.02, 0.0, 3));
  double felt = 0.0;
  for (int call = 0; call < 2; ++call) {
    const StepReport a = twins.gl->step(3, dt_), b = twins.mirror->step(3, dt_);
    ASSERT_TRUE(is_ok(a) && is_ok(b));
    EXPECT_TRUE(a.force_clamped && b.force_clamped);
    twins.expect_same_bits("call " + std::to_string(call));
    for (const SceneTool& tool : scene.tools()) {
      const Vec3 force = twins.gl->tool_force(tool.name).force, other = twins.mirror->tool_force(tool.name).force;
      felt = std::max(felt, other.norm());
      EXPECT_LE((force - other).norm(), 1e-5 * twins.scale_of(other.norm(), felt)) << tool.name;
    }
  }
  EXPECT_GT(felt, 0.1);
}

/// A tool on triangles acts on the host, and all others with it.
TEST_F(GlTextureUnits, SufficeForStepsOfTheHost) {
  Scene scene(model());
  enrich(scene);
  add_tools(scene);
  Tool on_triangles = tools_of_each_shape().front();
  on_triangles.contact = ToolContact::surface;
  on_triangles.pose = above({0.02, 0.01, 0.0245});
  scene.add_tool("on triangles", on_triangles);
  gl::DeviceSolver device(GlBackend::fragment, tables_, scene, options_);
  const auto reference = make_solver("reference", tables_, scene, options_);
  ASSERT_TRUE(all_step(6, dt_, device, reference));
  const State a = device.read(), b = reference->read();
  const double way = largest_distance(b.position, model().rest);
  EXPECT_GT(way, 0.0);
  EXPECT_LE(largest_distance(a.position, b.position), 1e-5 * way);
}

}  // namespace
}  // namespace phymul::test
