// SPDX-License-Identifier: MIT
//
// Threads in snapshots, state files, recordings and edited bodies, and the same bits whatever the number of threads.
// Joints in snapshots, state files, recordings and warnings.
#include <gtest/gtest.h>
#include <phymul/recording.h>

#include <filesystem>

#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"
#include "support/sutured_wound.h"

namespace phymul::test {
namespace {

Simulation wound_on(const std::string& backend, int threads = 0) {
  Model model = Wound::slabs({0.02, 0.02, 0.01}, 0.006);
  Simulation sim(std::move(model), {.backend = backend, .damping = {.rate = 20.0}, .solver = {.threads = threads}});
  sim.scene().fix("left/x0").fix("right/x1").gravity({0, 0, -1.0});
  return sim;
}

ThreadHandle sew_on(Scene& scene) {
  return scene.sew("stitch", {.friction = 0.2},
                   VecList{{-0.006, 0.01, 0.01}, {-0.004, 0.01, 0.004}, {0.004, 0.01, 0.004}, {0.006, 0.01, 0.01}});
}

/// Each step does something else; threads come, go and change.
template <class Steps>
void operate(Scene& scene, const Steps& steps) {
  const ThreadHandle stitch = sew_on(scene);
  stitch.pull(ThreadTip::first, {0.01, 0, 0});
  steps(20);
  const ThreadHandle free = scene.add_thread("free", {.length = 0.03}, {0, 0, 0.02}, {0, 1, 0});
  free.hold(0, {0, 0, 0.02});
  free.join(ThreadTip::last, scene.threads()[0].passages[3]);
  stitch.pull(ThreadTip::last, {-0.01, 0, 0.001});
  steps(20);
  scene.add_tool("hand", {.shape = Sphere{1e-3}, .pose = {.position = {0, 0.03, 0.03}}});
  free.join(ThreadTip::first, at_tool("hand"));
  free.hold(4, {0, 0.01, 0.03});
  stitch.tie(0, 3, 2);
  steps(20);
  scene.tool("hand").move_to({.position = {0, 0.03, 0.035}});
  free.release(4);
  steps(20);
  free.pull(ThreadTip::first, {0, 0, 0});
  scene.remove_tool("hand");
  steps(5);
  scene.remove_thread("free");
  steps(10);
}

class ThreadSessionIn : public OnEveryBackend {};
PHYMUL_ON_EVERY_BACKEND(ThreadSessionIn);

TEST_P(ThreadSessionIn, SnapshotsContinueBitForBit) {
  Simulation sim = wound_on(GetParam());
  std::vector<Snapshot> seen;
  const double dt = 0.4 * sim.solver().stable_step();
  operate(sim.scene(), [&](int steps) {
    ASSERT_TRUE(sim.step(steps / 2, dt).ok());
    const Snapshot middle = sim.snapshot();
    ASSERT_TRUE(sim.step(steps / 2, dt).ok());
    const Snapshot end = sim.snapshot();
    ASSERT_EQ(end.state.threads.size(), sim.scene().threads().size());
    sim.restore(middle);
    EXPECT_EQ(sim.snapshot().state.threads, middle.state.threads);
    ASSERT_TRUE(sim.step(steps / 2, dt).ok());
    EXPECT_EQ(sim.snapshot().state.threads, end.state.threads);
    EXPECT_EQ(sim.snapshot().state.position, end.state.position);
    const std::string path = testing::TempDir() + "phymul_threads_" + GetParam() + ".state";
    save_state(middle, path);
    EXPECT_EQ(read_state(path), middle);
    Simulation other = wound_on(GetParam());
    other.load(path);
    std::filesystem::remove(path);
    ASSERT_EQ(other.scene().threads().size(), middle.state.threads.size());
    ASSERT_TRUE(other.step(steps / 2, dt).ok());
    EXPECT_EQ(other.snapshot().state.threads, end.state.threads);
    seen.push_back(end);
  });
  ASSERT_EQ(seen.size(), 6u);
  EXPECT_GT(seen[2].state.threads[0].knots.size(), 0u);
  EXPECT_GT(seen[3].state.threads[0].tension[2], 1e-3);
}

TEST(ThreadSession, RecordingsRepeatThemBitForBit) {
  for (const std::string backend : {"reference", "cpu"}) {
    Simulation sim = wound_on(backend);
    const double dt = 0.4 * sim.solver().stable_step();
    static_cast<void>(sew_on(sim.scene()));
    ASSERT_TRUE(sim.step(5, dt).ok());
    sim.record();
    sim.scene().remove_thread("stitch");
    operate(sim.scene(), [&](int steps) {
      for (int k = 0; k < steps; ++k) ASSERT_TRUE(sim.step(1, dt).ok());
    });
    const Recording recording = sim.recording();
    const Snapshot end = sim.snapshot();
    Simulation other = wound_on(backend);
    other.replay(recording);
    EXPECT_EQ(other.snapshot().state, end.state) << backend;
    EXPECT_EQ(other.snapshot(), end) << backend;
  }
}

/// A tool that a thread has left may go in the same pause between two steps.
TEST(ThreadSession, RecordingsRepeatATipThatGoesFromToolToTool) {
  Simulation sim = wound_on("reference");
  const auto add = [&](const char* name) {
    sim.scene().add_tool(name, {.shape = Sphere{1e-3}, .pose = {.position = {0, 0.03, 0.03}}});
  };
  add("a");
  const ThreadHandle free = sim.scene().add_thread("free", {.length = 0.03}, {0, 0.03, 0.03}, {0, 1, 0});
  free.join(ThreadTip::first, at_tool("a"));
  ASSERT_TRUE(sim.step(2, 1e-4).ok());
  sim.record();
  for (const auto& [old, next] : {std::pair{"a", "b"}, {"b", "a"}}) {
    add(next);
    free.join(ThreadTip::first, at_tool(next));
    sim.scene().remove_tool(old);
    ASSERT_TRUE(sim.step(2, 1e-4).ok());
  }
  Simulation other = wound_on("reference");
  other.replay(sim.recording());
  EXPECT_EQ(other.snapshot(), sim.snapshot());
}

/// One that was removed comes back, one that was added goes, one that was changed is as it was.
TEST(ThreadSession, RecordingsRepeatWhatARestoreBringsBack) {
  Simulation sim = wound_on("cpu");
  const double dt = 0.4 * sim.solver().stable_step();
  sim.record();
  sew_on(sim.scene());
  sim.step(10, dt);
  const Snapshot with = sim.snapshot();
  sim.scene().remove_thread("stitch");
  sim.step(10, dt);
  sim.restore(with);
  sim.step(10, dt);
  sim.scene().add_thread("free", {.length = 0.03}, {0, 0, 0.02}, {0, 1, 0});
  sim.scene().thread("stitch").pull(ThreadTip::last, {0, 0, 0.02});
  sim.step(10, dt);
  sim.restore(with);
  sim.step(10, dt);
  Simulation other = wound_on("cpu");
  other.replay(sim.recording());
  EXPECT_EQ(other.snapshot(), sim.snapshot());
}

TEST(ThreadSession, TheNumberOfThreadsChangesNoBit) {
  std::vector<State> ends;
  for (const int threads : {1, 2, 3}) {
    Simulation sim = wound_on("cpu", threads);
    operate(sim.scene(), [&](int steps) { ASSERT_TRUE(sim.advance(1e-3 * steps).ok()); });
    ends.push_back(sim.solver().read());
  }
  EXPECT_EQ(ends[0], ends[1]);
  EXPECT_EQ(ends[0], ends[2]);
}

TEST_P(ThreadSessionIn, PassagesLetGoOfRemovedCells) {
  Simulation sim(Wound::slabs({0.02, 0.02, 0.01}, 0.006), {.backend = GetParam()});
  sim.scene().fix("left/x0").fix("right/x1");
  const ThreadHandle stitch = sew_on(sim.scene());
  ASSERT_TRUE(sim.advance(0.001).ok());
  EXPECT_EQ(sim.solver().thread_state(stitch).passages.size(), 4u);
  sim.remove_cells(sim.model().cells_in([](const Vec3& x) { return x.x() > 0.0 && x.x() < 0.01; }));
  ASSERT_TRUE(sim.advance(0.005).ok());
  const ThreadState& state = sim.solver().thread_state(stitch);
  EXPECT_EQ(state.torn, 2);
  EXPECT_EQ(state.passages, (std::vector<Index>{0, 1}));
}

/// Also those that were removed before the first step, and tips.
TEST_P(ThreadSessionIn, NothingHoldsAtRemovedCells) {
  Simulation sim(Wound::slabs({0.02, 0.02, 0.01}, 0.006), {.backend = GetParam()});
  sim.scene().fix("left/x0").fix("right/x1").gravity({0, 0, -1.0});
  const Anchor wall = at_mean(sim.model().group("right/x0"));
  const ThreadHandle joined = sim.scene().sew("joined", {}, VecList{{-0.006, 0.01, 0.01}, {-0.004, 0.01, 0.004}});
  joined.join(ThreadTip::last, wall);
  const ThreadHandle free = sim.scene().add_thread("free", {.length = 0.03}, {0.003, 0.01, 0.005}, {-1, 0, 0});
  free.join(ThreadTip::first, wall);
  ASSERT_TRUE(sim.advance(0.01).ok());
  EXPECT_TRUE(sim.solver().thread_state(joined).anchored[1]);
  const ThreadHandle stitch = sew_on(sim.scene());
  sim.remove_cells(sim.model().cells_in([](const Vec3& x) { return x.x() > 0.0 && x.x() < 0.01; }));
  ASSERT_TRUE(sim.advance(0.05).ok());
  EXPECT_EQ(sim.solver().thread_state(stitch).torn, 2);
  EXPECT_EQ(sim.solver().thread_state(stitch).passages, (std::vector<Index>{0, 1}));
  EXPECT_EQ(sim.solver().thread_state(joined).tension[2], 0.0);
  EXPECT_EQ(sim.solver().thread_state(joined).force[1], Vec3(0, 0, 0));
  const Vec3 tip = sim.solver().thread_state(free).position.front();
  ASSERT_TRUE(sim.advance(0.05).ok());
  EXPECT_LT(sim.solver().thread_state(free).position.front().z(), tip.z() - 1e-3) << "it falls";
}

TEST(ThreadSession, StatesThatDoNotFitAreRefused) {
  Simulation sim = wound_on("reference");
  sew_on(sim.scene()).tie(0, 3, 2);
  sim.scene().add_thread("free", {.length = 0.03}, {0, 0, 0.02}, {0, 1, 0});
  ASSERT_TRUE(sim.step(5, 1e-4).ok());
  const State good = sim.solver().read();
  const auto refusal = [&](const auto& change) {
    State bad = good;
    change(bad.threads[0], bad.threads[1]);
    return message_of([&] { sim.unrecorded_solver().reset(bad); });
  };
  EXPECT_EQ(refusal([](ThreadState&, ThreadState&) {}), message_of([] {}));
  using Sewn = ThreadState;
  EXPECT_NE(refusal([](Sewn& sewn, ThreadState&) { sewn.passages[1] = 7; }).find("\"stitch\""), std::string::npos);
  EXPECT_NE(refusal([](Sewn& sewn, ThreadState&) { sewn.slides[0] = 2; }).find("\"stitch\""), std::string::npos);
  EXPECT_NE(refusal([](Sewn& sewn, ThreadState&) { sewn.tension.pop_back(); }).find("\"stitch\""), std::string::npos);
  EXPECT_NE(refusal([](Sewn& sewn, ThreadState&) { sewn.knots[0].b = 9; }).find("\"stitch\""), std::string::npos);
  EXPECT_NE(refusal([](Sewn& sewn, ThreadState&) { sewn.position.clear(); }).find("\"stitch\""), std::string::npos);
  EXPECT_NE(refusal([](Sewn& sewn, ThreadState&) {
              sewn = {.name = "stitch", .anchored = {true, false}};
            }).find("\"stitch\""),
            std::string::npos);
  EXPECT_NE(refusal([](Sewn&, ThreadState& free) { free.position.pop_back(); }).find("\"free\""), std::string::npos);
  EXPECT_NE(refusal([](Sewn&, ThreadState& free) { free.touch.assign(1, Vec3(0, 0, 1)); }).find("\"free\""),
            std::string::npos);
  EXPECT_NE(refusal([](Sewn& sewn, ThreadState&) {
              sewn.touch.assign(sewn.position.size(), Vec3(0, 0, 1));
            }).find("\"stitch\""),
            std::string::npos);
  EXPECT_NE(refusal([](Sewn&, ThreadState& free) { free.velocity[2].x() = std::nan(""); }).find("\"free\""),
            std::string::npos);
  EXPECT_NE(message_of([&] { static_cast<void>(sim.solve_static()); }).find("the scene has threads"),
            std::string::npos);
}

/// A scene's thread is compared with the snapshot's bit for bit.
TEST(ThreadSession, ComesBackInAnyDirection) {
  std::mt19937 bits(3);
  for (int k = 0; k < 20; ++k) {
    Simulation sim = wound_on("reference"), other = wound_on("reference");
    sim.scene().add_thread("free", {.length = 0.03}, {0, 0, 0.02}, random_vector(bits, 3));
    ASSERT_TRUE(sim.step(1, 1e-4).ok());
    const Snapshot before = sim.snapshot();
    sim.scene().remove_thread("free");
    ASSERT_TRUE(sim.step(1, 1e-4).ok());
    for (Simulation* const to : {&sim, &other}) {
      to->restore(before);
      EXPECT_EQ(to->state().threads, before.state.threads);
    }
  }
}

class JointSessionIn : public OnEveryBackend {
 protected:
  /// A block on a bed of springs that tear one after the other while gravity lifts it on one side.
  Simulation on_a_bed() const {
    Simulation sim(with_material(make_block({0.04, 0.02, 0.02}, 4, 2, 2)), {.backend = GetParam()});
    sim.scene().gravity({30, 0, 9.81});
    sim.scene().attach(sim.model().group("z0"), World{},
                       {.stiffness = 4e5, .damping = 10.0, .breaking_stress = 400.0, .name = "bed"});
    return sim;
  }
};
PHYMUL_ON_EVERY_BACKEND(JointSessionIn);

TEST_P(JointSessionIn, SnapshotsKnowWhatBroke) {
  Simulation sim = on_a_bed();
  int broken = 0;
  while (broken == 0 && sim.time() < 1.0) {
    ASSERT_TRUE(sim.advance(0.001).ok());
    broken = sim.solver().joint_report("bed").broken;
  }
  ASSERT_GT(broken, 0);
  ASSERT_LT(broken, 15) << "some hold still";
  const Snapshot middle = sim.snapshot();
  ASSERT_EQ(middle.state.joints.size(), 1u);
  EXPECT_EQ(static_cast<int>(middle.state.joints[0].broken.size()), broken);
  ASSERT_TRUE(sim.advance(0.02).ok());
  const Snapshot end = sim.snapshot();
  sim.restore(middle);
  EXPECT_EQ(sim.solver().joint_report("bed").broken, broken);
  ASSERT_TRUE(sim.advance(0.02).ok());
  EXPECT_EQ(sim.snapshot(), end);

  const std::string path = testing::TempDir() + "phymul_joints_" + GetParam() + ".state";
  save_state(middle, path);
  EXPECT_EQ(read_state(path), middle);
  Simulation other = on_a_bed();
  other.load(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(other.advance(0.02).ok());
  EXPECT_EQ(other.snapshot(), end);

  sim.unrecorded_solver().reset();
  EXPECT_EQ(sim.solver().joint_report("bed").broken, 0);
  EXPECT_TRUE(sim.solver().read().joints.empty());
  State wrong = middle.state;
  wrong.joints[0].broken = {15};
  EXPECT_TRUE(refuses([&] { sim.unrecorded_solver().reset(wrong); }, "joint \"bed\" has the broken spring 15"));
  wrong.joints[0].name = "gone";
  sim.unrecorded_solver().reset(wrong);
  EXPECT_EQ(sim.solver().joint_report("bed").broken, 0) << "of a joint that the scene does not have";
}

TEST_P(JointSessionIn, AReplayHasTheSameBits) {
  Simulation sim = on_a_bed();
  sim.record();
  ASSERT_TRUE(sim.advance(0.01).ok());
  const ToolHandle tool = sim.scene().add_tool({.shape = Sphere{0.001}, .pose = {.position = {0.02, 0.01, 0.05}}});
  const JointHandle rope =
      sim.scene().add_joint({at_mean(sim.model().group("z1")), at_tool("tool 1", {0, 0, 0.01})}, 5.0, 0.01);
  ASSERT_TRUE(sim.advance(0.01).ok());
  rope.set_rest_length(0.02);
  sim.scene().joint("bed").set_stiffness(3e5, 5.0);
  tool.move_to({.position = {0.02, 0.015, 0.06}});
  ASSERT_TRUE(sim.advance(0.01).ok());
  sim.scene().remove_joint("joint 2").remove_tool("tool 1");
  sim.scene().attach(sim.model().group("x0"), World{{-0.01, 0, 0}}, {.stiffness = 1e4, .slack = true});
  ASSERT_TRUE(sim.advance(0.01).ok());
  const Snapshot end = sim.snapshot();
  EXPECT_FALSE(end.state.joints.empty()) << "some springs broke, or this shows less";
  const Recording recording = sim.recording();

  Simulation again(sim.model(), {.backend = GetParam()});
  again.replay(recording);
  EXPECT_EQ(again.snapshot(), end);
  ASSERT_EQ(again.scene().joints().size(), 2u);
  for (std::size_t row = 0; row < 2; ++row) {
    EXPECT_EQ(again.scene().joints()[row].name, sim.scene().joints()[row].name);
    EXPECT_EQ(again.scene().joints()[row].joint, sim.scene().joints()[row].joint);
  }
}

/// Scene::bring_back() puts a tool and a joint before others that stayed.
TEST_P(JointSessionIn, AReplayHasWhatWasBroughtBackInItsOrder) {
  Simulation sim = on_a_bed();
  const auto add_tool = [&](const char* name, double x) {
    sim.scene().add_tool(name, {.shape = Sphere{0.002}, .pose = {.position = {x, 0.01, 0.021}}});
  };
  add_tool("bed", 0.005);
  add_tool("b", 0.015);
  sim.scene().attach(sim.model().group("x0"), World{{-0.01, 0, 0}}, {.stiffness = 1e4});
  sim.record();
  ASSERT_TRUE(sim.advance(0.002).ok());
  const SceneParts all = sim.scene().parts();
  sim.scene().remove_joint("bed").remove_tool("bed");
  ASSERT_TRUE(sim.advance(0.002).ok());
  sim.scene().bring_back(all);
  ASSERT_TRUE(sim.advance(0.002).ok());
  Simulation again(sim.model(), {.backend = GetParam()});
  again.replay(sim.recording());
  EXPECT_EQ(difference(again.scene().parts(), all), "");
  EXPECT_EQ(again.snapshot(), sim.snapshot());
}

TEST(JointsAtRest, PullNothingThatIsRemoved) {
  Simulation sim(with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2)), {.backend = "reference"});
  sim.scene().fix("z0");
  const std::vector<Index> top = sim.model().group("z1");
  sim.remove_cells(
      sim.model().cells_in([](const Vec3& place) { return (place.array() > Vec3(0.01, 0.01, 0.01).array()).all(); }));
  const auto gone = std::ranges::find_if(top, [&](Index i) { return sim.model().mass[i] == 0.0; });
  ASSERT_NE(gone, top.end());
  const JointHandle rope = sim.scene().add_joint({at_particle(top.front()), at_particle(*gone), 0.005}, 20.0);
  ASSERT_TRUE(sim.solve_static().converged());
  EXPECT_EQ(sim.report_of(rope).broken, 1);
  EXPECT_LT(sim.max_displacement(), 1e-9);
}

TEST(JointWarnings, ABodyOnJointsIsHeld) {
  const Model block = with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2)), other = moved(block, {0.1, 0, 0});
  const Model both = merged({{"a", &block}, {"b", &other}});
  const auto warnings = [&](bool bed, bool rope) {
    Simulation sim(both, {.backend = "reference"});
    sim.scene().gravity({0, 0, -9.81});
    if (bed) sim.scene().attach(both.group("a/z0"), World{}, {.stiffness = 1e5});
    if (rope) sim.scene().add_joint({at_mean(both.group("b/x0")), at_mean(both.group("a/x1"))}, 5.0);
    return sim.warnings();
  };
  EXPECT_TRUE(says(warnings(false, true).at(0), "nothing holds the body"));
  EXPECT_TRUE(says(warnings(true, false).at(0), "\"b\", 27 particles"));
  EXPECT_TRUE(warnings(true, true).empty());
  Simulation idle(block, {.backend = "reference"});
  idle.scene().fix("z0").attach(block.group("x1"), World{}, {});
  EXPECT_TRUE(says(idle.warnings().at(0), "joint \"joint 1\" has neither stiffness nor damping"));
}

}  // namespace
}  // namespace phymul::test
