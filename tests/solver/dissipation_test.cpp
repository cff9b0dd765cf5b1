// SPDX-License-Identifier: MIT
//
// Materials that dissipate (Material::retardation_time, relaxation_strength), held against closed forms of the
// Kelvin-Voigt body and of the standard linear solid: Findley, Lai and Onaran, Creep and Relaxation of Nonlinear
// Viscoelastic Materials, 1976, ch. 5.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <array>
#include <cmath>
#include <numbers>

#include "support/bodies.h"
#include "support/every_backend.h"

namespace phymul {
namespace {

using namespace test;

class DissipationOn : public OnEveryBackend {};
PHYMUL_ON_EVERY_BACKEND(DissipationOn);

void load_along_x(Scene& scene, LoadType type, const char* group, std::vector<ValueEvent> events,
                  std::array<Axis, 3> axes) {
  scene.add({.type = type,
             .particles = scene.model().group(group),
             .events = std::move(events),
             .axes = axes,
             .direction = Vec3::UnitX()});
}

/// On rollers, so that its sides are free to move.
void hold_on_rollers(Scene& scene) {
  constexpr Axis held = Axis::held, free = Axis::free;
  load_along_x(scene, LoadType::translation, "x0", {{0.0, 0.0}}, {held, free, free});
  load_along_x(scene, LoadType::translation, "y0", {{0.0, 0.0}}, {free, held, free});
  load_along_x(scene, LoadType::translation, "z0", {{0.0, 0.0}}, {free, free, held});
}

double mean_x(const Solver& solver, const char* group) {
  const State state = solver.read();
  const std::vector<Index> particles = solver.model().group(group);
  double sum = 0.0;
  for (const Index i : particles) sum += state.position[i].x() - solver.model().rest[i].x();
  return sum / static_cast<double>(particles.size());
}

void run_to(Solver& solver, double time) {
  const int steps = static_cast<int>(std::ceil((time - solver.time()) / (0.5 * solver.stable_step())));
  ASSERT_TRUE(is_ok(solver.step(steps, (time - solver.time()) / steps)));
}

/// Over a ramp from 0 to 1 in `ramp` s, then constant: 1 less `share` of what decays with `tau`, at `time` after it.
double after_ramp(double share, double tau, double ramp, double time) {
  return 1.0 - share * tau / ramp * (std::exp(ramp / tau) - 1.0) * std::exp(-time / tau);
}

TEST_P(DissipationOn, CreepIsThatOfTheStandardLinearSolid) {
  Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  const double young = 10e3, strength = 1.0, tau = 0.5, stress = 10.0, ramp = 0.3;
  set_material(
      model,
      {.young = young, .poisson = 0.3, .density = 1000, .relaxation_strength = strength, .relaxation_time = tau});
  Scene scene(model);
  hold_on_rollers(scene);
  load_along_x(scene, LoadType::pressure, "x1", {{0.0, 0.0}, {ramp, stress}}, {Axis::driven, Axis::free, Axis::free});
  const auto solver = make_solver(GetParam(), model, scene, {}, {.damping = {.rate = 20}});
  for (const double time : {0.6, 1.0, 2.0, 4.0}) {
    run_to(*solver, time);
    const double slow = (1.0 + strength) * tau;
    const double expected = stress / young * after_ramp(strength / (1.0 + strength), slow, ramp, time);
    EXPECT_NEAR(mean_x(*solver, "x1") / 0.02 / expected, 1.0, 0.01) << time << " s";
  }
}

/// A cell that does not dissipate carries the same stress as one that does, and shows it by its length.
TEST_P(DissipationOn, StressRelaxesAsInTheStandardLinearSolid) {
  Model model = make_block({0.02, 0.01, 0.01}, 2, 1, 1);
  const double young = 10e3, gauge = 40e3, strength = 1.5, tau = 0.4, pull = 2e-5, ramp = 0.2;
  set_material(
      model,
      {.young = young, .poisson = 0.0, .density = 1000, .relaxation_strength = strength, .relaxation_time = tau});
  set_material(model, {.young = gauge, .poisson = 0.0, .density = 1000}, [](const Vec3& x) { return x.x() > 0.01; });
  Scene scene(model);
  hold_on_rollers(scene);
  load_along_x(scene, LoadType::translation, "x1", {{0.0, 0.0}, {ramp, pull}}, {Axis::driven, Axis::free, Axis::free});
  const auto solver = make_solver(GetParam(), model, scene, {}, {.damping = {.rate = 20}});
  // In series compliances add up; the branch creeps with (1 + strength) tau, and relaxes faster by their ratio.
  const double at_once = 1.0 / ((1.0 + strength) * young) + 1.0 / gauge, lasting = 1.0 / young + 1.0 / gauge;
  const double fast = (1.0 + strength) * tau * at_once / lasting;
  const std::vector<Index> middle = model.particles_in([](const Vec3& X) { return std::abs(X.x() - 0.01) < 1e-6; });
  for (const double time : {0.3, 0.6, 1.2, 2.4}) {
    run_to(*solver, time);
    const double stress = gauge * (pull - (solver->read().position[middle.front()].x() - 0.01)) / 0.01;
    // The mean over the ramp of 1 / lasting + (1 / at_once - 1 / lasting) exp(-t / fast).
    const double expected = pull / 0.01 / lasting * after_ramp(1.0 - lasting / at_once, fast, ramp, time);
    EXPECT_NEAR(stress / expected, 1.0, 0.01) << time << " s";
  }
}

/// The fundamental vibration of a bar, sin(pi x / 2 L), decays as exp(-w^2 T / 2 t).
TEST_P(DissipationOn, VibrationsDecayAsInTheKelvinVoigtBody) {
  const double length = 0.1, young = 10e3, T = 2e-3, wave = std::numbers::pi / (2.0 * length);
  const Model model = with_material(make_block({length, 0.005, 0.005}, 20, 1, 1),
                                    {.young = young, .poisson = 0.0, .density = 1000, .retardation_time = T});
  Scene scene(model);
  hold_on_rollers(scene);
  const auto solver = make_solver(GetParam(), model, scene);
  const double omega = wave * std::sqrt(young / 1000.0);
  State state = rest_state(model);
  for (Vec3& x : state.position) x.x() += 1e-4 * std::sin(wave * x.x());
  const double dt = 1e-4;
  solver->start(state, dt);
  const auto amplitude = [&] {  // of the mode; velocities are those half a step before
    double u = 0.0, v = 0.0, norm = 0.0;
    const State now = solver->read();
    for (std::size_t i = 0; i < now.position.size(); ++i) {
      const double shape = model.mass[i] * std::sin(wave * model.rest[i].x());
      u += shape * (now.position[i].x() - model.rest[i].x() - 0.5 * dt * now.velocity[i].x());
      v += shape * now.velocity[i].x();
      norm += shape * std::sin(wave * model.rest[i].x());
    }
    const double damped = omega * std::sqrt(1.0 - omega * omega * T * T / 4.0);
    return std::hypot(u, (v + 0.5 * omega * omega * T * u) / damped) / norm;
  };
  ASSERT_TRUE(solver->step(200, dt).ok());
  const double before = amplitude();
  ASSERT_TRUE(solver->step(4000, dt).ok());
  EXPECT_NEAR(std::log(before / amplitude()) / (0.5 * omega * omega * T * 4000 * dt), 1.0, 0.01);
}

struct Spun {
  double momentum, rate, shift;  ///< about z, over those at the start; centre of mass over the body's length
};

/// Of a free block that turns about z by 0.8 rad.
Spun spin(const char* backend, double rate, double dt, double T, double strength) {
  const Model model = with_material(make_block({0.02, 0.01, 0.01}, 2, 1, 1), {.young = 10e3,
                                                                              .poisson = 0.3,
                                                                              .density = 1000,
                                                                              .retardation_time = T,
                                                                              .relaxation_strength = strength,
                                                                              .relaxation_time = 0.1});
  const Scene scene(model);
  const auto solver = make_solver(backend, model, scene);
  const Vec3 centre(0.01, 0.005, 0.005);
  const auto now = [&] {
    Spun spun{solver->momentum(centre).angular.z(), 0.0, 0.0};
    double inertia = 0.0;
    Vec3 mean = Vec3::Zero();
    const State state = solver->read();
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      inertia += model.mass[i] * (state.position[i] - centre).head<2>().squaredNorm();
      mean += (state.position[i] - centre) / static_cast<double>(state.position.size());
    }
    spun.rate = spun.momentum / inertia;
    spun.shift = mean.norm() / 0.02;
    return spun;
  };
  State state = rest_state(model);
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    state.velocity[i] = rate * Vec3::UnitZ().cross(model.rest[i] - centre);
  }
  solver->reset(state);
  const Spun before = now();
  EXPECT_TRUE(solver->step(static_cast<int>(0.8 / (rate * dt)), dt).ok());
  EXPECT_GT((solver->read().position[0] - model.rest[0]).norm(), 0.005);
  const Spun after = now();
  return {after.momentum / before.momentum, after.rate / before.rate, after.shift};
}

