// SPDX-License-Identifier: MIT
//
// Clips: they close a fold to their gap, hold up to their force, open above it, and come off. Jaws: they close with
// their force, hold by friction alone, slip when pulled too hard, and go back with a snapshot.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>

#include "support/joined_particles.h"
#include "support/message_of.h"
#include "support/run_scenes.h"
#include "support/sutured_wound.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double clip_dt = 0.5e-3;  // s

/// Of two particles, of which one is held, and pulled by 0.1 N at first.
struct ClipOfTwo {
  explicit ClipOfTwo(const Clip& clip) : scene(model) {
    scene.fix(std::vector<Index>{0}).add(load);
    scene.add_clip("clip", clip, at_particle(0), at_particle(1));
    solver = loose_solver("reference", model, scene, {.damping = {.rate = 50.0}});
  }
  void pull(double force) {
    load.events = {{0.0, force}};
    scene.replace(1, load);
  }
  void step(int steps) { ASSERT_TRUE(solver->step(steps, clip_dt).ok()); }
  double width() const { return solver->read().position[1].x() - solver->read().position[0].x(); }
  ThreadHandle handle() { return scene.thread("clip"); }
  double tension() { return solver->thread_state(handle()).tension[1]; }
  Index pulled_out() { return solver->thread_state(handle()).pulled_out; }

  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.006, 0, 0)}, 1e-3);
  Load load{.type = LoadType::force, .particles = {1}, .events = {{0.0, 0.1}}, .direction = {1, 0, 0}};
  Scene scene;
  std::unique_ptr<Solver> solver;
};

TEST(Clip, ClosesToItsGapHoldsToItsForceThenSlipsAndComesOff) {
  ClipOfTwo clip({.gap = 1e-3, .holding = 0.5, .opening = 4e-3});
  clip.pull(0.4);
  clip.step(400);
  EXPECT_NEAR(clip.width(), 1e-3, 1e-5);
  EXPECT_NEAR(clip.tension(), 0.4, 1e-3);
  clip.pull(0.499);
  clip.step(400);
  EXPECT_NEAR(clip.width(), 1e-3, 1e-5);
  clip.pull(0.52);
  clip.step(60);
  EXPECT_NEAR(clip.tension(), 0.5, 1e-12);
  const double slipped = clip.width();
  EXPECT_GT(slipped, 1.2e-3);
  clip.pull(0.4);
  clip.step(400);  // it stays as far open
  EXPECT_GT(clip.width(), slipped - 1e-5);
  EXPECT_NEAR(clip.tension(), 0.4, 1e-3);
  clip.pull(1.0);
  clip.step(200);
  EXPECT_EQ(clip.pulled_out(), 1);
  EXPECT_GT(clip.width(), 0.01);
}

/// It comes off as far open whatever the number of steps in which it closed.
TEST(Clip, ComesOffOpenedByItsOpeningMoreThanAtFirst) {
  for (const int closing : {1, 10, 400}) {
    ClipOfTwo clip({.gap = 1e-3, .holding = 0.5, .opening = 4e-3});
    clip.step(closing);
    clip.step(400);
    clip.pull(0.51);
    double width = 0.0;
    for (int k = 0; k < 2000 && clip.pulled_out() == 0; ++k) {
      width = clip.width();
      clip.step(1);
    }
    EXPECT_EQ(clip.pulled_out(), 1);
    const double speed = clip.solver->read().velocity[1].x();
    EXPECT_NEAR(width, 0.006 + 0.004, 2.0 * clip_dt * speed) << closing;
  }
}

/// Put on again it closes to its new gap.
TEST(Clip, IsPutOnAgain) {
  ClipOfTwo clip({.gap = 4e-3, .holding = 0.5, .opening = 8e-3});
  clip.step(400);
  EXPECT_NEAR(clip.width(), 4e-3, 1e-5);
  for (const ThreadTip tip : {ThreadTip::first, ThreadTip::last}) clip.handle().clamp(tip, 0.5, 2e-3);
  clip.step(400);
  clip.step(400);
  EXPECT_NEAR(clip.width(), 2e-3, 1e-5);
}

