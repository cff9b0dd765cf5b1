// SPDX-License-Identifier: MIT
//
// Verlet's scheme is of order 2 in dt: halving the step quarters the error of a trajectory. The state's velocity is
// that of half a step before its time; Solver::start takes it there. A body at rest that is reset() with zero is of
// order 1, which the last test shows.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <cmath>

#include "support/bodies.h"

namespace phymul::test {
namespace {

struct Falling {
  Model model;
  Scene scene;
  std::unique_ptr<Solver> solver;
  Vec3 weight{0, 0, 0};
  bool half_step_start = true;

  SolverOptions options;

  explicit Falling(const Variant& variant, double damping = 0.0)
      : model(prepared(variant, {"block", make_block({0.06, 0.02, 0.02}, 6, 2, 2)})), scene(model) {
    scene.fix("x0");
    options.damping.rate = damping;
    solver = make_solver("reference", model, scene, variant.options, options);
    // Bends the body by about half a spacing, whatever its stiffness and mass.
    const double omega = 2.0 / solver->stable_step();
    weight = {0, 0, -2e-4 * mean_spacing(model) * omega * omega};
    scene.gravity(weight);
  }

  double solver_damping(double dt) const { return options.damping.factor_at(dt); }

  VecList position_after(double time, int steps) {
    const double dt = time / steps;
    State state = rest_state(model);
    if (half_step_start) {
      solver->start(state, dt);
      for (Vec3& v : state.velocity) v = -dt * weight / (1.0 + solver_damping(dt));
      for (const Index i : model.group("x0")) state.velocity[i].setZero();
      EXPECT_LE(distance(solver->read().velocity, state.velocity), 1e-10 * dt * weight.norm());
    } else {
      solver->reset(state);
    }
    EXPECT_TRUE(solver->step(steps, dt).ok());
    return solver->read().position;
  }

  double distance(const VecList& a, const VecList& b) const {
    VecList difference = a;
    for (std::size_t i = 0; i < a.size(); ++i) difference[i] -= b[i];
    return norm(difference);
  }

  /// From steps of 0.4 and 0.2 of the limit, against 0.05; Richardson's correction for the reference's own error.
  double order() {
    const double time = 40 * solver->stable_step();
    const VecList fine = position_after(time, 800);
    const double coarse_error = distance(position_after(time, 100), fine);
    const double fine_error = distance(position_after(time, 200), fine);
    return std::log2(coarse_error / fine_error);
  }
};

TEST(StepOrder, TwoForEveryEnergy) {
  for (const Variant& variant : conservative_variants()) {
    Falling body(variant);
    const double order = body.order();
    // Error against a step of a quarter or an eighth of the size: (1 - 1/64) / (1/4 - 1/64) = 4.2, order 2.07.
    EXPECT_NEAR(order, 2.07, 0.15) << variant.name;
  }
}

/// The factor d takes from the velocity of half a step before: damped motion is of order 1.
TEST(StepOrder, OneWithDamping) {
  Falling undamped(conservative_variants().front());
  Falling body(conservative_variants().front(), 0.05 / undamped.solver->stable_step());
  EXPECT_NEAR(body.order(), 1.22, 0.15);  // (1 - 1/8) / (1/2 - 1/8) = 2.33
}

TEST(StepOrder, StartRefusesWhatNoStepIs) {
  Falling body(conservative_variants().front());
  const State before = body.solver->read();
  State state = rest_state(body.model);
  EXPECT_THROW(body.solver->start(state, 0.0), Error);
  state.position[3].x() = std::nan("");
  EXPECT_THROW(body.solver->start(state, 1e-4), Error);
  EXPECT_EQ(body.solver->read(), before);
}

TEST(StepOrder, OneWhereTheVelocityIsNotThatOfHalfAStepBefore) {
  Falling body(conservative_variants().front());
  body.half_step_start = false;
  EXPECT_NEAR(body.order(), 1.2, 0.2);  // (1 - 1/8) / (1/2 - 1/8) = 2.33
}

}  // namespace
}  // namespace phymul::test