TEST(Dissipation, DoesNotBrakeASpin) {
  // So slow that its own pull stretches it by less than 1e-6.
  const Spun spun = spin("reference", 0.1, 2e-4, 5e-3, 1.0);
  EXPECT_NEAR(spun.momentum, 1.0, 1e-9);
  EXPECT_NEAR(spun.rate, 1.0, 1e-6);
  EXPECT_LT(spun.shift, 1e-9);
  // In single precision the sums of a step are rounded, with and without dissipation.
  EXPECT_NEAR(spin("cpu", 10.0, 2e-4, 5e-3, 1.0).momentum, spin("cpu", 10.0, 2e-4, 0.0, 0.0).momentum, 2e-6);
}

/// Without a stabiliser the viscous stiffness is the elastic one times a constant, and the limit is exact.
TEST(Dissipation, SetsTheStepLimit) {
  Material plain{.young = 10e3, .poisson = 0.3, .density = 1000};
  const auto with = [&](double T, double strength, double tau) {
    Material material = plain;
    material.retardation_time = T;
    material.relaxation_strength = strength;
    material.relaxation_time = tau;
    return material;
  };
  double free = 0.0;
  for (const Material& material : {plain, with(1e-4, 0, 0), with(1e-2, 0, 0), with(0, 3, 1), with(1e-3, 0.5, 1)}) {
    const Model model = with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2), material);
    const Scene scene(model);
    for (const double share : {0.95, 1.05}) {
      const auto solver = make_solver("reference", model, scene, {.stabiliser = 0.0},
                                      {.on_unstable = UnstableStep::allow, .max_displacement_per_step = 1e300});
      const double limit = solver->stable_step();
      if (material == plain) free = limit;
      EXPECT_TRUE(material == plain || limit < 0.98 * free);
      EXPECT_DOUBLE_EQ(limit, stable_step(solver->topology(), estimate_spectrum(solver->topology(), model.rest), 1.0));
      EXPECT_DOUBLE_EQ(limit, body_limits(model, solver->topology()).front().stable_step);
      EXPECT_DOUBLE_EQ(limit, describe_limit(model, solver->topology(), 1).stable_step);
      solver->reset(displaced(model, 1e-7, 2));
      const bool ok = solver->step(2000, share * limit).ok();
      double strain = 0.0;
      const State now = solver->read();
      for (std::size_t i = 1; i < now.position.size(); ++i) {
        strain = std::max(strain, (now.position[i] - now.position[0] - model.rest[i] + model.rest[0]).norm() / 0.03);
      }
      EXPECT_EQ(ok && strain < 1e-4, share < 1.0) << limit << " s, " << share << ": " << strain;
    }
  }
}

}  // namespace
}  // namespace phymul
