// SPDX-License-Identifier: MIT
//
// A tool that covers particles where it is put: at its first pose, by place(), and where a state of that moment is gone
// back to, before any step was taken.
#include <phymul/recording.h>

#include <algorithm>

#include "support/tool_backends.h"

namespace phymul::test {
namespace {

using ToolFirstPose = WithTools;
PHYMUL_ON_EVERY_BACKEND(ToolFirstPose);

struct Covered {
  const char* name;
  Tool tool;
};

/// Over the top of the block, beside a line of particles, and all through it.
std::vector<Covered> covering_tools() {
  return {{"ball", {.shape = Sphere{0.008}, .pose = {.position = {0.01, 0.01, 0.0251}}, .friction = 0.3}},
          {"margin", {.shape = Sphere{0.006}, .pose = {.position = {0.01, 0.01, 0.0251}}, .margin = 0.002}},
          {"deep", {.shape = Sphere{0.006}, .pose = {.position = {0.0101, 0.0102, 0.015}}}},
          {"capsule", {.shape = Capsule{0.003, 0.03}, .pose = {.position = {0.0101, 0.0102, 0.015}}}},
          {"floor", {.shape = HalfSpace{}, .pose = {.position = {0.01, 0.01, 0.0041}}}},
          {"box", {.shape = Box{{0.004, 0.004, 0.004}}, .pose = {.position = {0.0101, 0.0102, 0.0183}}}}};
}

class Start {
 public:
  Start(const std::string& backend, const Tool& tool, bool added_before = true)
      : model(soft_block({0.02, 0.02, 0.02}, 5, 5, 5)), scene(model) {
    if (added_before) scene.add_tool("it", tool);
    solver = make_solver(backend, model, scene);
    dt = 0.3 * solver->stable_step();
  }
  State stepped() {
    const StepReport report = solver->step(1, dt);
    EXPECT_TRUE(report.ok()) << report.message();
    EXPECT_LE(report.max_speed, 1e-9);
    EXPECT_LE(solver->tool_force("it").force.norm(), 1e-6);
    return solver->read();
  }

