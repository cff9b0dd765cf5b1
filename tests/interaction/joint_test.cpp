// SPDX-License-Identifier: MIT
//
// Joints against closed forms: vibrations, the step limit, a hanging chain, breaking.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "solver/half_step.h"
#include "support/joined_particles.h"
#include "support/message_of.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

class JointIn : public WithTools {
 protected:
  std::unique_ptr<Solver> make(const Model& model, const Scene& scene, const SolverOptions& options = {}) const {
    return loose_solver(GetParam(), model, scene, options);
  }
};
PHYMUL_ON_EVERY_BACKEND(JointIn);

constexpr double bead_mass = 0.01, spring_stiffness = 40.0;  // kg, N/m
const double omega = std::sqrt(spring_stiffness / bead_mass);

/// A particle at the origin, held there by a spring, that starts `x` away.
struct Oscillator {
  Oscillator(double damping, double rest_length = 0.0) {
    scene.add_joint({at_particle(0), at_world({-rest_length, 0, 0}), rest_length}, spring_stiffness, damping);
  }
  void start(Solver& solver, double x) const {
    State state = rest_state(model);
    state.position[0].x() = x;
    solver.reset(state);
  }
  Model model = loose_particles({Vec3(0, 0, 0)}, bead_mass);
  Scene scene{model};
};

/// s, between the first and the last of so many downward passes through 0, over their number; interpolated.
double period_of(Solver& solver, double dt, int passes) {
  double first = 0.0, before = solver.read().position[0].x();
  for (int found = 0; found <= passes;) {
    EXPECT_TRUE(solver.step(1, dt).ok());
    const double x = solver.read().position[0].x();
    if (before > 0.0 && x <= 0.0) {
      const double when = solver.time() - dt * x / (x - before);
      if (found == 0) first = when;
      if (found++ == passes) return (when - first) / passes;
    }
    before = x;
  }
  return 0.0;
}

TEST_P(JointIn, AParticleVibratesWithItsPeriod) {
  for (const double rest_length : {0.0, 0.03}) {
    const Oscillator body(0.0, rest_length);
    const auto solver = make(body.model, body.scene);
    body.start(*solver, 0.01);
    const double period = period_of(*solver, 0.05 / omega, 20), exact = 2.0 * std::numbers::pi / omega;
    EXPECT_NEAR(period / exact, 1.0, 2e-4) << rest_length;
  }
}

TEST_P(JointIn, ADamperLetsAVibrationDecay) {
  const double share = 0.1;  // of the critical damping
  const Oscillator body(2.0 * share * bead_mass * omega);
  const auto solver = make(body.model, body.scene);
  body.start(*solver, 0.01);
  const double dt = 0.002 / omega, damped = omega * std::sqrt(1.0 - share * share);
  const int steps = static_cast<int>(std::lround(2.0 * std::numbers::pi / damped / dt));  // one period
  ASSERT_TRUE(solver->step(steps, dt).ok());
  EXPECT_NEAR(solver->read().position[0].x() / 0.01, std::exp(-share * omega * steps * dt), 0.005);
}

TEST_P(JointIn, ABodyOnItsMeanVibratesAsOneMass) {
  Model model = with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2));
  Scene scene(model);
  const Vec3 centre(0.01, 0.01, 0.01);
  const double k = 2.0;
  Anchor mean = at_mean(every_particle(model));
  for (std::size_t i = 0; i < model.rest.size(); ++i) mean.weights[i] = model.mass[i] / total_mass(model);
  scene.add_joint({mean, at_world(centre), 0.0}, k);
  const auto solver = make_solver(GetParam(), model, scene);
  State state = rest_state(model);
  for (Vec3& x : state.position) x.x() += 0.005;
  const double period = 2.0 * std::numbers::pi * std::sqrt(total_mass(model) / k), dt = 0.5 * solver->stable_step();
  solver->start(state, dt);
  const int steps = static_cast<int>(std::lround(0.25 * period / dt));
  ASSERT_TRUE(solver->step(steps, dt).ok());
  double x = -centre.x();
  const State end = solver->read();
  for (std::size_t i = 0; i < model.rest.size(); ++i) x += mean.weights[i] * end.position[i].x();
  EXPECT_NEAR(x / 0.005, std::cos(2.0 * std::numbers::pi * steps * dt / period), 2e-3);
}

