// SPDX-License-Identifier: MIT
//
// Threads in snapshots, state files, recordings and edited bodies, and the same bits whatever the number of threads.
#include <gtest/gtest.h>
#include <phymul/recording.h>

#include <filesystem>

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

}  // namespace
}  // namespace phymul::test
