// SPDX-License-Identifier: MIT
//
// SolverOptions::max_substeps: materials that need a shorter step than the others.
#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <random>

#include "elastic/local_steps.h"
#include "support/allocation_count.h"
#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

constexpr double edge = 0.1;  // m
const Material soft{5e3, 0.45, 1000.0}, stiff{500e3, 0.45, 1000.0};
const Vec3 middle(0.5 * edge, 0.5 * edge, 0.5 * edge);

Model cube(int cells) {
  return with_material(make_tetrahedral_block({edge, edge, edge}, cells, cells, cells, 0.2, 7), soft);
}

/// A cube of 0.1 m with a ball, a hundred times as stiff, in 2 % of its volume.
Model with_tumour(int cells, const Vec3& centre = middle) {
  Model model = cube(cells);
  set_material(model, stiff, [=](const Vec3& place) { return (place - centre).norm() < 0.168 * edge; });
  return model;
}

/// Of a material beside one 30 times as stiff at every vertex, whose step substeps alone make too long.
Model checkerboard() {
  Model model = cube(6);
  set_material(model, {150e3, 0.45, 1000.0}, [](const Vec3& at) {
    const Vec3 cell = 6.0 / edge * at;
    return (static_cast<int>(cell.x()) + static_cast<int>(cell.y()) + static_cast<int>(cell.z())) % 2 == 0;
  });
  return model;
}

std::unique_ptr<Solver> solver_of(const std::string& backend, const Model& model, const Scene& scene, int substeps,
                                  double damping = 0.0, UnstableStep beyond = UnstableStep::refuse) {
  const SolverOptions options{.damping = {.rate = damping}, .on_unstable = beyond, .max_substeps = substeps};
  return make_solver(backend, model, scene, {}, options);
}

/// Positions after `seconds` of gravity, at this share of the step limit.
VecList fallen(const std::string& backend, const Model& model, int substeps, double share, double seconds) {
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -1.0});
  const auto solver = solver_of(backend, model, scene, substeps);
  const int steps = static_cast<int>(seconds / (share * solver->stable_step())) + 1;
  EXPECT_TRUE(solver->step(steps, seconds / steps).ok());
  return solver->read().position;
}

TEST(Substeps, SharesSumToOneAndOneIsVerlet) {
  for (int p = 1; p <= 32; ++p) {
    double sum = 0.0, before = 0.0, now = 0.0;
    for (const Substep& substep : substeps_of(p)) {
      sum += substep.share;
      before = std::exchange(now, now + substep.keep * (now - before) + substep.kick);  // a = 1, dt = 1
    }
    EXPECT_NEAR(sum, 1.0, 1e-12) << p;
    EXPECT_NEAR(now, 0.5, 1e-12) << p;
  }
  EXPECT_EQ(substep_limit(1), 4.0);
}

/// Of a vibration with dt^2 lambda = x: w_p = (P - 1) u, where the whole step is that of an acceleration Q times K u /
/// m.
TEST(Substeps, SlowVibrationsDownAndNeverReverseThem) {
  for (const int p : {2, 3, 7, 16}) {
    for (int k = 1; k <= 1000; ++k) {
      const double x = substep_limit(p) * k / 1000.0;
      double sum = 0.0, before = 0.0, now = 0.0;
      for (const Substep& substep : substeps_of(p)) {
        const double a = -x - x * now;  // of u = 1
        sum += substep.share * a;
        before = std::exchange(now, now + substep.keep * (now - before) + substep.kick * a);
      }
      const double Q = -sum / x;
      ASSERT_GT(Q, 0.0) << p << " " << x;
      ASSERT_LT(Q, 1.0) << p << " " << x;
      ASSERT_LT(Q * x, 4.0) << p << " " << x;
    }
  }
}

class LocalStepsOn : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Cpu, LocalStepsOn, testing::Values("reference", "cpu"),
                         [](const auto& backend) { return std::string(backend.param); });