TEST_P(JointIn, TheStepLimitOfAParticleIsExact) {
  for (const double damping : {0.0, 0.4, 2.0}) {
    const Oscillator body(damping);
    const auto solver = make(body.model, body.scene, {.on_unstable = UnstableStep::allow});
    const double c = damping / bead_mass;
    const double limit = 4.0 / (c + std::sqrt(c * c + 4.0 * omega * omega));
    EXPECT_NEAR(solver->stable_step() / limit, 1.0, 1e-12);
    const auto largest_after = [&](double dt) {
      body.start(*solver, 0.01);
      double largest = 0.0;
      for (int step = 0; step < 2000; ++step) {
        if (!solver->step(1, dt).ok()) return 1e9;
        largest = std::max(largest, std::abs(solver->read().position[0].x()));
      }
      return largest;
    };
    EXPECT_LT(largest_after(0.95 * limit), 0.1) << damping;
    EXPECT_GT(largest_after(1.05 * limit), 1e3) << damping;
  }
}

TEST_P(JointIn, AStiffJointLowersTheLimitOfABody) {
  const Model model = with_material(make_block({0.04, 0.04, 0.04}, 4, 4, 4));
  Scene scene(model);
  const auto solver = make_solver(GetParam(), model, scene);
  const double alone = solver->stable_step(), k = 1000.0 * 10e3 * 0.01;  // of E times the spacing
  const Index corner = model.group("x1").front();
  const JointHandle joint = scene.add_joint({at_particle(corner), at_world({0.05, 0, 0})}, k);
  const double of_joint = 2.0 * std::sqrt(model.mass[corner] / k);
  const double predicted = 1.0 / std::sqrt(1.0 / (alone * alone) + 1.0 / (of_joint * of_joint));
  EXPECT_NEAR(solver->stable_step() / predicted, 1.0, 1e-9);
  EXPECT_LT(predicted, 0.2 * alone);
  State state = rest_state(model);
  state.position[corner] += Vec3(0, 0.001, 0);
  solver->reset(state);
  ASSERT_TRUE(solver->step(2000, 0.95 * predicted).ok());
  EXPECT_LT(displacement_norms(model, solver->read()).max, 0.005);
  EXPECT_EQ(solver->step(1, 1.05 * predicted).status, StepStatus::unstable_step);

  joint.set_stiffness(0.0, 0.0);
  EXPECT_EQ(solver->stable_step(), alone);
  EXPECT_TRUE(solver->step(1, 0.5 * alone).ok());
  scene.remove_joint("joint 1");
  EXPECT_EQ(solver->stable_step(), alone);
}

TEST_P(JointIn, EnergyIsKept) {
  const Oscillator body(0.0, 0.02);
  const auto solver = make(body.model, body.scene);
  body.start(*solver, 0.01);
  const double start = solver->energy().total();
  EXPECT_NEAR(start, 0.5 * spring_stiffness * 1e-4, 1e-9);
  ASSERT_TRUE(solver->step(10000, 0.5 * solver->stable_step()).ok());
  EXPECT_NEAR(solver->energy().total() / start, 1.0, 2e-3);
}

/// Length and span of a catenary give its parameter a: length = 2 a sinh(span / 2a).
double catenary_parameter(double length, double span) {
  double low = 0.01 * span, high = 100.0 * span;
  for (int k = 0; k < 200; ++k) {
    const double a = 0.5 * (low + high);
    (2.0 * a * std::sinh(span / (2.0 * a)) > length ? low : high) = a;
  }
  return low;
}

