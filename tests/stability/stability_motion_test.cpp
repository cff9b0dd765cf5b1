// SPDX-License-Identifier: MIT
//
// Motion that is fast, long, far away, sudden or in tune with the body: bounded or reported.
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <thread>

#include "stability_fixture.h"
#include "support/dense_operator.h"

namespace phymul::test {
namespace {

Model tissue_block(double young = 10e3, double poisson = 0.3) {
  return with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2), {young, poisson, 1000.0});
}

class StabilityMotion : public OnBackend {
 protected:
  static int steps(int wanted) { return is_slow() ? wanted / 10 : wanted; }
};

TEST_P(StabilityMotion, RestIsReachedWithAnyDamping) {
  const Model model = tissue_block();
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -1});
  VecList first;
  for (const double d : {0.0, 0.5, 0.9, 0.99}) {
    const auto solver = make(model, scene, {}, {.damping = {.factor = d}, .rest_tolerance = 1e-6});
    EXPECT_TRUE(has_converged(solver->run_to_rest(40000, 0.5 * solver->stable_step()))) << d;
    const VecList end = solver->read().position;
    if (first.empty()) first = end;
    EXPECT_LE(position_error(model, end, first).global_ratio, 1e-2) << d;
  }
}

TEST_P(StabilityMotion, TurnedBodiesStayAtRest) {
  const Model model = tissue_block();
  const Scene scene(model);
  const auto solver = make(model, scene);
  for (const double degrees : {1.0, 90.0, 180.0}) {
    State state = rest_state(model);
    const Mat3 turn = Eigen::AngleAxisd(degrees * M_PI / 180.0, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    for (Vec3& p : state.position) p = turn * p;
    solver->reset(state);
    ASSERT_TRUE(solver->step(200, 0.5 * solver->stable_step()).ok());
    const double moved = (solver->read().position.back() - state.position.back()).norm();
    EXPECT_LE(moved, (is_reference() ? 1e-12 : 1e-4) * mean_spacing(model)) << degrees;
  }
}

/// 10 rad/s of tissue, 1000 rad/s of something stiff: strains of 1e-2 and 1e-3.
TEST_P(StabilityMotion, ASpinKeepsItsAngularMomentum) {
  for (const auto& [young, spin] : {std::pair{10e3, 10.0}, std::pair{1e9, 1000.0}}) {
    const Model model = tissue_block(young);
    const Scene scene(model);
    const auto solver = make(model, scene);
    State state = rest_state(model);
    const Vec3 centre = centre_of_mass(model, state), axis(0, 0, spin);
    for (std::size_t i = 0; i < state.velocity.size(); ++i) state.velocity[i] = axis.cross(model.rest[i] - centre);
    solver->reset(state);
    const Vec3 before = solver->momentum(centre).angular;
    const StepReport report = solver->step(steps(20000), 0.5 * solver->stable_step());
    ASSERT_TRUE(report.ok());
    EXPECT_FALSE(report.force_clamped);
    EXPECT_LE((solver->momentum(centre).angular - before).norm(), (is_reference() ? 1e-10 : 1e-3) * before.norm());
    EXPECT_LT(distance_from_rest_shape(model, solver->read().position), 0.1);
  }
}

/// Tissue at 1000 rad/s wants to stretch tenfold: bounded, and what was cut is said.
TEST_P(StabilityMotion, ASpinBeyondTheWavesIsBoundedAndSaid) {
  const Model model = tissue_block();
  const Scene scene(model);
  const auto solver = make(model, scene);
  State state = rest_state(model);
  for (std::size_t i = 0; i < state.velocity.size(); ++i) state.velocity[i] = Vec3(0, 0, 1000).cross(model.rest[i]);
  solver->reset(state);
  const StepReport report = solver->step(steps(5000), 0.2 * solver->stable_step());
  EXPECT_TRUE(!report.ok() || report.force_clamped) << report.message();
  EXPECT_TRUE(is_finite(solver->read()));
}

TEST_P(StabilityMotion, FarFromTheOriginIsAsNear) {
  VecList near;
  for (const double away : {0.0, 1.0, 1e3, 1e6}) {
    const Model model = with_material(phymul::moved(tissue_block(), {away, -away, away}));
    Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
    const auto solver = make(model, scene);
    ASSERT_TRUE(solver->step(steps(2000), 0.4 * solver->stable_step()).ok());
    VecList moved = solver->read().position;
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] -= model.rest[i];
    if (near.empty()) near = moved;
    // Rest edges have 2^-53 of the distance: 1e-8 of a spacing at 10^6 m.
    EXPECT_LE(largest_distance(moved, near), std::max(1e-5, 1e-10 * away) * mean_spacing(model)) << away;
  }
}

