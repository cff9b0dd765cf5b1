// SPDX-License-Identifier: MIT
//
// Joints that are solved implicitly (SolverOptions::max_substeps): what is told of their forces is what they give.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>

#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double block_edge = 0.04;  // m

class StiffJointsOn : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Cpu, StiffJointsOn, testing::Values("reference", "cpu"),
                         [](const auto& backend) { return std::string(backend.param); });

/// A block that a hand swings at springs so stiff that they alone would shorten the step, of both kinds, while it lies
/// on a floor.
struct Swung {
  explicit Swung(const char* backend, double breaking_force = std::numeric_limits<double>::infinity(),
                 std::size_t springs = 6) {
    scene.gravity({0, 0, -9.81});
    scene.add_tool("floor", {.shape = HalfSpace{}});
    scene.add_tool("hand", {.shape = Sphere{1e-3}, .pose = {.position = {0, 0, 0.1}}});
    Joint joint{.springs = {}, .stiffness = 1e6, .damping = 50.0, .breaking_force = breaking_force};
    for (const Index i : model.group("z1")) {
      if (joint.springs.size() >= springs) break;
      const Vec3 end = model.rest[i] + Vec3(1e-3, 0, 0.01) - Vec3(0, 0, 0.1);
      joint.springs.push_back({at_particle(i), at_tool("hand", end - Vec3(1e-3, 0, 0.01)), 0.0});
      joint.springs.push_back({at_tool("hand", end), at_particle(i + 1)});
    }
    scene.add_joint("lock", joint);
    solver = make_solver(backend, model, scene, {}, {.max_substeps = 8});
    dt = 0.5 * solver->stable_step();
  }
  const JointReport& step(int k) {
    const double angle = 0.2 * k;
    scene.tool("hand").move_to(
        {.position = {2e-4 * std::sin(angle), 1e-4 * std::sin(2.0 * angle), 0.1 + 2e-4 * (1.0 - std::cos(angle))}});
    EXPECT_TRUE(solver->step(1, dt).ok());
    return solver->joint_report(scene.joint("lock"));
  }
  /// N, by the law, of a spring that holds in all directions, without its damper.
  double stretch_force(const State& before) const {
    const JointSpring& spring = scene.joints().at(0).joint.springs.at(0);
    return 1e6 * (before.tools.at(1).pose.position + spring.b.point - before.position[spring.a.particles[0]]).norm();
  }

  Model model = with_material(make_block(Vec3::Constant(block_edge), 4, 4, 4), {5e3, 0.45, 1000.0});
  Scene scene{model};
  std::unique_ptr<Solver> solver;
  double dt = 0.0;
};

TEST_P(StiffJointsOn, ReportTheForcesThatTheBodyGets) {
  Swung body(GetParam());
  {
    const auto explicit_one = make_solver(GetParam(), body.model, body.scene);
    ASSERT_LT(explicit_one->stable_step(), 0.2 * body.solver->stable_step()) << "or nothing is solved implicitly";
  }
  const double roundoff = GetParam() == std::string("reference") ? 0x1p-53 : 0x1p-24;
  double largest = 0.0, largest_by_law = 0.0, most_pressed = 0.0, most_left = 0.0;
  for (int k = 0; k < 100; ++k) {
    const State before = body.solver->read();
    const Momentum at_first = body.solver->momentum();
    const JointReport report = body.step(k);
    const Vec3 weight = total_mass(body.model) * Vec3(0, 0, -9.81);
    const Imbalance left = imbalance(at_first, body.solver->momentum(), *body.solver, {"hand", "floor"}, body.dt);
    const ToolForce& on_hand = body.solver->tool_force("hand");
    const double size = report.largest * 12 + on_hand.force.norm() + total_mass(body.model) / body.dt;
    EXPECT_LE((left.force - weight).norm(), 1e3 * roundoff * size) << k;
    most_left = std::max(most_left, (left.force - weight).norm());
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    const ToolPose &now = body.solver->tool_pose("hand"), &last = before.tools.at(1).pose;
    for (std::size_t row = 0; row < report.springs.size(); ++row) {
      const JointSpring& spring = body.scene.joints()[0].joint.springs[row];
      const bool at_a = !spring.a.tool.empty();
      const Vec3 own = at_a ? report.springs[row].force : Vec3(-report.springs[row].force);
      force += own;
      torque += (last.position + (at_a ? spring.a : spring.b).point - now.position).cross(own);
    }
    EXPECT_LE((force - on_hand.force).norm(), 1e-12 * size) << k;
    EXPECT_LE((torque - on_hand.torque).norm(), 1e-12 * size) << k;
    largest = std::max(largest, report.largest);
    largest_by_law = std::max(largest_by_law, body.stretch_force(before));
    most_pressed = std::max(most_pressed, body.solver->tool_force("floor").force.norm());
  }
  EXPECT_GT(most_pressed, 0.1) << "what the floor does changes the forces, too";
  EXPECT_GT(largest_by_law, 10.0 * largest) << "or this shows nothing";
  RecordProperty("newton", std::to_string(largest));
  RecordProperty("newton_by_law", std::to_string(largest_by_law));
  RecordProperty("left", std::to_string(most_left));
}