TEST_P(JointIn, AChainHangsAsACatenary) {
  const int links = 40;
  const double span = 1.0, length = 1.3, k = 1e5;
  VecList rest;
  for (int i = 1; i < links; ++i) rest.emplace_back(span * i / links, 0, 0);
  const Model model = loose_particles(rest, 0.002);
  Scene scene = Scene(model).gravity({0, 0, -9.81});
  Joint chain{.springs = {}, .stiffness = k};
  for (int i = 0; i < links; ++i) {
    const Anchor from = i == 0 ? at_world({0, 0, 0}) : at_particle(i - 1);
    const Anchor to = i == links - 1 ? at_world({span, 0, 0}) : at_particle(i);
    chain.springs.push_back({from, to, length / links});
  }
  scene.add_joint("chain", chain);
  const auto solver = make(model, scene, {.damping = {.rate = 8.0}, .rest_tolerance = 1e-9});
  const double dt = 0.8 * solver->stable_step();
  ASSERT_TRUE(has_converged(solver->run_to_rest(200'000, dt)));
  const double a = catenary_parameter(length, span);
  const State state = solver->read();
  double largest = 0.0;
  for (const Vec3& x : state.position) {
    const double z = a * (std::cosh((x.x() - 0.5 * span) / a) - std::cosh(0.5 * span / a));
    largest = std::max(largest, std::abs(x.z() - z));
  }
  const double sag = a * (std::cosh(0.5 * span / a) - 1.0);
  EXPECT_LT(largest, 7e-4 * sag);
  // The ends carry the weight: in the mean, for in single precision the fastest vibrations never cease.
  const double weight = 9.81 * 0.002 * (links - 1);
  double carried = 0.0;
  const int looks = 200;
  for (int look = 0; look < looks; ++look) {
    ASSERT_TRUE(solver->step(7, dt).ok());
    const std::vector<SpringReport>& springs = solver->joint_report("chain").springs;
    carried += (springs.back().force.z() - springs.front().force.z()) / looks;
  }
  EXPECT_NEAR(carried, weight, 1e-3 * weight + 2.0 * k * roundoff() * length);
}

TEST_P(JointIn, ASpringBreaksAboveItsForce) {
  const Model model = loose_particles({Vec3(0, 0, 0)}, bead_mass);
  for (const double over : {0.99, 1.01}) {
    Scene scene(model);
    Joint joint{.springs = {{at_particle(0), at_world({0, 0, 0}), 0.0, 2.0}}, .stiffness = spring_stiffness};
    joint.breaking_force = 0.2;
    const JointHandle handle = scene.add_joint(joint);
    const auto solver = make(model, scene);
    EXPECT_EQ(solver->joint_report(handle).springs.size(), 1u);
    State state = rest_state(model);
    state.position[0].x() =
        over * 0.2 / spring_stiffness;  // of a share of 2: twice the stiffness, twice the breaking force
    solver->reset(state);
    const double dt = 0.1 * solver->stable_step();
    const StepReport first = solver->step(1, dt);
    ASSERT_TRUE(first.ok());
    const bool broken = over > 1.0;
    EXPECT_EQ(first.springs_broken, broken ? 1 : 0);
    EXPECT_EQ(says(first.message(), "; 1 spring of a joint broke"), broken) << first.message();
    EXPECT_EQ(solver->joint_report(handle).broken, broken ? 1 : 0);
    EXPECT_NEAR(solver->joint_report(handle).force.x(), -over * 0.4, 1e-6) << "it acts in that step still";
    EXPECT_NEAR(solver->joint_report(handle).largest, over * 0.4, 1e-6);
    const Vec3 v = solver->read().velocity[0];
    EXPECT_NEAR(v.x(), -over * 0.4 / bead_mass * dt, 1e-5);
    const StepReport next = solver->step(5, dt);
    ASSERT_TRUE(next.ok());
    EXPECT_EQ(next.springs_broken, 0);
    if (broken) {
      EXPECT_EQ(solver->read().velocity[0], v) << "nothing pulls any more";
      EXPECT_EQ(solver->joint_report(handle).force, Vec3(0, 0, 0));
      EXPECT_NEAR(solver->energy().elastic, 0.0, 1e-15);
    } else {
      EXPECT_LT(solver->read().velocity[0].x(), v.x());
    }
  }
}

TEST_P(JointIn, ASlackSpringDoesNotPush) {
  const Model model = loose_particles({Vec3(0.01, 0, 0)}, bead_mass);
  Scene scene(model);
  Joint joint{.springs = {{at_particle(0), at_world({0, 0, 0})}}, .stiffness = spring_stiffness, .damping = 1.0};
  joint.slack = true;
  const JointHandle handle = scene.add_joint(joint);
  EXPECT_EQ(handle.joint().springs[0].rest_length, 0.01);
  const auto solver = make(model, scene);
  const auto force_at = [&](double x, double speed) {
    State state = rest_state(model);
    state.position[0].x() = x;
    state.velocity[0].x() = speed;
    solver->reset(state);
    EXPECT_TRUE(solver->step(1, 0.1 * solver->stable_step()).ok());
    return solver->joint_report(handle).force.x();
  };
  EXPECT_EQ(force_at(0.008, 0.0), 0.0);
  EXPECT_EQ(force_at(0.008, 1.0), 0.0);
  EXPECT_NEAR(force_at(0.012, 0.0), -spring_stiffness * 0.002, 1e-6);
  EXPECT_EQ(force_at(0.012, -1.0), 0.0) << "the damper alone would push";
  handle.set_rest_length(0.011);
  EXPECT_NEAR(force_at(0.012, 0.0), -spring_stiffness * 0.001, 1e-6);
}

TEST_P(JointIn, VelocitiesOfAStatesOwnTimeCountTheJoints) {
  const Oscillator body(0.0);
  Simulation sim(body.model, {.backend = GetParam(), .topology = {.law = Law::springs}});
  sim.scene().add_joint({at_particle(0), at_world({0, 0, 0}), 0.0}, spring_stiffness);
  State state = rest_state(body.model);
  state.position[0].x() = 0.01;
  sim.set_state(state);
  ASSERT_TRUE(sim.advance(0.25 * 2.0 * std::numbers::pi / omega).ok());
  const double limit = sim.step_limit() * omega;
  EXPECT_NEAR(sim.state().velocity[0].x(), -0.01 * omega, 0.2 * limit * limit * 0.01 * omega);
}

/// Velocities of a step's middle follow from those of its end, though a damper acts on the former.
TEST_P(JointIn, AStateHandedOverKeepsDampedVelocities) {
  const Oscillator body(0.5 * bead_mass * omega);
  const auto solver = make(body.model, body.scene);
  body.start(*solver, 0.01);
  const double dt = 0.4 / omega;
  ASSERT_TRUE(solver->step(20, dt).ok());
  const State before = solver->read();
  State own = before;
  to_own_time(build_topology(body.model, {.law = Law::springs}), body.scene, {dt, 1.0}, own);
  solver->start(own, dt);
  EXPECT_NEAR(solver->read().velocity[0].x(), before.velocity[0].x(), 1e-6 * std::abs(before.velocity[0].x()) + 1e-12);
  EXPECT_GT(std::abs(own.velocity[0].x() - before.velocity[0].x()), 1e-3 * std::abs(before.velocity[0].x()));
}

TEST_P(JointIn, AnotherJointOfTheNameIsWhole) {
  Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.01, 0, 0)}, bead_mass);
  Scene scene(model);
  Joint weak{.springs = {{at_particle(0), at_world({0, 0, 0})}, {at_particle(1), at_world({0, 0, 0.1})}},
             .stiffness = spring_stiffness,
             .breaking_force = 1e-3};
  for (JointSpring& spring : weak.springs) spring.rest_length = 0.0;
  scene.add_joint("glue", weak);
  const auto solver = make(model, scene);
  ASSERT_TRUE(solver->step(2, 1e-4).ok());
  ASSERT_EQ(solver->joint_report("glue").broken, 1);
  scene.remove_joint("glue").add_joint("glue",
                                       {.springs = {{at_particle(0), at_particle(1)}}, .stiffness = spring_stiffness});
  EXPECT_TRUE(solver->read().joints.empty());
  EXPECT_TRUE(std::isfinite(solver->energy().kinetic));
  ASSERT_TRUE(solver->step(1, 1e-4).ok());
  EXPECT_EQ(solver->joint_report("glue").broken, 0);
}

}  // namespace
}  // namespace phymul::test
