// SPDX-License-Identifier: MIT
//
// Scene::scale_stiffness on the GL backends: against the float mirror bit by bit where the renderer allows (llvmpipe),
// against the double reference, and what a scene without factors pays for it.
#include "support/gl_block.h"
#include "support/gl_touching_bodies.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

class GlStiffness : public TwinsOnBothDevices {};

PHYMUL_ON_BOTH_DEVICES(GlStiffness);

const Material hard{50e3, 0.2, 1500.0};

Model two_materials(const Model& model) {
  return with_harder_half(model, soft_tissue(0.45), hard);
}

std::vector<Body> bodies_of_two_materials() {
  return {{"tetrahedra", two_materials(make_tetrahedral_block({0.03, 0.02, 0.02}, 4, 2, 3, 0.2, 5))},
          {"hexahedra", two_materials(make_block({0.03, 0.02, 0.02}, 4, 3, 2))},
          {"strip", two_materials(make_strip(0.04, 0.02, 6, 3))}};
}

/// Factors that come, change, and go.
void change(Scene& scene, int call) {
  switch (call) {
    case 1:
      scene.scale_stiffness(0.3);
      break;
    case 2:
      scene.scale_stiffness(hard, 1.7);
      break;
    case 4:
      scene.scale_stiffness(1.0);
      break;
    case 5:
      scene.scale_stiffness(hard, 2.3);
      break;
    default:
      break;
  }
}

TEST_P(GlStiffness, IsTheMirrorsBitByBitAndTheReferences) {
  const int steps = sanitized ? 10 : 60;
  for (const Body& body : bodies_of_two_materials()) {
    SCOPED_TRACE(body.name);
    Scene scene = Scene(body.model).fix("x0").gravity({0, -9.81, 0});
    const auto tables = tables_of(body.model, {});
    const GlTrio trio = trio_of(tables, scene, {.damping = {.factor = 0.99}});
    trio.reset(random_state(body.model, 0.05, 0.0, 5));
    const double dt = 0.15 * trio.reference->stable_step();
    for (int call = 0; call < 7; ++call) {
      change(scene, call);
      trio.step(steps, dt, "call " + std::to_string(call));
      EXPECT_LE(trio.apart(), 1e-5 * body_size(body.model)) << "call " << call;
      const Energy a = trio.twins.gl->energy(), b = trio.reference->energy();
      EXPECT_NEAR(a.elastic, b.elastic, 1e-5 * b.elastic);
    }
  }
}

/// The same passes with factors and without; a scene that has had some goes on as one that never had.
TEST_P(GlStiffness, AddsNoPassAndLeavesNothing) {
  const Model model = bodies_of_two_materials()[0].model;
  const auto tables = tables_of(model, {});
  Scene plain(model), scaled(model);
  const SolverOptions profiled{.spectrum = estimate_spectrum(*tables, tables->rest), .profile = true};
  gl::DeviceSolver one(GetParam(), tables, plain, profiled), other(GetParam(), tables, scaled, profiled);
  const double dt = 0.3 * one.stable_step();
  const State start = random_state(model, 0.05, 0.0, 5);
  const auto run = [&](gl::DeviceSolver& solver) {
    solver.reset(start);
    solver.clear_profile();
    EXPECT_TRUE(solver.step(40, dt).ok());
    return solver.read();
  };
  const State moved = run(one);
  scaled.scale_stiffness(0.5);
  EXPECT_NE(difference(run(other), moved), "");
  EXPECT_EQ(runs_of(other), runs_of(one));
  scaled.scale_stiffness(1.0);
  EXPECT_EQ(difference(run(other), moved), "");
  EXPECT_EQ(runs_of(other), runs_of(one));
}

/// Many more domains than a line of a texture has texels, of three materials.
TEST_P(GlStiffness, FactorsReachTheirDomains) {
  Model model = with_material(make_block({0.08, 0.05, 0.05}, 16, 10, 10));
  set_material(model, {20e3, 0.3, 1000.0}, [](const Vec3& x) { return x.x() < 0.03; });
  set_material(model, hard, [](const Vec3& x) { return x.z() < 0.02; });
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  scene.scale_stiffness({0.2, 3.0, 0.6});
  const GlTrio trio = trio_of(tables_of(model, {}), scene);
  trio.reset(random_state(model, 0.05, 0.0, 9));
  trio.step(10, 0.3 * trio.reference->stable_step());
  EXPECT_LE(trio.apart(), 1e-6 * body_size(model));
}

}  // namespace
}  // namespace phymul::test
