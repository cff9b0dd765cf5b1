// SPDX-License-Identifier: MIT
//
// Simulation::solve_static of walls: closed forms, and the rest shape that steps reach.
#include <gtest/gtest.h>
#include <phymul/simulation.h>

#include "support/bodies.h"
#include "support/message_of.h"
#include "support/run_scenes.h"
#include "support/wall_cases.h"

namespace phymul::test {
namespace {

/// A plate on a hinge under pressure: w = (5 + nu) / (1 + nu) p a^4 / (64 D).
TEST(WallRest, PlateBendsAsItsClosedForm) {
  constexpr double E = 1e6, nu = 0.3, t = 1e-3, a = 0.1, p = 1e-3, D = E * t * t * t / 12.0 / (1.0 - nu * nu);
  const Model model = wall_of(disc_surface(a, 10, 0.2), E, nu, t);
  Simulation sim(model);
  sim.scene().fix(model.particles_in([](const Vec3& X) { return X.norm() > a * (1.0 - 1e-9); }));
  Load pressure;
  pressure.type = LoadType::pressure;
  pressure.particles = every_particle(model);
  pressure.direction = {0, 0, 1};
  pressure.events = {{0.0, p}};
  sim.scene().add(pressure);
  const StaticResult result = sim.solve_static();
  ASSERT_TRUE(result.converged()) << result.message();
  EXPECT_LT(result.evaluations, 20);
  EXPECT_NEAR(sim.state().position[0].z(), p * a * a * a * a / (64.0 * D) * (5.0 + nu) / (1.0 + nu),
              0.01 * p * a * a * a * a / (64.0 * D) * 4.0);
}

Model sheet() {
  Model model = make_wall(grid_surface(12, 6, 0.2, [](double u, double v) { return Vec3(0.1 * u, 0.05 * v, 0); }),
                          {.material = {.young = 50e3, .poisson = 0.45, .density = 1050, .thickness = 2e-3}});
  clamp_edges(model, [](const Vec3& X) { return X.x() < 1e-6; });
  return model;
}

void expect_where_steps_lead(const Model& model, const std::function<void(Scene&)>& load, double least) {
  Simulation by_steps(model, {.backend = "reference", .damping = {.rate = 15}}), at_once(model);
  for (Simulation* sim : {&by_steps, &at_once}) {
    sim->scene().fix(model.particles_in([](const Vec3& X) { return X.x() < 1e-6; }));
    load(sim->scene());
  }
  const StaticResult result = at_once.solve_static();
  ASSERT_TRUE(result.converged()) << result.message();
  const RestResult rest = by_steps.run_to_rest();
  ASSERT_TRUE(rest.converged()) << rest.message();
  EXPECT_LE(result.evaluations, 50);
  const double way = at_once.max_displacement();
  EXPECT_GT(way, least);
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    EXPECT_LT((at_once.state().position[i] - by_steps.state().position[i]).norm(), 3e-3 * way);
  }
  // It stays there.
  ASSERT_TRUE(at_once.advance(0.01).ok());
  EXPECT_LT(at_once.energy().kinetic, 1e-8 * at_once.energy().elastic);
}

TEST(WallRest, SheetSagsFar) {
  expect_where_steps_lead(
      sheet(), [](Scene& scene) { scene.gravity(Vec3(0, 0, -0.4)); }, 0.03);
}

TEST(WallRest, SheetFollowsWhatIsImposed) {
  expect_where_steps_lead(
      sheet(),
      [](Scene& scene) {
        Load lift;
        lift.type = LoadType::translation;
        lift.particles = scene.model().particles_in([](const Vec3& X) { return X.x() > 0.1 - 1e-6; });
        lift.direction = {-0.01, 0, 0.05};
        lift.events = {{0.0, 0.051}};
        scene.add(lift);
      },
      0.05);
}

TEST(WallRest, ALoadWhoseSquareIsNotFiniteHasNoRest) {
  Simulation sim(sheet());
  sim.scene().fix(sim.model().particles_in([](const Vec3& X) { return X.x() < 1e-6; })).gravity({0, 0, -1e200});
  EXPECT_FALSE(sim.solve_static({.most_evaluations = 20}).converged());
}

TEST(WallRest, RefusesWhatItCannotDo) {
  const Model model = sheet();
  Simulation loose(model);
  EXPECT_NE(loose.solve_static().message().find("not held against every rigid motion"), std::string::npos);
  Simulation with_tool(model);
  with_tool.scene().add_tool(Sphere{0.01});
  EXPECT_NE(message_of([&] { with_tool.solve_static(); }).find("walls, and the scene has tools"), std::string::npos);
  Model block = with_material(make_block({0.04, 0.02, 0.02}, 4, 2, 2));
  add_capsule(block, model.materials.front());
  Simulation capsule(block);
  EXPECT_NE(message_of([&] { capsule.solve_static(); }).find("got both in one model"), std::string::npos);
}

}  // namespace
}  // namespace phymul::test