/// A million steps at rest: in single precision not a bit, in double the rounding of the rest shape.
TEST_P(StabilityMotion, ALongRestDoesNotCreep) {
  const Model model = make_tetrahedron(0.01);
  const Scene scene(model);
  const auto solver = make(model, scene);
  const StepReport report = solver->step(steps(is_slow() ? 20000 : 1000000), 0.5 * solver->stable_step());
  EXPECT_TRUE(report.ok() && report.at_rest);
  const double moved = displacement_norms(model, solver->read()).max;
  EXPECT_LE(moved, is_reference() ? 1e-12 * mean_spacing(model) : 0.0);
}

TEST_P(StabilityMotion, ALongUndampedSwingKeepsItsEnergy) {
  const Model model = make_tetrahedron(0.01);
  const Scene scene(model);
  const auto solver = make(model, scene);
  State state = rest_state(model);
  state.position[3] *= 1.01;
  solver->reset(state);
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(1, dt).ok());
  const double before = solver->energy().total();
  double drift = 0.0;
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(solver->step(steps(is_slow() ? 1000 : 50000), dt).ok());
    drift = std::max(drift, std::abs(solver->energy().total() / before - 1.0));
  }
  std::printf("%s: energy within %.2g over the swing\n", GetParam().c_str(), drift);
  EXPECT_LT(drift, 0.01);
}

/// A block flies at its fixed face: at a tenth of the wave speed an elastic bounce, at 3 and 30 times it a crash that
/// stays finite, is told of, and comes back to the rest shape.
TEST_P(StabilityMotion, AnImpactGainsNoEnergyAndTheBodyReturns) {
  const Model model = tissue_block();
  Scene scene = Scene(model).fix("x0");
  for (const double speed : {0.3, 10.0, 100.0}) {
    for (const double d : {1.0, 0.99}) {
      const auto solver = make(model, scene, {}, {.damping = {.factor = d}});
      State state = rest_state(model);
      for (Vec3& v : state.velocity) v.x() = -speed;
      for (const Index i : model.group("x0")) state.velocity[i].setZero();
      solver->reset(state);
      const double energy = kinetic_energy(model, state), dt = 0.5 * solver->stable_step();
      bool cut = false;
      for (int k = 0; k < 20; ++k) {
        const StepReport report = solver->step(steps(500), dt);
        ASSERT_TRUE(report.ok()) << speed << ": " << report.message();
        cut = cut || report.force_clamped;
        if (d < 1.0 || cut) continue;
        EXPECT_LE(solver->energy().total(), 1.01 * energy) << speed;
      }
      EXPECT_TRUE(is_finite(solver->read()));
      EXPECT_EQ(cut, speed > 1.0) << speed;
      if (d < 1.0 && !is_slow()) {
        EXPECT_LT(distance_from_rest_shape(model, solver->read().position), 0.01) << speed;
      }
    }
  }
}

/// 30, 100 and 1000 times the weight, all at once, on a cantilever of every method: numbers, or a reason. From the
/// first the calibrated come back; the last is more than the largest push, and the report says that it was met.
TEST_P(StabilityMotion, ASuddenLoadIsBornOrReported) {
  for (const Method& method : stability_methods()) {
    const Model model = of_tissue(make_block({0.04, 0.02, 0.02}, 4, 2, 2, method.valence), method);
    for (const double gravity : {294.0, 981.0, 9810.0}) {
      Scene scene = Scene(model).fix("x0").gravity({0, 0, -gravity});
      const auto solver = make(model, scene, method.options, {.damping = {.factor = 0.99}});
      const double dt = 0.5 * solver->stable_step();
      StepReport report = solver->step(steps(1000), dt);
      EXPECT_TRUE(is_finite(solver->read())) << method.name;
      if (!report.ok()) {
        EXPECT_EQ(report.status, StepStatus::not_finite);
        EXPECT_FALSE(is_conservative(method)) << method.name << ": " << report.message();
        continue;
      }
      if (!method.material) continue;
      if (gravity > 1000.0) {
        EXPECT_TRUE(report.force_clamped) << method.name << ": " << report.message();
        continue;
      }
      if (gravity > 300.0 || is_slow()) continue;
      scene.gravity({0, 0, 0});
      report = solver->step(12000, dt);
      ASSERT_TRUE(report.ok()) << method.name << ": " << report.message();
      EXPECT_LT(distance_from_rest_shape(model, solver->read().position), 0.01) << method.name;
    }
  }
}

