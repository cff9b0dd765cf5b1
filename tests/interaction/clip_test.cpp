// SPDX-License-Identifier: MIT
//
// Clips: they close a fold to their gap, hold up to their force, open above it, and come off.
#include <gtest/gtest.h>
#include <phymul/recording.h>
#include <phymul/state_file.h>

#include "support/joined_particles.h"
#include "support/message_of.h"
#include "support/run_scenes.h"
#include "support/sutured_wound.h"

namespace phymul::test {
namespace {

constexpr double clip_dt = 0.5e-3;  // s

TEST(Clip, ClosesToItsGapHoldsToItsForceThenSlipsAndComesOff) {
  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.006, 0, 0)}, 1e-3);
  Scene scene(model);
  scene.fix(std::vector<Index>{0});
  Load load{.type = LoadType::force, .particles = {1}, .events = {{0.0, 0.4}}, .direction = {1, 0, 0}};
  scene.add(load);
  const ThreadHandle clip =
      scene.add_clip("clip", {.gap = 1e-3, .holding = 0.5, .opening = 4e-3}, at_particle(0), at_particle(1));
  const auto solver = loose_solver("reference", model, scene, {.damping = {.rate = 50.0}});
  const auto width = [&] { return solver->read().position[1].x() - solver->read().position[0].x(); };
  const auto pull = [&](double force, int steps) {
    load.events = {{0.0, force}};
    scene.replace(1, load);
    ASSERT_TRUE(solver->step(steps, clip_dt).ok());
  };
  ASSERT_TRUE(solver->step(400, clip_dt).ok());
  EXPECT_NEAR(width(), 1e-3, 1e-5);
  EXPECT_NEAR(solver->thread_state(clip).tension[1], 0.4, 1e-3);
  pull(0.499, 400);
  EXPECT_NEAR(width(), 1e-3, 1e-5);
  pull(0.52, 60);
  EXPECT_NEAR(solver->thread_state(clip).tension[1], 0.5, 1e-12);
  const double slipped = width();
  EXPECT_GT(slipped, 1.2e-3);
  pull(0.4, 400);  // it stays as far open
  EXPECT_GT(width(), slipped - 1e-5);
  EXPECT_NEAR(solver->thread_state(clip).tension[1], 0.4, 1e-3);
  pull(1.0, 200);
  EXPECT_EQ(solver->thread_state(clip).pulled_out, 1);
  EXPECT_GT(width(), 0.01);
}

/// It comes off as far open whatever the number of steps in which it closed.
TEST(Clip, ComesOffOpenedByItsOpeningMoreThanAtFirst) {
  for (const int closing : {1, 10, 400}) {
    const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.006, 0, 0)}, 1e-3);
    Scene scene(model);
    scene.fix(std::vector<Index>{0});
    Load load{.type = LoadType::force, .particles = {1}, .events = {{0.0, 0.1}}, .direction = {1, 0, 0}};
    scene.add(load);
    const ThreadHandle clip =
        scene.add_clip("clip", {.gap = 1e-3, .holding = 0.5, .opening = 4e-3}, at_particle(0), at_particle(1));
    const auto solver = loose_solver("reference", model, scene, {.damping = {.rate = 50.0}});
    ASSERT_TRUE(solver->step(closing, clip_dt).ok());
    ASSERT_TRUE(solver->step(400, clip_dt).ok());
    load.events = {{0.0, 0.51}};
    scene.replace(1, load);
    double width = 0.0;
    for (int k = 0; k < 2000 && solver->thread_state(clip).pulled_out == 0; ++k) {
      width = solver->read().position[1].x();
      ASSERT_TRUE(solver->step(1, clip_dt).ok());
    }
    EXPECT_EQ(solver->thread_state(clip).pulled_out, 1);
    const double speed = solver->read().velocity[1].x();
    EXPECT_NEAR(width, 0.006 + 0.004, 2.0 * clip_dt * speed) << closing;
  }
}

/// Put on again it closes to its new gap.
TEST(Clip, IsPutOnAgain) {
  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.006, 0, 0)}, 1e-3);
  Scene scene(model);
  scene.fix(std::vector<Index>{0});
  scene.add({.type = LoadType::force, .particles = {1}, .events = {{0.0, 0.1}}, .direction = {1, 0, 0}});
  const ThreadHandle clip =
      scene.add_clip("clip", {.gap = 4e-3, .holding = 0.5, .opening = 8e-3}, at_particle(0), at_particle(1));
  const auto solver = loose_solver("reference", model, scene, {.damping = {.rate = 50.0}});
  const auto width = [&] { return solver->read().position[1].x() - solver->read().position[0].x(); };
  ASSERT_TRUE(solver->step(400, clip_dt).ok());
  EXPECT_NEAR(width(), 4e-3, 1e-5);
  for (const ThreadTip tip : {ThreadTip::first, ThreadTip::last}) clip.clamp(tip, 0.5, 2e-3);
  ASSERT_TRUE(solver->step(400, clip_dt).ok());
  ASSERT_TRUE(solver->step(400, clip_dt).ok());
  EXPECT_NEAR(width(), 2e-3, 1e-5);
}