  Model model;
  Scene scene;
  std::unique_ptr<Solver> solver;
  double dt = 0.0;
};

/// What place() does, the measure of all others.
State placed(const std::string& backend, const Tool& tool) {
  Tool away = tool;
  away.pose.position += tool.pose.orientation * Vec3(0, 0, -1.0);
  Start start(backend, away);
  start.scene.tool("it").teleport(tool.pose);
  return start.stepped();
}

void expect_placed(const State& state, const State& by_place) {
  EXPECT_EQ(state.position, by_place.position);
  EXPECT_EQ(state.tools, by_place.tools);
}

TEST_P(ToolFirstPose, IsAPlacedOne) {
  for (const auto& [name, tool] : covering_tools()) {
    SCOPED_TRACE(name);
    const State by_place = placed(GetParam(), tool);
    Start start(GetParam(), tool);
    const auto is_moved = [&](const Vec3& x) { return x != start.model.rest[&x - by_place.position.data()]; };
    EXPECT_GE(std::ranges::count_if(by_place.position, is_moved), 4);
    expect_placed(start.stepped(), by_place);
  }
}

TEST_P(ToolFirstPose, IsAPlacedOneInASceneThatIsStepped) {
  for (const auto& [name, tool] : covering_tools()) {
    SCOPED_TRACE(name);
    Start start(GetParam(), tool, false);
    ASSERT_TRUE(start.solver->step(3, start.dt).ok());
    start.scene.add_tool("it", tool);
    const State state = start.stepped(), by_place = placed(GetParam(), tool);
    EXPECT_LE(largest_distance(state.position, by_place.position), 1e-12 + 4 * roundoff() * 0.05);
  }
}

/// A state read before the first step, and what is made of it.
TEST_P(ToolFirstPose, IsAPlacedOneStillAfterGoingBackToIt) {
  for (const auto& [name, tool] : covering_tools()) {
    SCOPED_TRACE(name);
    const State by_place = placed(GetParam(), tool);
    Start read(GetParam(), tool);
    read.solver->reset(read.solver->read());
    expect_placed(read.stepped(), by_place);
    EXPECT_FALSE(read.solver->read().tools.at(0).placed);

    Start snapshot(GetParam(), tool);
    const Snapshot first = snapshot.solver->snapshot();
    EXPECT_TRUE(first.state.tools.at(0).placed);
    ASSERT_TRUE(snapshot.solver->step(5, snapshot.dt).ok());
    snapshot.solver->restore(first);
    expect_placed(snapshot.stepped(), by_place);

    Start let_go(GetParam(), tool);
    let_go.solver->start(let_go.solver->read(), let_go.dt);
    let_go.stepped();
  }
}

/// A recorder begins with a snapshot that it goes back to.
TEST_P(ToolFirstPose, IsAPlacedOneInRecordingsAndReplays) {
  for (const auto& [name, tool] : covering_tools()) {
    SCOPED_TRACE(name);
    Start start(GetParam(), tool);
    Recorder recorder(*start.solver, start.scene);
    const StepReport report = recorder.step(1, start.dt);
    ASSERT_TRUE(report.ok());
    EXPECT_LE(report.max_speed, 1e-9);
    const State state = start.solver->read();
    expect_placed(state, placed(GetParam(), tool));

    Scene again(start.model);
    const auto replayed = make(start.model, again);
    Replay(recorder.recording(), *replayed, again).run();
    EXPECT_EQ(replayed->read(), state);
  }
}

/// One that is moved before any step comes from there, also if it was added and moved before there was a solver, and in
/// a recording.
TEST_P(ToolFirstPose, IsWhereAMovedOneComesFrom) {
  const Tool tool{.shape = Sphere{0.008}, .pose = {.position = {0.01, 0.01, 0.0285}}};
  const ToolPose there{.position = {0.01, 0.01, 0.0265}};
  Start seen(GetParam(), tool);
  ASSERT_TRUE(seen.solver->step(0, seen.dt).ok());
  Start added(GetParam(), tool, false);
  ASSERT_TRUE(added.solver->step(0, added.dt).ok());
  Recorder recorder(*added.solver, added.scene);
  added.scene.add_tool("it", tool);
  Scene early(seen.model);
  early.add_tool("it", tool).move_to(there);
  const auto late = make(seen.model, early);
  for (Scene* const scene : {&seen.scene, &added.scene}) scene->tool("it").move_to(there);
  for (Solver* const solver : {seen.solver.get(), added.solver.get(), late.get()}) {
    EXPECT_EQ(solver->tool_pose("it"), tool.pose);
  }
  ASSERT_TRUE(seen.solver->step(4, seen.dt).ok() && recorder.step(4, added.dt).ok() && late->step(4, seen.dt).ok());
  const State state = seen.solver->read();
  EXPECT_GT(largest_distance(state.position, seen.model.rest), 1e-4);
  EXPECT_EQ(state.tools[0].pose.position, there.position);
  EXPECT_EQ(added.solver->read(), state);
  EXPECT_EQ(late->read(), state);

  Scene again(added.model);
  const auto replayed = make(added.model, again);
  Replay(recorder.recording(), *replayed, again).run();
  EXPECT_EQ(replayed->read(), state);
}

/// One that was stepped is not a placed one: what it covers then came there by its own motion, and is pushed.
TEST_P(ToolFirstPose, IsForgottenWithTheFirstStep) {
  Start start(GetParam(), {.shape = Sphere{0.008}, .pose = {.position = {0.01, 0.01, 0.5}}});
  ASSERT_TRUE(start.solver->step(1, start.dt).ok());
  State state = start.solver->read();
  EXPECT_FALSE(state.tools.at(0).placed);
  state.tools[0].pose.position = {0.01, 0.01, 0.0251};
  start.solver->reset(state);
  EXPECT_GT(start.solver->step(1, start.dt).max_speed, 1.0);
  state.tools[0].placed = true;
  start.solver->reset(state);
  EXPECT_LE(start.solver->step(1, start.dt).max_speed, 1e-9);
}

}  // namespace
}  // namespace phymul::test