/// Driven at its first frequency, undamped, a beam swings wider with every period; damped it reaches its bound.
TEST_P(StabilityMotion, AtResonanceDampingBounds) {
  const Model model = with_material(make_block({0.04, 0.01, 0.01}, 4, 1, 1));
  std::vector<std::uint8_t> fixed(model.rest.size(), 0);
  for (const Index i : model.group("x0")) fixed[i] = 7;
  double first = std::numeric_limits<double>::infinity();
  const Eigen::VectorXcd values = dense_eigenvalues(build_topology(model), model.rest, fixed);
  for (const std::complex<double>& value : values) {
    if (value.real() > 1e-3 * values.cwiseAbs().maxCoeff() / 1e4) first = std::min(first, value.real());
  }
  const double omega = std::sqrt(first), period = 2 * M_PI / omega;
  Load shaking{.type = LoadType::acceleration, .particles = every_particle(model), .direction = {0, 0, 1}};
  const double amount = 2e-3 * 0.01 * first;  // held still it would bend by a five-hundredth of a spacing
  for (int k = 0; k <= 24 * 40; ++k) {
    shaking.events.push_back({k * period / 24, amount * std::sin(2 * M_PI * k / 24)});
  }
  Scene scene = Scene(model).fix("x0").add(shaking);
  const auto widest = [&](double rate, int from, int to) {
    const auto solver = make(model, scene, {}, damped(rate));
    const double dt = 0.5 * solver->stable_step();
    double width = 0.0;
    for (int quarter = 0; quarter < 4 * to; ++quarter) {
      EXPECT_TRUE(solver->step(static_cast<int>(period / 4 / dt), dt).ok());
      if (quarter >= 4 * from) width = std::max(width, displacement_norms(model, solver->read()).max);
    }
    return width;
  };
  EXPECT_GT(widest(0.0, 6, 8), 2.0 * widest(0.0, 2, 4) * 0.8);
  const int late = 20;
  const double rate = 0.3 * omega;
  EXPECT_NEAR(widest(rate, late - 4, late - 2), widest(rate, late - 2, late), 0.1 * widest(rate, late - 2, late));
}

/// Steps from half the limit down to a five-hundredth of it: the distance to double precision grows no faster than the
/// square root of the number of steps, as independent roundings add up.
TEST_P(StabilityMotion, SmallStepsDoNotLoseDigits) {
  const Model model = tissue_block();
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  const auto solver = make(model, scene), exact = make_solver("reference", model, scene);
  const double time = 40 * solver->stable_step();
  std::vector<double> errors;
  for (const double share : {0.5, 0.1, 0.02, 0.002}) {
    if (is_slow() && share < 0.1) continue;
    const int count = static_cast<int>(40 / share);
    solver->reset();
    exact->reset();
    ASSERT_TRUE(all_step(count, time / count, solver, exact));
    errors.push_back(position_error(model, solver->read().position, exact->read().position).global_ratio);
  }
  std::printf("%s: distance from double over steps ever smaller:", GetParam().c_str());
  for (const double error : errors) std::printf(" %.2g", error);
  std::printf("\n");
  const std::array<double, 4> roots{1.0, std::sqrt(5.0), 5.0, std::sqrt(250.0)};
  for (std::size_t k = 0; k < errors.size(); ++k) EXPECT_LE(errors[k], is_reference() ? 0.0 : 1.5e-5 * roots[k]);
}

/// A particle pushed through the body by the length of a cell, and one carried off by ten body lengths within a step,
/// both let go.
TEST_P(StabilityMotion, PushedAndPulledParticlesComeBack) {
  const Model model = tissue_block();
  for (const double length : {0.01, 0.3}) {
    Scene scene(model);
    const Load push{.type = LoadType::translation,
                    .particles = {model.group("x1").front()},
                    .events = {{0.0, length}},
                    .direction = {length < 0.1 ? -1.0 : 1.0, 0, 0}};
    scene.fix("x0").add(push);
    const auto solver = make(model, scene, {}, {.damping = {.factor = 0.99}});
    const double dt = 0.5 * solver->stable_step();
    StepReport report = solver->step(steps(1000), dt);
    ASSERT_TRUE(report.ok()) << report.message();
    const State pushed = solver->read();
    EXPECT_NEAR(std::abs(pushed.position[push.particles[0]].x() - model.rest[push.particles[0]].x()), length, 1e-6);
    // The neighbours stay within the body's length of their places.
    for (const Index j :
         std::vector<Index>(model.neighbours.begin(push.particles[0]), model.neighbours.end(push.particles[0]))) {
      EXPECT_LT((pushed.position[j] - model.rest[j]).norm(), length + 0.03);
    }
    scene.remove(1);
    report = solver->step(is_slow() ? 2000 : 8000, dt);
    ASSERT_TRUE(report.ok()) << report.message();
    EXPECT_LT(distance_from_rest_shape(model, solver->read().position), 0.01) << length;
  }
}

TEST_P(StabilityMotion, TwoSolversAtOnceAreIndependent) {
  if (GetParam().starts_with("gl")) GTEST_SKIP() << "GlEquivalence.FourSolversInFourThreads does this";
  const Model model = tissue_block();
  const Scene scene(model);
  const auto run = [&](int count) {
    const auto solver = make(model, scene);
    solver->reset(displaced(model, 0.05, 2));
    EXPECT_TRUE(solver->step(count, 0.4 * solver->stable_step()).ok());
    return solver->read();
  };
  const State short_run = run(100), long_run = run(150);
  State first, second;
  std::thread one([&] { first = run(100); }), two([&] { second = run(150); });
  one.join();
  two.join();
  EXPECT_EQ(first, short_run);
  EXPECT_EQ(second, long_run);
}

PHYMUL_ON_EVERY_BACKEND(StabilityMotion);

}  // namespace
}  // namespace phymul::test