TEST_P(LocalStepsOn, AStiffTumourNoLongerSetsTheStep) {
  const Model plain = cube(8), model = with_tumour(8);
  const Scene of_plain(plain), scene(model);
  const auto homogeneous = solver_of(GetParam(), plain, of_plain, 1);
  const auto one = solver_of(GetParam(), model, scene, 1), local = solver_of(GetParam(), model, scene, 32);
  EXPECT_EQ(one->substeps(), 1);
  EXPECT_GE(local->substeps(), 4);
  EXPECT_LT(one->stable_step(), 0.2 * homogeneous->stable_step());
  EXPECT_GT(local->stable_step(), 0.98 * homogeneous->stable_step());
  const auto few = solver_of(GetParam(), model, scene, 2);
  EXPECT_EQ(few->substeps(), 2);
  EXPECT_GT(few->stable_step(), 1.2 * one->stable_step());
}

/// The error of the longer step is that which the soft tissue has at its own step.
TEST_P(LocalStepsOn, TheMotionIsThatOfShortSteps) {
  const Model plain = cube(8), model = with_tumour(8);
  const VecList fine = fallen(GetParam(), model, 1, 0.2, 0.1), local = fallen(GetParam(), model, 32, 0.45, 0.1);
  const VecList plain_fine = fallen(GetParam(), plain, 1, 0.04, 0.1), own = fallen(GetParam(), plain, 1, 0.45, 0.1);
  const double moved = largest_distance(fine, model.rest);
  const double error = largest_distance(local, fine) / moved;
  EXPECT_LT(error, 1.1 * largest_distance(own, plain_fine) / largest_distance(plain_fine, plain.rest));
  RecordProperty("percent", std::to_string(100.0 * error));
}

TEST_P(LocalStepsOn, IsBoundedBelowTheLimitAndDivergesAboveIt) {
  const Model tumour = with_tumour(5), board = checkerboard();
  for (const double share : {0.97, 0.995, 1.06}) {
    const Model& model = share == 0.995 ? board : tumour;
    const Scene scene(model);
    const auto solver = solver_of(GetParam(), model, scene, 32, 0.0, UnstableStep::allow);
    ASSERT_GT(solver->substeps(), 1);
    State state = solver->read();
    std::mt19937 bits(5);
    for (Vec3& x : state.position) {
      for (double& c : x) c += 1e-6 * edge * (static_cast<double>(bits()) / 4294967296.0 - 0.5);
    }
    solver->reset(state);
    const StepReport report = solver->step(4000, share * solver->stable_step());
    const double moved = largest_distance(solver->read().position, model.rest);
    if (share < 1.0) {
      EXPECT_TRUE(report.ok()) << report.cause;
      EXPECT_LT(moved, 1e-4 * edge);
    } else {
      EXPECT_TRUE(!report.ok() || moved > 1e-3 * edge) << moved;
    }
  }
}

/// m/s, after steps at a share of the limit from random velocities of 1e-6 m/s.
double speed_after(Solver& solver, int steps, double share) {
  State state = solver.read();
  std::mt19937 bits(5);
  for (Vec3& v : state.velocity) v = 1e-6 * random_vector(bits, 3);
  solver.reset(state);
  const StepReport report = solver.step(steps, share * solver.stable_step());
  return report.ok() ? report.max_speed : std::numeric_limits<double>::infinity();
}

TEST_P(LocalStepsOn, ADampedStepHasALowerLimit) {
  const Model model = with_tumour(5);
  const Scene scene(model);
  for (const double factor : {0.8, 0.35, 0.0}) {
    const auto solver = make_solver(GetParam(), model, scene, {}, {.damping = {.factor = factor}, .max_substeps = 8});
    ASSERT_GT(solver->substeps(), 2);
    EXPECT_LT(speed_after(*solver, 300, 0.99), 1e-5) << factor;
  }
  const auto by_rate = make_solver(GetParam(), model, scene, {}, {.damping = {.rate = 1e4}, .max_substeps = 8});
  EXPECT_LT(speed_after(*by_rate, 300, 0.99), 1e-5);
  EXPECT_GT(by_rate->stable_step(), solver_of(GetParam(), model, scene, 1, 1e4)->stable_step() * (1.0 - 1e-12));
}

std::vector<Index> inside_tumour(const Model& model) {
  return model.particles_in([](const Vec3& place) { return (place - middle).norm() < 0.15 * edge; });
}

