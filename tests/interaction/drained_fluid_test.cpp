// SPDX-License-Identifier: MIT
//
// Fluids that leave through an opening to the last: what stays, and when the body is at rest.
#include <gtest/gtest.h>
#include <phymul/simulation.h>

#include "support/bodies.h"
#include "support/every_backend.h"

namespace phymul::test {
namespace {

constexpr double box_volume = 1.6e-5;  // m^3

VolumeConstraint box_with(const Model& model, double volume, const Fluid& fluid) {
  return {.triangles = surface_triangles(model), .volume = volume, .applied_to = {}, .name = "box", .fluid = fluid};
}

class DrainedFluid : public OnEveryBackend {};
PHYMUL_ON_BACKENDS(DrainedFluid, (std::vector<std::string>{"reference", "cpu"}));

/// A side of the box, without stiffness, is pressed to the other one.
TEST_P(DrainedFluid, LeavesAStateAlthoughItIsPressedOut) {
  for (const FluidLaw law : {FluidLaw::incompressible, FluidLaw::gas}) {
    Model model = make_block({0.04, 0.02, 0.02}, 1, 2, 2);
    for (double& k : model.stiffness) k = 0.0;
    for (const Index i : model.group("x1")) model.mass[i] = 2e-3;
    Simulation sim(model, {.backend = GetParam()});
    Load slides{.type = LoadType::translation, .particles = model.group("x1"), .events = {{0.0, 0.0}}};
    slides.direction = {0, 1, 0};
    slides.axes = {Axis::free, Axis::held, Axis::held};
    Load press{.type = LoadType::acceleration, .particles = model.group("x1"), .events = {{0.0, 50.0}}};
    press.direction = {-1, 0, 0};
    const Fluid fluid{.law = law, .conductance = law == FluidLaw::gas ? 1e-6 : 1e-5};
    sim.scene().fix("x0").add(slides).add(press).constrain_volume(box_with(model, box_volume, fluid));
    for (int k = 0; k < 50; ++k) {
      ASSERT_TRUE(sim.step(20, 1e-4).ok());
      EXPECT_GE(sim.solver().fluid("box").volume, 0.99e-10 * box_volume);
      EXPECT_NO_THROW(sim.restore(sim.snapshot()));
    }
  }
}

/// Nothing of the body moves, but a gas of more than the box holds flows out.
TEST_P(DrainedFluid, IsNotAtRestBefore) {
  const Model model = with_material(make_block({0.04, 0.02, 0.02}, 2, 2, 2));
  Simulation sim(model, {.backend = GetParam(), .damping = {.rate = 50.0}});
  const Fluid gas{.law = FluidLaw::gas, .conductance = 1e-8};
  sim.scene().fix(every_particle(model)).constrain_volume(box_with(model, 1.25 * box_volume, gas));
  EXPECT_TRUE(sim.run_to_rest(20'000).converged());
  EXPECT_LT(sim.solver().fluid("box").pressure, 1.0);  // Pa, of 25,000 at first
  EXPECT_NEAR(sim.solver().fluid("box").volume, box_volume, 1e-4 * box_volume);
}

}  // namespace
}  // namespace phymul::test
