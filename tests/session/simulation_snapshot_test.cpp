// SPDX-License-Identifier: MIT
//
// Simulation: back to earlier states, from memory, files, the history and recordings. Bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <type_traits>

#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

static_assert(std::is_same_v<decltype(std::declval<Simulation&>().solver()), const Solver&>);

class SimulationSnapshot : public OnEveryBackend {
 protected:
  /// A block with a ball above it, and a hook that holds its side.
  Simulation pulled() const {
    Simulation sim(with_material(make_block({0.04, 0.02, 0.02}, 4, 2, 2)),
                   {.backend = GetParam(), .damping = {.rate = 20}});
    Scene& scene = sim.scene().fix("x0");
    scene.add_tool("hook", {.shape = Sphere{1e-3}, .pose = {.position = {0.041, 0.01, 0.01}}}).grasp(1e-4);
    scene.add_tool("ball", {.shape = Sphere{5e-3}, .pose = {.position = {0.02, 0.01, 0.0255}}, .friction = 0.3});
    Joint rope{
        .springs = {{at_mean(sim.model().group("x1")), at_world({0.05, 0, 0.01})}}, .stiffness = 20.0, .damping = 0.1};
    scene.add_joint("rope", std::move(rope));
    return sim;
  }

  /// 20 ticks of a hand that goes down. The bits of mean forces follow the clock on a GPU.
  static void touch(Simulation& sim, VirtualCoupling& coupling) {
    const ToolHandle ball = sim.scene().tool("ball"), hook = sim.scene().tool("hook");
    for (int tick = 0; tick < 20; ++tick) {
      coupling.follow({.position = {0.02, 0.01, 0.0255 - 0.1 * sim.time()}, .velocity = {0, 0, -0.1}},
                      sim.force_on(ball).force, sim.force_on(ball).torque, 1e-3);
      ball.move_to(coupling.pose());
      hook.move_to({.position = {0.041 + 0.05 * sim.time(), 0.01, 0.01}});
      ASSERT_TRUE(sim.advance(1e-3).ok());
    }
  }
};
PHYMUL_ON_EVERY_BACKEND(SimulationSnapshot);

/// In memory, from a file in another simulation, and from the history.
TEST_P(SimulationSnapshot, ACouplingLoopRepeatsBitForBit) {
  Simulation sim = pulled(), other = pulled();
  const ToolHandle ball = sim.scene().tool("ball");
  VirtualCoupling coupling({}, ball.target_pose());
  touch(sim, coupling);
  sim.keep_history(1000);
  const Snapshot start = sim.snapshot();
  const std::string path = testing::TempDir() + "phymul_simulation_" + GetParam();
  sim.save(path);
  EXPECT_EQ(read_state(path), start);
  Snapshot of_state_alone = start;
  of_state_alone.scene.reset();
  of_state_alone.tools.clear();
  of_state_alone.joints.clear();
  EXPECT_EQ(fingerprint(of_state_alone), fingerprint(start));
  const VirtualCoupling then = coupling;
  const ToolForce force = sim.force_on(ball);
  const JointReport rope = sim.solver().joint_report("rope");
  ASSERT_GT(force.force.norm(), 0.0);
  ASSERT_GT(rope.largest, 0.0);
  const State state = sim.state();
  touch(sim, coupling);
  const Snapshot once = sim.snapshot();
  other.load(path);
  sim.restore(start);
  for (Simulation* again : {&other, &sim, &sim}) {
    EXPECT_EQ(again->snapshot(), start);
    EXPECT_EQ(again->force_on(again->scene().tool("ball")), force);
    EXPECT_EQ(again->solver().joint_report("rope"), rope);
    EXPECT_EQ(again->state(), state) << "also velocities where tools went on";
    coupling = then;
    touch(*again, coupling);
    EXPECT_EQ(again->snapshot().state, once.state);
    ASSERT_TRUE(sim.rewind(start.state.time));
  }
  std::filesystem::remove(path);
  EXPECT_THROW(sim.load(path), Error);
  EXPECT_EQ(sim.snapshot(), start);
  EXPECT_FALSE(sim.rewind(0.01));
  sim.set_state(start.state);
  EXPECT_EQ(sim.force_on(ball).force, Vec3(0, 0, 0));
}

TEST_P(SimulationSnapshot, ToolsAndJointsComeBack) {
  Simulation sim = pulled();
  Scene& scene = sim.scene();
  const ToolHandle ball = scene.tool("ball");
  const JointHandle rope = scene.joint("rope");
  VirtualCoupling coupling({}, ball.target_pose());
  sim.record();
  touch(sim, coupling);
  const Snapshot start = sim.snapshot();
  const VirtualCoupling then = coupling;
  touch(sim, coupling);
  const Snapshot once = sim.snapshot();

  sim.restore(start);
  rope.set_rest_length(1e-3);
  ball.teleport({.position = {0, 0, 1}});
  scene.add_joint({at_particle(3), at_world({0, 0, 1})}, 1.0);
  ASSERT_TRUE(sim.advance(1e-3).ok());
  sim.restore(start);
  EXPECT_EQ(rope.joint(), start.scene->joints[0].second) << "the handle still knows it";
  scene.remove_joint("rope").remove_tool("hook").add_tool("knife", {.shape = Sphere{1e-3}});
  ASSERT_TRUE(sim.advance(1e-3).ok());
  sim.restore(start);
  ASSERT_EQ(scene.tools().size(), 2u);
  EXPECT_EQ(scene.tools()[0].name, "hook") << "in the order of the snapshot";
  EXPECT_EQ(ball.target_pose(), start.tools[1].target);
  EXPECT_EQ(sim.snapshot(), start);
  coupling = then;
  touch(sim, coupling);
  EXPECT_EQ(sim.snapshot().state, once.state);

  scene.gravity({0, 9.81, 0}).remove_joint("rope");
  sim.keep_history(5);
  sim.set_state(start.state);
  const double dt = 0.4 * sim.solver().stable_step();
  ASSERT_TRUE(sim.step(20, dt).ok() && sim.step(20, dt).ok());
  ASSERT_TRUE(sim.rewind(sim.time() - 5 * dt));
  sim.run_to_rest(200);
  const State end = sim.snapshot().state;
  const Recording recording = sim.recording();
  Simulation again = pulled();
  again.replay(recording);
  EXPECT_EQ(again.snapshot().state, end);
  sim.replay(recording);
  EXPECT_EQ(sim.snapshot().state, end);
  EXPECT_THROW(sim.recording(), Error);
}