TEST_P(LocalStepsOn, JointsAtAStiffPartLowerTheLimit) {
  const Model model = with_tumour(5);
  for (const double stiffness : {0.0, 1e4}) {
    Scene scene(model);
    Joint joint{.stiffness = stiffness, .damping = stiffness > 0.0 ? 0.0 : 5.0};
    for (const Index i : inside_tumour(model)) joint.springs.push_back({at_particle(i), at_world(model.rest[i]), 0.0});
    scene.add_joint(joint);
    const auto solver = solver_of(GetParam(), model, scene, 32);
    ASSERT_GT(solver->substeps(), 2);
    EXPECT_LT(speed_after(*solver, 800, 0.99), 1e-5) << stiffness;
  }
}

TEST_P(LocalStepsOn, WhatHoldsAStiffPartHoldsItWithinAStep) {
  const Model model = with_tumour(5);
  const std::vector<Index> held = inside_tumour(model);
  ASSERT_GE(held.size(), 2u);
  Load along_z{.type = LoadType::translation, .particles = {held[0], held[1]}};
  along_z.axes = {Axis::free, Axis::free, Axis::held};
  for (const char* const by : {"fix", "one axis", "tool"}) {
    Scene scene(model);
    if (by[0] == 'f') scene.fix(std::vector<Index>{held[0]});
    if (by[0] == 'o') scene.add(along_z);
    if (by[0] == 't') {
      scene.add_tool("jaw", {.shape = Sphere{.radius = 0.005}, .pose = {.position = model.rest[held[0]]}});
    }
    const auto solver = solver_of(GetParam(), model, scene, 32);
    ASSERT_GT(solver->substeps(), 2);
    if (by[0] == 't') {
      scene.tool("jaw").grasp(0.001);
      ASSERT_TRUE(solver->step(1, 0.1 * solver->stable_step()).ok());
      ASSERT_GT(solver->held("jaw"), 0);
    }
    EXPECT_LT(speed_after(*solver, 500, 0.9), 1e-5) << by;
  }
}

TEST_P(LocalStepsOn, RestShapesAreThoseOfShortSteps) {
  // The tumour at the surface, half of it under a ball that presses it, and a spring that pulls at it.
  const Model model = with_tumour(6, {0.5 * edge, 0.5 * edge, edge});
  Scene scene = Scene(model).fix("z0").gravity({0, 0, -1.0});
  scene.add_tool(
      "ball", {.shape = Sphere{.radius = 0.03}, .pose = {.position = {0.5 * edge, 0.5 * edge, edge + 0.03 - 0.002}}});
  std::vector<VecList> shape;
  std::vector<double> force;
  for (const int substeps : {1, 32}) {
    // With 40 1/s and substeps the ball keeps the tumour vibrating at most steps (docs/guide/choosing.md).
    const auto solver = solver_of(GetParam(), model, scene, substeps, 80.0);
    EXPECT_EQ(solver->substeps() > 1, substeps > 1);
    const double dt = 0.5 * solver->stable_step();
    ASSERT_TRUE(solver->step(static_cast<int>(3.0 / dt), dt).ok());
    shape.push_back(solver->read().position);
    force.push_back(solver->tool_force("ball").force.z());
  }
  EXPECT_GT(std::abs(force[0]), 0.01);
  EXPECT_NEAR(force[1], force[0], 2e-3 * std::abs(force[0]));
  EXPECT_LT(largest_distance(shape[1], shape[0]), 2e-3 * largest_distance(shape[0], model.rest));
}

TEST(LocalSteps, KeepLinearMomentum) {
  const Model model = with_tumour(5);
  const Scene scene(model);
  const auto solver = solver_of("reference", model, scene, 32);
  State state = solver->read();
  std::mt19937 bits(11);
  for (Vec3& v : state.velocity) {
    for (double& c : v) c = 0.02 * (static_cast<double>(bits()) / 4294967296.0 - 0.5);
  }
  solver->reset(state);
  const Vec3 before = solver->momentum().linear;
  double of_all = 0.0;
  for (std::size_t i = 0; i < state.velocity.size(); ++i) of_all += model.mass[i] * state.velocity[i].norm();
  ASSERT_TRUE(solver->step(500, 0.8 * solver->stable_step()).ok());
  EXPECT_LT((solver->momentum().linear - before).norm(), 1e-12 * of_all);
}