/// One that slipped closes again by the same call, and so it does in a recording.
TEST(Clip, IsClosedAgainByTheSameValues) {
  const Clip given{.gap = 2e-3, .holding = 0.5, .opening = 8e-3};
  ClipOfTwo clip(given), again(given);
  clip.step(400);
  State opened = clip.solver->read();
  opened.threads[0].rest_length[1] = opened.position[1].x() = 5e-3;
  clip.solver->reset(opened);
  Recorder recorder(*clip.solver, clip.scene);
  ASSERT_TRUE(recorder.step(200, clip_dt).ok());
  EXPECT_NEAR(clip.width(), 5e-3, 1e-5) << "it stays as far open";
  for (const ThreadTip tip : {ThreadTip::first, ThreadTip::last}) clip.handle().clamp(tip, 0.5, 2e-3);
  for (int k = 0; k < 2; ++k) ASSERT_TRUE(recorder.step(400, clip_dt).ok());
  EXPECT_NEAR(clip.width(), 2e-3, 1e-5);
  Replay(recorder.recording(), *again.solver, again.scene).run();
  EXPECT_EQ(again.solver->read(), clip.solver->read());
  EXPECT_EQ(again.scene.threads()[0].control, clip.scene.threads()[0].control);
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

constexpr double jaws_tick = 2e-3;  // s

/// An ellipsoid whose tip at +x is between jaws that come from there and open along z.
struct Grasp {
  Vec3 at{0.068, 0, 0};  // m, of the hinge
  Simulation sim;
  Jaws jaws;

  Grasp(const std::string& backend, const JawsOptions& options)
      : sim(body(), {.backend = backend, .damping = {.rate = 50.0}}), jaws(sim.scene(), "grasper", options, hinge()) {
    std::vector<Index> held;
    for (Index i = 0; i < sim.model().particle_count(); ++i) {
      if (sim.model().rest[i].x() < -0.03) held.push_back(i);
    }
    sim.scene().fix(held);
  }
  static Model body() {
    return with_material(make_body(solid_ellipsoid({0, 0, 0}, {0.06, 0.03, 0.02}), {.spacing = 0.009}),
                         {.young = 5e3, .poisson = 0.45, .density = 1000.0});
  }
  ToolPose hinge() const {
    Mat3 turn;
    turn << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    return {.position = at, .orientation = Quaternion(turn)};
  }
  /// Ticks in which the hinge goes to a place.
  void go(const Vec3& to, double seconds) {
    const int ticks = static_cast<int>(std::lround(seconds / jaws_tick));
    const Vec3 from = at;
    for (int k = 1; k <= ticks; ++k) {
      at = from + (to - from) * k / ticks;
      jaws.follow(hinge(), sim.force_on(jaws.first()), sim.force_on(jaws.second()), jaws_tick);
      ASSERT_TRUE(is_ok(sim.advance(jaws_tick)));
    }
  }
  Vec3 tip() const {
    const VecList& rest = sim.model().rest;
    const auto first = std::ranges::max_element(rest, {}, [](const Vec3& x) { return x.x(); });
    return sim.state().position[static_cast<std::size_t>(first - rest.begin())];
  }
};

JawsOptions wide(double grip) {
  return {.length = 0.024, .width = 0.02, .friction = 0.8, .grip = grip, .opening = 1.2, .speed = 1.0};
}

class JawsOn : public WithTools {};
PHYMUL_ON_EVERY_BACKEND(JawsOn);

TEST(Jaws, CloseWithTheirForceAndLiftByFrictionAlone) {
  for (const ToolContact contact : {ToolContact::surface, ToolContact::particles}) {
    SCOPED_TRACE(contact == ToolContact::surface);
    JawsOptions options = wide(1.0);
    options.contact = contact;
    Grasp grasp("cpu", options);
    EXPECT_NEAR(grasp.jaws.angle(), 1.2, 1e-9);
    grasp.jaws.close();
    grasp.go(grasp.at, 1.5);
    EXPECT_NEAR(grasp.jaws.grip(), 1.0, contact == ToolContact::surface ? 0.05 : 0.15);
    EXPECT_GT(grasp.jaws.angle(), 0.05);
    EXPECT_LT(grasp.jaws.angle(), 1.1);
    const Vec3 before = grasp.tip();
    grasp.go(grasp.at + Vec3(0, 0, 0.03), 1.0);
    grasp.go(grasp.at, 0.3);
    EXPECT_NEAR(grasp.jaws.grip(), 1.0, 0.15);
    EXPECT_NEAR((grasp.tip() - before).z(), 0.03, 1e-3);
    EXPECT_LT(grasp.jaws.force().z(), -0.08);  // N: the body is bent
    grasp.jaws.open();
    grasp.go(grasp.at, 1.5);
    EXPECT_NEAR(grasp.jaws.angle(), 1.2, 1e-9);
  }
}

TEST(Jaws, SlipWhenPulledTooHard) {
  Grasp grasp("cpu", wide(0.1));
  grasp.jaws.close();
  grasp.go(grasp.at, 1.0);
  EXPECT_NEAR(grasp.jaws.grip(), 0.1, 0.02);
  grasp.go(grasp.at + Vec3(0.04, 0, 0), 1.5);
  grasp.go(grasp.at, 0.5);
  EXPECT_LT(grasp.jaws.force().norm(), 1e-3);
  EXPECT_NEAR(grasp.jaws.angle(), 0.0, 1e-9) << "nothing is between them";
}

TEST_P(JawsOn, ContinueBitForBitFromASnapshot) {
  Grasp grasp(GetParam(), wide(0.5));
  grasp.jaws.close();
  grasp.go(grasp.at, 0.3);
  const Snapshot then = grasp.sim.snapshot();
  const Vec3 from = grasp.at, to = from + Vec3(0.002, 0, 0);
  grasp.go(to, 0.1);
  const State first = grasp.sim.state();
  grasp.sim.restore(then);
  grasp.at = from;
  grasp.go(to, 0.1);
  EXPECT_EQ(grasp.sim.state().position, first.position);
  EXPECT_EQ(grasp.sim.state().tools, first.tools);
}

TEST(Jaws, AreInRecordings) {
  Grasp grasp("cpu", wide(0.5));
  grasp.sim.record();
  grasp.jaws.close();
  grasp.go(grasp.at, 0.4);
  Simulation again(Grasp::body(), {.backend = "cpu", .damping = {.rate = 50.0}});
  again.replay(grasp.sim.recording());
  EXPECT_EQ(again.snapshot().state, grasp.sim.snapshot().state);
}

TEST(Jaws, RefuseWhatMakesNoSense) {
  Model model = soft_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Scene scene(model);
  const auto refuses_with = [&](const JawsOptions& options, std::string_view what) {
    return refuses([&] { Jaws(scene, "j", options, {}); }, what);
  };
  EXPECT_TRUE(refuses_with({.length = 0.0}, "expected a length (m) above 0, got 0"));
  EXPECT_TRUE(refuses_with({.grip = -1.0}, "expected a grip (N) above 0, got -1"));
  EXPECT_TRUE(refuses_with({.opening = 4.0}, "of at most 3 rad, got 4"));
  EXPECT_TRUE(refuses_with({.friction = -1.0}, "friction"));
  EXPECT_TRUE(refuses_with({.toughness = -1.0}, "expected a toughness (J/m^2) of 0 or more, got -1"));
  EXPECT_TRUE(refuses([&] { Jaws(scene, "", {}, {}); }, "Jaws: expected a name, got an empty one"));
  EXPECT_TRUE(scene.tools().empty());
  scene.add_tool("k 2", {.shape = Sphere{0.001}});
  EXPECT_TRUE(refuses([&] { Jaws(scene, "k", {}, {}); }, "k 2"));
  EXPECT_EQ(scene.tools().size(), 1u);
  scene.remove_tool("k 2");
  Jaws jaws(scene, "j", {}, {});
  EXPECT_EQ(scene.tools().size(), 2u);
  EXPECT_TRUE(refuses([&] { jaws.follow({}, {}, {}, -1.0); }, "expected a tick (s) of 0 or more, got -1"));
}

}  // namespace
}  // namespace phymul::test