TEST_P(StiffJointsOn, BreakByTheForcesThatTheBodyGets) {
  double largest = 0.0;  // N, of two springs alike, by what the body gains
  Swung whole(GetParam(), std::numeric_limits<double>::infinity(), 2);
  const Vec3 weight = total_mass(whole.model) * Vec3(0, 0, -9.81);
  for (int k = 0; k < 60; ++k) {
    const Momentum before = whole.solver->momentum();
    const JointReport& report = whole.step(k);
    const Imbalance left = imbalance(before, whole.solver->momentum(), *whole.solver, {"floor"}, whole.dt);
    EXPECT_NEAR((report.springs[0].force - report.springs[1].force - (left.force - weight)).norm(), 0.0,
                1e-3 * (left.force.norm() + weight.norm()));
    largest = std::max({largest, report.springs[0].force.norm(), report.springs[1].force.norm()});
  }
  Swung strong(GetParam(), 1.01 * largest, 2), weak(GetParam(), 0.9 * largest, 2);
  for (int k = 0; k < 60; ++k) EXPECT_EQ(strong.step(k).broken, 0) << k;
  EXPECT_EQ(strong.solver->read().position, whole.solver->read().position);
  int k = 0;
  while (k < 60 && weak.step(k).broken == 0) ++k;
  ASSERT_LT(k, 60);
  for (const SpringReport& spring : weak.solver->joint_report("lock").springs) {
    EXPECT_EQ(spring.broken, spring.force.norm() > 0.9 * largest);
  }
}

/// A capsule excludes substeps, but not that joints are solved: they rest where explicit ones do.
TEST(StiffJoints, DoNotSetTheStepOfABodyInACapsule) {
  Model model = with_material(make_block(Vec3::Constant(block_edge), 3, 3, 3), {5e3, 0.45, 1000.0});
  add_capsule(model, {.young = 100e3, .poisson = 0.45, .density = 1050.0, .thickness = 0.2e-3});
  Joint joint{.springs = {}, .stiffness = 3e4};
  for (const Index i : model.group("z1")) {
    joint.springs.push_back({at_particle(i), at_world(model.rest[i]), 0.0});
  }
  std::vector<State> at_rest;
  std::vector<double> step;
  for (const int substeps : {1, 8}) {
    Simulation sim(model, {.backend = "cpu", .solver = {.max_substeps = substeps}});
    sim.scene().gravity({0, 0, -9.81}).add_joint("lock", joint);
    step.push_back(sim.solver().stable_step());
    const RestResult rest = sim.run_to_rest();
    ASSERT_TRUE(rest.converged()) << rest.message();
    at_rest.push_back(sim.solver().read());
  }
  EXPECT_GT(step[1], 10.0 * step[0]);
  EXPECT_LT(largest_distance(at_rest[0].position, at_rest[1].position),
            1e-3 * largest_distance(at_rest[0].position, model.rest));
}

/// SolverOptions::max_displacement_per_step limits what they are solved with.
TEST(StiffJoints, AreTheSameWhileForcesAreClamped) {
  std::vector<State> after;
  std::vector<Vec3> force;
  for (const char* backend : {"reference", "cpu"}) {
    Swung body(backend);
    State state = body.solver->read();
    const Index own = body.scene.joints().at(0).joint.springs.at(0).a.particles[0];
    state.position[own] -= Vec3(0, 0, 0.95 * block_edge / 4);
    body.solver->reset(state);
    const StepReport report = body.solver->step(1, body.dt);
    ASSERT_TRUE(report.ok()) << report.message();
    ASSERT_TRUE(report.force_clamped);
    after.push_back(body.solver->read());
    force.push_back(body.solver->joint_report("lock").force);
  }
  const double moved = largest_distance(after[0].position, Swung("reference").solver->read().position);
  EXPECT_LT(largest_distance(after[0].position, after[1].position), 1e-4 * moved);
  EXPECT_LT((force[0] - force[1]).norm(), 1e-4 * force[0].norm());
}

/// A spring whose particle has no cell left is broken; the others hold on.
TEST_P(StiffJointsOn, GoOnWhereTheBodyOfOneWasRemoved) {
  Simulation sim(make_tetrahedral_block({0.06, 0.04, 0.03}, 6, 4, 3, 0.25, 7), {.material = {5e3, 0.4, 1000.0},
                                                                                .backend = GetParam(),
                                                                                .damping = {.rate = 10.0},
                                                                                .solver = {.max_substeps = 4}});
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  const Index removed = 20, held = static_cast<Index>(sim.model().rest.size()) - 1;
  Joint joint{.springs = {}, .stiffness = 1e6};
  for (const Index i : {removed, held}) {
    joint.springs.push_back({at_particle(i), at_world(sim.model().rest[i]), 0.0});
  }
  sim.scene().add_joint("lock", joint);
  ASSERT_TRUE(sim.advance(0.02).ok());
  std::vector<Index> around;
  for (Index row = 0; row < static_cast<Index>(sim.model().cells.size()); ++row) {
    if (std::ranges::count(sim.model().cells[row].particles, removed) > 0) around.push_back(row);
  }
  sim.remove_cells(around);
  ASSERT_EQ(sim.model().mass[removed], 0.0);
  const StepReport report = sim.advance(0.02);
  ASSERT_TRUE(report.ok()) << report.message();
  const JointReport& lock = sim.report_of(sim.scene().joint("lock"));
  EXPECT_TRUE(lock.springs[0].broken);
  EXPECT_FALSE(lock.springs[1].broken);
  EXPECT_GT(lock.springs[1].force.norm(), 0.0);
  EXPECT_LT((sim.solver().read().position[held] - sim.model().rest[held]).norm(), 1e-4);
}

}  // namespace
}  // namespace phymul::test
