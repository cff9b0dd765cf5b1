// SPDX-License-Identifier: MIT
//
// The richest scenes that passes of fragments are made for: none of them reads more textures than every driver binds at
// a time. Pass::input refuses more.
#include "support/cut_walls.h"
#include "support/gl_block.h"
#include "support/gl_touching_bodies.h"
#include "support/run_scenes.h"

namespace phymul::test {
namespace {

const Vec3 rich_size{0.03, 0.02, 0.02};  // m

struct RichBody {
  std::string name;
  Model model;
  TopologyOptions options;
};

/// Two materials that dissipate, one of which has fibres, in a capsule: particles with several domains, and walls.
Model in_capsule() {
  Material soft = soft_tissue(), hard{50e3, 0.2, 1500.0};
  for (Material* const material : {&soft, &hard}) {
    material->retardation_time = 2e-3;
    material->relaxation_strength = 1.5;
    material->relaxation_time = 0.01;
  }
  soft.fibre_ratio = 3.0;
  Model model = with_harder_half(make_block(rich_size, 4, 2, 2), soft, hard);
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