/// Of a motion without fast vibrations in the tumour: its tip goes up and down by 1.5 % of the edge, undamped.
void expect_energy_kept(const std::string& backend, int steps) {
  const Model model = with_tumour(8);
  const Scene scene = Scene(model).fix("x0");
  const auto solver = solver_of(backend, model, scene, 32);
  ASSERT_GE(solver->substeps(), 4);
  State state = solver->read();
  for (std::size_t i = 0; i < state.velocity.size(); ++i) {
    const double a = model.rest[i].x() / edge;
    state.velocity[i].z() = 0.024 * a * a * (1.5 - 0.5 * a);
  }
  const double dt = 0.4 * solver->stable_step();  // half of it without balanced masses
  solver->start(state, dt);
  const double before = solver->energy().total();
  double moved = 0.0, differs = 0.0;
  constexpr int samples = 200;
  for (int k = 0; k < samples; ++k) {
    ASSERT_TRUE(solver->step(steps / samples, dt).ok());
    differs = std::max(differs, std::abs(solver->energy().total() / before - 1.0));
    moved = std::max(moved, largest_distance(solver->read().position, model.rest));
  }
  EXPECT_GT(moved, 0.014 * edge);
  EXPECT_LT(differs, 5e-4);
  testing::Test::RecordProperty("per_mille", std::to_string(1e3 * differs));
}

TEST_P(LocalStepsOn, EnergyIsKept) {
  expect_energy_kept(GetParam(), GetParam() == std::string("cpu") ? 10000 : 1000);
}

TEST(LongLocalSteps, EnergyIsKept) {
  expect_energy_kept("cpu", 100000);
}

/// Half a turn of a body that flies: the tumour turns with it.
TEST(LocalSteps, ATumourTurnsAsShortStepsTurnIt) {
  const Model model = with_tumour(5);
  const Scene scene(model);
  std::vector<VecList> end;
  for (const int substeps : {1, 32}) {
    const auto solver = solver_of("reference", model, scene, substeps);
    State state = solver->read();
    for (std::size_t i = 0; i < state.velocity.size(); ++i) {
      state.velocity[i] = Vec3(0, 0, 5.0).cross(model.rest[i] - middle);
    }
    const double dt = 0.4 * solver->stable_step();
    const int steps = static_cast<int>(0.7 / dt) + 1;
    solver->start(state, 0.7 / steps);
    ASSERT_TRUE(solver->step(steps, 0.7 / steps).ok());
    end.push_back(solver->read().position);
  }
  EXPECT_GT(largest_distance(end[0], model.rest), 0.5 * edge);
  EXPECT_LT(largest_distance(end[1], end[0]), 0.01 * edge);
}

TEST_P(LocalStepsOn, GoesOnFromASnapshotBitForBit) {
  const Model model = with_tumour(6, {0.5 * edge, 0.5 * edge, edge});
  Scene scene = Scene(model).fix("z0");
  scene.add_tool(
      "ball", {.shape = Sphere{.radius = 0.03}, .pose = {.position = {0.5 * edge, 0.5 * edge, edge + 0.03 - 0.002}}});
  const auto solver = solver_of(GetParam(), model, scene, 32, 100.0),
             other = solver_of(GetParam(), model, scene, 32, 100.0);
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(300, dt).ok());
  const Snapshot snapshot = solver->snapshot();
  ASSERT_EQ(snapshot.parts.size(), 1u) << "the ball pushes the tumour, or this shows little";
  other->restore(snapshot);
  ASSERT_TRUE(solver->step(20, dt).ok());
  ASSERT_TRUE(other->step(20, dt).ok());
  EXPECT_EQ(solver->read().position, other->read().position);
}

