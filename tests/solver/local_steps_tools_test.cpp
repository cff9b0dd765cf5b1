// SPDX-License-Identifier: MIT
//
// SolverOptions::max_substeps under tools: a tumour at the top of a soft cube.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>

#include "support/bodies.h"

namespace phymul::test {
namespace {

const Vec3 tumour_top(0.05, 0.05, 0.1);  // m

Model tumour_at_the_top() {
  Model model = with_material(make_tetrahedral_block({0.1, 0.1, 0.1}, 6, 6, 6, 0.2, 7), {5e3, 0.45, 1000.0});
  set_material(model, {500e3, 0.45, 1000.0}, [](const Vec3& place) { return (place - tumour_top).norm() < 0.0168; });
  return model;
}

/// Critical damping takes a shorter step than the one that it was chosen for.
TEST(LocalStepsUnderTools, ComeToRest) {
  SimulationOptions options{.backend = "cpu"};
  options.solver.max_substeps = 32;
  Simulation sim(tumour_at_the_top(), options);
  sim.scene().fix("z0").add_tool("ball",
                                 {.shape = Sphere{0.03}, .pose = {.position = tumour_top + Vec3(0, 0, 0.03 - 0.002)}});
  ASSERT_GT(sim.solver().substeps(), 2);
  const RestResult rest = sim.run_to_rest(5'000);
  EXPECT_TRUE(rest.converged()) << rest.message();
}

/// m/s, the largest in the 50 ms after a particle that was pulled by 5 mm is let go.
double speed_of_release(const char* backend, const Model& model, int substeps) {
  Scene scene = Scene(model).fix("z0");
  const Index pulled = model.particles_in([](const Vec3& at) { return (at - tumour_top).norm() < 0.012; }).front();
  const auto pose = [&](double by) { return ToolPose{.position = model.rest[pulled] + Vec3(0, 0, 0.0035 + by)}; };
  scene.add_tool("jaw", {.shape = Sphere{0.003}, .pose = pose(0.0)});
  const auto solver = make_solver(backend, model, scene, {}, {.damping = {.rate = 40.0}, .max_substeps = substeps});
  scene.tool("jaw").grasp(0.001);
  const double dt = 0.5 * solver->stable_step();
  const int steps = static_cast<int>(0.5 / dt);
  for (int k = 0; k < steps; ++k) {
    scene.tool("jaw").move_to(pose(5e-3 * std::min(1.0, 2.0 * k / steps)));
    EXPECT_TRUE(solver->step(1, dt).ok());
  }
  EXPECT_EQ(solver->held("jaw"), 1);
  scene.tool("jaw").release();
  double speed = 0.0;
  for (double t = 0.0; t < 0.05; t += dt) {
    const StepReport report = solver->step(1, dt);
    EXPECT_TRUE(report.ok() && !report.force_clamped);
    speed = std::max(speed, report.max_speed);
  }
  return speed;
}

TEST(LocalStepsUnderTools, LetGoWithoutAKick) {
  const Model model = tumour_at_the_top();
  for (const char* const backend : {"reference", "cpu"}) {
    EXPECT_LT(speed_of_release(backend, model, 32), 1.3 * speed_of_release(backend, model, 1)) << backend;
  }
}

}  // namespace
}  // namespace phymul::test