/// One that slipped closes again by the same call, and so it does in a recording.
TEST(Clip, IsClosedAgainByTheSameValues) {
  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.006, 0, 0)}, 1e-3);
  const auto make = [&](Scene& scene) {
    scene.fix(std::vector<Index>{0});
    scene.add({.type = LoadType::force, .particles = {1}, .events = {{0.0, 0.1}}, .direction = {1, 0, 0}});
    scene.add_clip("clip", {.gap = 2e-3, .holding = 0.5, .opening = 8e-3}, at_particle(0), at_particle(1));
    return loose_solver("reference", model, scene, {.damping = {.rate = 50.0}});
  };
  Scene scene(model), again(model);
  const auto solver = make(scene), replayed = make(again);
  const auto width = [&] { return solver->read().position[1].x() - solver->read().position[0].x(); };
  ASSERT_TRUE(solver->step(400, clip_dt).ok());
  State opened = solver->read();
  opened.threads[0].rest_length[1] = opened.position[1].x() = 5e-3;
  solver->reset(opened);
  Recorder recorder(*solver, scene);
  ASSERT_TRUE(recorder.step(200, clip_dt).ok());
  EXPECT_NEAR(width(), 5e-3, 1e-5) << "it stays as far open";
  for (const ThreadTip tip : {ThreadTip::first, ThreadTip::last}) scene.thread("clip").clamp(tip, 0.5, 2e-3);
  for (int k = 0; k < 2; ++k) ASSERT_TRUE(recorder.step(400, clip_dt).ok());
  EXPECT_NEAR(width(), 2e-3, 1e-5);
  Replay(recorder.recording(), *replayed, again).run();
  EXPECT_EQ(replayed->read(), solver->read());
  EXPECT_EQ(again.threads()[0].control, scene.threads()[0].control);
}

/// Both walls of a slit between two slabs; the snapshot, and a scene made of it, have the clip.
TEST(Clip, ClosesTwoWallsAndIsTakenOff) {
  Wound wound({0.02, 0.02, 0.01}, 0.006);
  wound.scene.fix("left/x0").fix("right/x1");
  const auto wall = [&](const char* name) { return at_mean(wound.model.group(name)); };
  wound.scene.add_clip("clip", {.gap = 2e-3, .holding = 1.0}, wall("left/x1"), wall("right/x0"));
  const auto solver = make_solver("reference", wound.model, wound.scene, {}, {.damping = {.rate = 60.0}});
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(static_cast<int>(0.5 / dt), dt).ok());
  ASSERT_TRUE(solver->step(static_cast<int>(0.5 / dt), dt).ok());
  EXPECT_NEAR(wound.gap_of(solver->read()), 2e-3, 2e-5);
  const std::string file = path_for("clip.state");
  save_state(*solver, file);
  Wound other({0.02, 0.02, 0.01}, 0.006);
  other.scene.fix("left/x0").fix("right/x1").bring_back(*read_state(file).scene);
  EXPECT_EQ(other.scene.threads().at(0).control, wound.scene.threads().at(0).control);
  wound.scene.remove_thread("clip");
  ASSERT_TRUE(solver->step(static_cast<int>(1.0 / dt), dt).ok());
  EXPECT_NEAR(wound.gap_of(solver->read()), 6e-3, 2e-4);
}

TEST(Clip, HasANameWithoutOneGiven) {
  Wound wound({0.02, 0.02, 0.01}, 0.006);
  const auto add = [&] { return wound.scene.add_clip({}, at_particle(0), at_particle(5)).thread().name; };
  EXPECT_EQ(add(), "clip 1");
  EXPECT_EQ(wound.scene.swage({}, "").thread().name, "thread 2");
  wound.scene.remove_thread("clip 1");
  EXPECT_EQ(add(), "clip 3");
}

TEST(Clip, RefusesWhatIsNone) {
  Wound wound({0.02, 0.02, 0.01}, 0.006);
  const auto add = [&](const Clip& clip, const Anchor& other) {
    return [&wound, clip, other] { wound.scene.add_clip("c", clip, at_particle(0), other); };
  };
  EXPECT_TRUE(refuses(add({.gap = -1.0}, at_particle(5)), "clip \"c\": expected a finite gap (m), 0 or more; got -1"));
  EXPECT_TRUE(refuses(add({.holding = 0.0}, at_particle(5)), "holding force (N) above 0, got 0"));
  EXPECT_TRUE(refuses(add({.opening = std::nan("")}, at_particle(5)), "opening (m) above 0"));
  EXPECT_TRUE(refuses(add({}, at_world({0, 0, 0})), "expected particles, got none"));
  wound.scene.add_tool("tool", {.shape = Sphere{1e-3}});
  EXPECT_TRUE(refuses(add({}, at_tool("tool")), "clip \"c\": expected particles, got none"));
  EXPECT_TRUE(refuses(add({}, at_particle(0)), "expected places that differ"));
  add({.opening = 200.0}, at_particle(5))();
  wound.scene.remove_thread("c");
  const ThreadHandle free = wound.scene.add_thread({}, {0, 0, 0}, {1, 0, 0});
  EXPECT_TRUE(refuses([&] { free.clamp(ThreadTip::first, 1.0); }, "expected a sewn thread to clamp"));
  EXPECT_TRUE(wound.scene.threads().size() == 1);
}

}  // namespace
}  // namespace phymul::test
