// SPDX-License-Identifier: MIT
//
// Small cases whose answer is known on paper: the attractor of a particle with two and with three neighbours, and two
// particles on a spring. Verlet's scheme is of order 2 in dt: halving the step quarters the error of a trajectory. The
// state's velocity is that of half a step before its time; Solver::start takes it there. A body at rest that is reset()
// with zero is of order 1, which the last test shows.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <cmath>

#include "support/bodies.h"

namespace phymul::test {
namespace {

/// Model of free-standing particles where only particle 0 has neighbours: all the others.
Model star(int dimension, VecList rest) {
  Model model;
  model.dimension = dimension;
  model.rest = std::move(rest);
  const auto n = model.rest.size();
  model.mass.assign(n, 1.0);
  model.stiffness.assign(n, 1.0);
  std::vector<Index> others;
  for (Index j = 1; j < static_cast<Index>(n); ++j) others.push_back(j);
  model.neighbours.push_row(others.begin(), others.end());
  for (std::size_t i = 1; i < n; ++i) model.neighbours.push_row(others.begin(), others.begin());
  return model;
}

TopologyOptions all_bases(Reaction reaction) {
  return {.reaction = reaction, .bases = BaseSelection::all, .on_sparse = SparseParticle::free};
}

TEST(WorkedExamples, TwoNeighboursInThePlane) {
  // P over the segment A B: its foot divides it 1 : 3, its height is 2.
  const Model model = star(2, {{1, 2, 0}, {0, 0, 0}, {4, 0, 0}});
  const TopologyTextures topology = build_topology(model, all_bases(Reaction::barycentric));
  ASSERT_EQ(topology.index[0].base_count, 1);
  EXPECT_NEAR(topology.alpha[0], 0.75, 1e-15);
  EXPECT_NEAR(topology.alpha[1], 0.25, 1e-15);
  EXPECT_NEAR(std::abs(topology.bases[0].beta), 2.0, 1e-15);

  // B moves to (0, 4): the segment stands upright, P* keeps foot and height: (0, 1) + 2 (-1, 0).
  const VecList x{{1, 2, 0}, {0, 0, 0}, {0, 4, 0}};
  VecList attractor(3), force(3);
  attractors(topology, x, attractor);
  EXPECT_LE((attractor[0] - Vec3(-2, 1, 0)).norm(), 1e-14);
  elastic_forces(topology, x, force);
  EXPECT_LE((force[0] - Vec3(-3, -1, 0)).norm(), 1e-14);
  EXPECT_LE((force[1] - 0.75 * Vec3(3, 1, 0)).norm(), 1e-14);
  EXPECT_LE((force[2] - 0.25 * Vec3(3, 1, 0)).norm(), 1e-14);
  elastic_forces(build_topology(model, all_bases(Reaction::full)), x, force);
  EXPECT_LE((force[1] - Vec3(3, 1, 0)).norm(), 1e-14);
  EXPECT_LE((force[2] - Vec3(3, 1, 0)).norm(), 1e-14);
  elastic_forces(build_topology(model, all_bases(Reaction::shared)), x, force);
  EXPECT_LE((force[1] - 0.5 * Vec3(3, 1, 0)).norm(), 1e-14);
}

TEST(WorkedExamples, ThreeNeighboursInThePlane) {
  // P at the centre of an equilateral triangle: three pairs, each with its foot at the middle, so alpha = 1/3 each.
  const double r = std::sqrt(3.0) / 2.0;
  const Model model = star(2, {{0, 0, 0}, {1, 0, 0}, {-0.5, r, 0}, {-0.5, -r, 0}});
  const TopologyTextures topology = build_topology(model, all_bases(Reaction::barycentric));
  ASSERT_EQ(topology.index[0].base_count, 3);
  for (int j = 0; j < 3; ++j) EXPECT_NEAR(topology.alpha[j], 1.0 / 3.0, 1e-15);
  for (int t = 0; t < 3; ++t) EXPECT_NEAR(std::abs(topology.bases[t].beta), 0.5, 1e-15);

  // Neighbour 1 pulled out to (4, 0). Feet: middles of the pairs; heights 0.5 along their normals, which by hand are
  // (1, 0) for the pair 2-3 and (-r, +-4.5) / sqrt(21) for the other two. Mean foot (1, 0).
  const VecList x{{0, 0, 0}, {4, 0, 0}, {-0.5, r, 0}, {-0.5, -r, 0}};
  VecList attractor(4);
  attractors(topology, x, attractor);
  const double along = 1.0 + 0.5 / 3.0 * (1.0 - 2.0 * r / std::sqrt(21.0));
  EXPECT_LE((attractor[0] - Vec3(along, 0, 0)).norm(), 1e-14);
}

TEST(WorkedExamples, ThreeNeighboursInSpace) {
  // P over the right triangle (0,0,0), (2,0,0), (0,2,0) at (0.5, 1, 3): lambda = (1/4, 1/4, 1/2), beta = 3.
  const Model model = star(3, {{0.5, 1, 3}, {0, 0, 0}, {2, 0, 0}, {0, 2, 0}});
  const TopologyTextures topology = build_topology(model, all_bases(Reaction::conservative));
  ASSERT_EQ(topology.index[0].base_count, 1);
  EXPECT_NEAR(topology.lambda[0][0], 0.25, 1e-15);
  EXPECT_NEAR(topology.lambda[0][1], 0.25, 1e-15);
  EXPECT_NEAR(topology.lambda[0][2], 0.5, 1e-15);
  EXPECT_NEAR(topology.bases[0].beta, 3.0, 1e-15);
  // The triangle doubled in its plane: the foot doubles, the height stays.
  VecList attractor(4);
  attractors(topology, VecList{{0.5, 1, 3}, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, attractor);
  EXPECT_LE((attractor[0] - Vec3(1, 2, 3)).norm(), 1e-14);
}

/// Two equal masses on a spring: x(t) - l = a cos(w t) with w^2 = 2 k / m; in Verlet's scheme the frequency is
/// 2/dt asin(w dt / 2) exactly.
TEST(WorkedExamples, TwoParticleOscillator) {
  Model model;
  model.rest = {{0, 0, 0}, {0.01, 0, 0}};
  model.mass = {0.002, 0.002};
  model.stiffness = {5.0, 5.0};
  for (Index other : {1, 0}) model.neighbours.push_row(&other, &other + 1);
  const Scene scene(model);
  const auto solver = make_solver("reference", model, scene, {.law = Law::springs});
  const double omega = std::sqrt(2.0 * 5.0 / 0.002);
  EXPECT_NEAR(solver->stable_step(), 2.0 / omega, 2e-3 * solver->stable_step());

  const double dt = 0.1 * solver->stable_step(), stretch = 0.001;
  const double discrete = 2.0 / dt * std::asin(omega * dt / 2.0);
  State start = rest_state(model);
  start.position[1].x() += stretch;
  // Velocity half a step before: (x(0) - x(-dt)) / dt of the same cosine, halved between the two.
  const double back = stretch * (1.0 - std::cos(discrete * dt)) / dt / 2.0;
  start.velocity = {{-back, 0, 0}, {back, 0, 0}};
  start.position[0].x() = 0.0;
  solver->reset(start);
  double worst = 0.0, worst_closed = 0.0;
  for (int step = 1; step <= 2000; ++step) {
    ASSERT_TRUE(solver->step(1, dt).ok());
    const State now = solver->read();
    const double gap = (now.position[1] - now.position[0]).x() - 0.01;
    worst = std::max(worst, std::abs(gap - stretch * std::cos(discrete * step * dt)) / stretch);
    if (step <= 60)
      worst_closed = std::max(worst_closed, std::abs(gap - stretch * std::cos(omega * step * dt)) / stretch);
  }
  EXPECT_LE(worst, 1e-9);  // the scheme's own closed form, 2,000 steps
  // The oscillator's own, 12 radians long: the scheme's phase runs ahead by (w dt)^2 / 24 per radian.
  EXPECT_LE(worst_closed, 1.05 * 0.04 / 24.0 * 12.0);
  // The energy with both half-step velocities is constant, at 1 - (w dt / 2)^2 of the oscillator's.
  EXPECT_NEAR(solver->energy().total(), 0.99 * 0.5 * 5.0 * stretch * stretch, 1e-4 * 0.5 * 5.0 * stretch * stretch);
}

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