/// The first step begins with the velocities of half a step before, whichever step that is.
TEST(SimulationStart, GoesOnFromSnapshotsAndFilesAsItDidItself) {
  const auto make = [](const char* backend) {
    Simulation sim(make_block({0.06, 0.02, 0.02}, 6, 2, 2),
                   {.material = {.young = 5e3, .poisson = 0.4, .density = 1000}, .backend = backend});
    sim.scene().fix("x0").gravity({0, 0, -3.0});
    return sim;
  };
  const std::vector<std::pair<const char*, std::function<void(Simulation&)>>> starts{
      {"made", [](Simulation&) {}},
      {"set_state",
       [](Simulation& sim) {
         State state = rest_state(sim.model());
         for (Vec3& x : state.position) x.z() *= 1.2;
         for (Vec3& v : state.velocity) v.z() = 0.3;
         sim.set_state(state);
       }},
      {"solve_static", [](Simulation& sim) { ASSERT_TRUE(sim.solve_static().converged()); }}};
  const std::string path = (std::filesystem::temp_directory_path() / "phymul_start.state").string();
  for (const char* backend : {"reference", "cpu"}) {
    for (const auto& [name, start] : starts) {
      SCOPED_TRACE(std::string(backend) + ", " + name);
      Simulation sim = make(backend);
      start(sim);
      const Snapshot begin = sim.snapshot();
      sim.save(path);
      sim.keep_history(1);
      sim.advance(7e-3);
      const State end = sim.solver().read();
      const auto apart = [&](const Simulation& other) {
        double most = other.solver().read() == end ? 0.0 : 1e-300;
        for (std::size_t i = 0; i < end.position.size(); ++i) {
          most = std::max(most, (other.solver().read().position[i] - end.position[i]).norm());
        }
        return most;
      };
      sim.restore(begin);
      EXPECT_EQ(sim.snapshot(), begin);
      sim.advance(7e-3);
      EXPECT_EQ(apart(sim), 0.0) << "after restore()";
      ASSERT_TRUE(sim.rewind(0.0));
      sim.advance(7e-3);
      EXPECT_EQ(apart(sim), 0.0) << "after rewind()";
      Simulation other = make(backend);
      other.advance(5e-3);
      other.load(path);
      EXPECT_EQ(other.snapshot(), begin);
      other.advance(7e-3);
      EXPECT_EQ(apart(other), 0.0) << "after load()";
    }
  }
  std::filesystem::remove(path);
}

/// A tool that touches nothing does not change the motion, and does what it was asked after the start.
TEST(SimulationStart, IsTheSameBesideTools) {
  State ends[2];
  for (const bool with_tool : {false, true}) {
    Simulation sim(make_block({0.06, 0.02, 0.02}, 6, 2, 2),
                   {.material = {.young = 5e3, .poisson = 0.4, .density = 1000}, .backend = "reference"});
    sim.scene().gravity({0, 0, -1.0});
    if (with_tool) sim.scene().add_tool("far", {.shape = Sphere{0.01}, .pose = {.position = {0, 0, 5}}});
    sim.set_state(rest_state(sim.model()));
    if (with_tool) sim.scene().tool("far").move_to({.position = {0, 0, 4}});
    sim.step(3, 2e-4);
    EXPECT_TRUE(!with_tool || sim.solver().tool_pose("far").position.z() == 4.0);
    ends[with_tool] = sim.solver().read();
  }
  EXPECT_EQ(ends[1].position, ends[0].position);
}

TEST(SolverSnapshot, IsRefusedInAnotherScene) {
  const Model model = make_block({1, 1, 1}, 2, 2, 2);
  Scene scene(model);
  const auto solver = make_solver("reference", model, scene);
  scene.add_tool("probe", {.shape = Sphere{0.1}});
  const JointHandle rope = scene.add_joint({at_particle(0), at_world({0, 0, 1})}, 1.0);
  Snapshot start = solver->snapshot();
  const auto refused = [&](const std::string& why) { return refuses([&] { solver->restore(start); }, why); };
  rope.set_rest_length(2.0);
  EXPECT_TRUE(refused("is joint \"joint 1\""));
  scene.remove_tool("probe");
  EXPECT_TRUE(refused("is tool \"probe\""));
  scene.bring_back(*start.scene);
  solver->restore(start);
  scene.add_tool("knife", {.shape = Sphere{0.1}});
  EXPECT_TRUE(refused("is tool \"knife\""));
  SceneParts wrong = *start.scene;
  wrong.joints[0].second.springs[0].a = at_particle(1000);
  EXPECT_TRUE(
      refuses([&] { scene.bring_back(wrong); }, "joint \"joint 1\": spring 0: expected particles from 0 to 26"));
  EXPECT_EQ(scene.tools().size(), 2u);
  start.scene.reset();  // as files have it that were written before snapshots had tools and joints
  solver->restore(start);
}

}  // namespace
}  // namespace phymul::test