TEST_P(LocalStepsOn, ARestoreThatIsRefusedChangesNothing) {
  const Model model = with_tumour(6, {0.5 * edge, 0.5 * edge, edge});
  Scene scene = Scene(model).fix("z0");
  scene.add_tool(
      "ball", {.shape = Sphere{.radius = 0.03}, .pose = {.position = {0.5 * edge, 0.5 * edge, edge + 0.03 - 0.002}}});
  const auto solver = solver_of(GetParam(), model, scene, 32, 100.0);
  ASSERT_TRUE(solver->step(20, 0.5 * solver->stable_step()).ok());
  const Snapshot good = solver->snapshot();
  ASSERT_EQ(good.parts.size(), 1u) << "the ball pushes the tumour, or this shows nothing";
  Snapshot shorter = good, not_finite = good;
  shorter.parts.front().bytes.pop_back();
  std::fill_n(not_finite.parts.front().bytes.begin(), 8, std::uint8_t{0xff});
  ASSERT_TRUE(solver->step(20, 0.5 * solver->stable_step()).ok());
  const State before = solver->read();
  EXPECT_TRUE(refuses([&] { solver->restore(shorter); }, "the snapshot's part \"pushes\" to have"));
  EXPECT_TRUE(refuses([&] { solver->restore(not_finite); }, "\"pushes\" has a number that is not finite"));
  EXPECT_EQ(solver->read(), before);
}

TEST_P(LocalStepsOn, AStepAllocatesNothing) {
  const Model model = with_tumour(5);
  Scene scene = Scene(model).fix("z0").gravity({0, 0, -1.0});
  const auto solver = solver_of(GetParam(), model, scene, 32);
  ASSERT_TRUE(solver->step(3, 0.5 * solver->stable_step()).ok());
  const std::size_t before = allocation_count();
  ASSERT_TRUE(solver->step(10, 0.5 * solver->stable_step()).ok());
  EXPECT_EQ(allocation_count(), before);
}

TEST_P(LocalStepsOn, AStiffnessThatChangesIsCounted) {
  const Model model = with_tumour(5);
  Scene scene(model);
  const auto solver = solver_of(GetParam(), model, scene, 32);
  const double before = solver->stable_step();
  scene.scale_stiffness(stiff, 4.0);
  EXPECT_NEAR(solver->stable_step(), 0.5 * before, 0.2 * before);
  EXPECT_TRUE(solver->step(200, 0.9 * solver->stable_step()).ok());
  // The soft tissue sets the step; the tumour, a hundred times as stiff, has substeps to spare.
  scene.scale_stiffness(stiff, 1.0);
  scene.scale_stiffness(soft, 4.0);
  EXPECT_NEAR(solver->stable_step(), 0.5 * before, 0.02 * before);
}

TEST_P(LocalStepsOn, OneMaterialHasOneStepAndTheSameBits) {
  EXPECT_EQ(fallen(GetParam(), cube(4), 1, 0.5, 0.05), fallen(GetParam(), cube(4), 32, 0.5, 0.05));
}

TEST(LocalSteps, TheLimitHoldsWhereMaterialsMeetEverywhere) {
  const TopologyTextures t = build_topology(checkerboard());
  const Spectrum whole = estimate_spectrum(t, t.rest);
  // Without local steps it is the largest eigenvalue.
  EXPECT_NEAR(largest_rate(t, {}), whole.largest, 1e-4 * whole.largest);
  for (const int most : {8, 32}) {
    const auto steps = choose_local_steps(t, whole, most);
    ASSERT_TRUE(steps);
    EXPECT_EQ(steps->substeps.size(), 7u) << "more cost more than they gain";
    EXPECT_GT(steps->margin, 1.02) << "or this shows nothing";
    EXPECT_LE(largest_rate(t, *steps), steps->rate());
  }
}

TEST(LocalSteps, RefuseWhatTheyExclude) {
  const Model model = with_tumour(4);
  const Scene scene(model);
  SolverOptions options{.max_substeps = 0};
  EXPECT_TRUE(refuses([&] { make_solver("cpu", model, scene, {}, options); }, "max_substeps must be 1"));
  options.max_substeps = 8;
  options.sleep_tolerance = 0.0;
  EXPECT_TRUE(refuses([&] { make_solver("cpu", model, scene, {}, options); }, "exclude each other"));
}

}  // namespace
}  // namespace phymul::test
