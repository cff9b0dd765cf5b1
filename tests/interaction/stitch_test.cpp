// SPDX-License-Identifier: MIT
//
// Sewn threads: friction at bends, momentum, reactions, closing a wound, knots, and what gives way.
#include <gtest/gtest.h>
#include <phymul/elasticity.h>

#include <cmath>
#include <numeric>

#include "support/joined_particles.h"
#include "support/message_of.h"
#include "support/sanitized.h"
#include "support/sutured_wound.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

TEST(Stitch, SlidesThroughBendsByTheLawOfTheRope) {
  for (const double channel : {0.0, 0.02}) {
    const Thread constants{.length = 0.5, .friction = 0.3, .channel_friction = channel};
    Zigzag body(constants);
    body.thread->join(ThreadTip::first, at_world({-0.01, 0.01, 0}));
    body.thread->join(ThreadTip::last, at_world({0.05, 0.02, 0}));
    body.run(1);
    const double before = body.length();
    std::array<double, 5> wraps{};
    for (const double way : {0.002, -0.0015}) {  // pulled on, then let back: through all passages
      for (int k = 0; k < 20; ++k) {
        body.thread->join(ThreadTip::last, at_world(Vec3(0.05, 0.02 + way * (k + 1) / 20, 0)));
        for (std::size_t p = 0; p < 5; ++p) wraps[p] = body.wrap(p);  // at the step's start
        body.run(1);
      }
      const std::vector<double>& t = body.state().tension;
      for (std::size_t p = 0; p < 5; ++p) {
        const double grows = std::exp(constants.friction * wraps[p]);
        if (way > 0.0) {
          EXPECT_EQ(body.state().slides[p], 1) << p;
          EXPECT_NEAR(t[p + 1] / (t[p] * grows + channel), 1.0, 1e-9) << p;
        }
        EXPECT_LE(std::max(t[p], t[p + 1]), (std::min(t[p], t[p + 1]) * grows + channel) * (1 + 1e-9) + 1e-9) << p;
      }
      if (way > 0.0) {
        EXPECT_GT(t.back(), 0.5);
      }
      EXPECT_NEAR(body.length() / before, 1.0, 1e-10);
    }
  }
}

TEST(Stitch, StandsBetweenTheTwoLimitsOfFriction) {
  Zigzag body({.length = 0.5, .friction = 0.3});
  body.thread->join(ThreadTip::first, at_world({-0.01, 0.01, 0}));
  body.thread->pull(ThreadTip::last, {0.2, 0.9, 0});
  body.run(50);
  const double held = body.state().tension.front();
  EXPECT_GT(held, 0.05);
  const double pull = Vec3(0.2, 0.9, 0).norm();
  EXPECT_DOUBLE_EQ(body.state().tension.back(), pull);
  body.thread->pull(ThreadTip::last, {0.19, 0.855, 0});  // 5 % less: nothing slides back
  body.run(50);
  EXPECT_NEAR(body.state().tension.front(), held, 1e-9);
  EXPECT_EQ(body.state().slides[4], 0);
}

TEST(Stitch, ATipIsDrawnThroughTheTissue) {
  Zigzag body({.length = 0.1, .friction = 0.05}, 4);
  body.scene.add_tool("hand", {.shape = Sphere{1e-3}, .pose = {.position = {0.04, 0.02, 0}}});
  body.thread->pull(ThreadTip::first, Vec3::Zero());
  body.thread->join(ThreadTip::last, at_tool("hand"));
  body.run(1);
  body.scene.tool("hand").move_to({.position = {0.2, 0.02, 0}});
  body.run(400);
  EXPECT_EQ(body.state().pulled_out, 4);
  EXPECT_TRUE(body.state().passages.empty());
  EXPECT_EQ(body.state().torn, 0);
  EXPECT_EQ(body.solver->tool_force("hand").force, Vec3(0, 0, 0));
}

TEST(Stitch, AKnotHoldsAndThenSlips) {
  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.06, 0, 0), Vec3(0.02, 0, 0)}, 1e-3);
  Scene scene(model);
  scene.fix(std::vector<Index>{0, 1});
  Load load{.type = LoadType::force, .particles = {2}, .events = {{0.0, 1.0}}, .direction = {1, 0, 0}};
  scene.add(load);
  const ThreadHandle thread = scene.sew("s", {.length = 0.3, .throw_holding = 0.8},
                                        std::vector<Anchor>{at_particle(0), at_particle(1), at_particle(2)});
  const auto solver = loose_solver("reference", model, scene);
  thread.tie(2, 0, 2);
  ASSERT_TRUE(solver->step(200, stitch_dt).ok());
  const auto knot = [&] { return solver->thread_state(thread).knots.at(0); };
  const auto total = [&] {
    const ThreadState& state = solver->thread_state(thread);
    return std::accumulate(state.rest_length.begin(), state.rest_length.end(), knot().rest_length);
  };
  EXPECT_NEAR(knot().tension, 1.0, 1e-6);
  EXPECT_EQ(knot().slip, 0.0);
  EXPECT_NEAR(solver->read().position[2].x(), 0.02, 1e-3);
  EXPECT_NEAR(total(), 0.3, 1e-12);
  load.events = {{0.0, 3.0}};
  scene.replace(1, load);
  ASSERT_TRUE(solver->step(10, stitch_dt).ok());
  EXPECT_NEAR(knot().tension, 1.6, 1e-12);
  EXPECT_NEAR(knot().slip, solver->read().position[2].x() - 0.02, 1e-3);
  EXPECT_GT(knot().slip, 5e-3);
  EXPECT_NEAR(total(), 0.3, 1e-12);
  thread.loosen(0, 2);
  ASSERT_TRUE(solver->step(1, stitch_dt).ok());
  EXPECT_TRUE(solver->thread_state(thread).knots.empty());
}

TEST(Stitch, ABrokenKnotIsTiedAnewAndOneThatHoldsKeepsItsLength) {
  Zigzag body({.length = 0.1}, 2);
  body.thread->tie(0, 1, 1);
  body.run(1);
  State changed = body.solver->read();
  const double apart = changed.threads[0].knots.at(0).rest_length;
  for (const bool breaks : {false, true}) {
    changed.threads[0].knots[0] = {.a = 0, .b = 1, .rest_length = 2.0 * apart, .broken = breaks};
    body.solver->reset(changed);
    body.thread->tie(0, 1, 1);
    body.run(1);
    const KnotState& knot = body.state().knots.at(0);
    EXPECT_TRUE(!knot.broken && std::abs(knot.rest_length - (breaks ? 1.0 : 2.0) * apart) < 1e-3 * apart) << breaks;
  }
}

TEST(Stitch, ABrokenSegmentPullsNothing) {
  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.006, 0, 0)}, 1e-3);
  Scene scene(model);
  scene.add({.type = LoadType::force, .particles = {1}, .events = {{0.0, 1.0}}, .direction = {1, 0, 0}});
  const ThreadHandle thread =
      scene.fix(std::vector<Index>{0}).sew("s", {}, std::vector{at_particle(0), at_particle(1)});
  thread.clamp(ThreadTip::first, 2.0);
  thread.clamp(ThreadTip::last, 2.0);
  const auto solver = loose_solver("reference", model, scene);
  ASSERT_TRUE(solver->step(1, stitch_dt).ok());
  EXPECT_GT(solver->thread_state(thread).tension[1], 0.5);
  State changed = solver->read();
  changed.threads[0].broken[1] = 1;
  changed.velocity[1] = Vec3::Zero();
  solver->reset(changed);
  ASSERT_TRUE(solver->step(1, stitch_dt).ok());
  EXPECT_EQ(solver->thread_state(thread).tension[1], 0.0);
  EXPECT_NEAR(solver->read().velocity[1].x(), 1.0 / 1e-3 * stitch_dt, 1e-9);
}

/// Thread runs through the weaker of two clamps, whichever tip it is at.
TEST(Stitch, TheWeakerClampLetsThreadThrough) {
  for (const std::size_t weaker : {0, 1}) {
    const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.006, 0, 0)}, 1e-3);
    Scene scene(model);
    scene.fix(std::vector<Index>{0});
    scene.add({.type = LoadType::force, .particles = {1}, .events = {{0.0, 1.2}}, .direction = {1, 0, 0}});
    const ThreadHandle thread = scene.sew("s", {.friction = 0.0}, std::vector<Anchor>{at_particle(0), at_particle(1)});
    thread.clamp(ThreadTip::first, weaker == 0 ? 0.5 : 1.0);
    thread.clamp(ThreadTip::last, weaker == 1 ? 0.5 : 1.0);
    const auto solver = loose_solver("reference", model, scene);
    ASSERT_TRUE(solver->step(1, stitch_dt).ok());
    const double tail = solver->thread_state(thread).rest_length[2 * weaker];
    ASSERT_TRUE(solver->step(10, stitch_dt).ok());
    EXPECT_NEAR(solver->thread_state(thread).tension[1], 0.5, 1e-12) << weaker;
    EXPECT_LT(solver->thread_state(thread).rest_length[2 * weaker], tail - 1e-4) << weaker;
  }
}

/// The end that is drawn slips out of its own passages; those on the other side of the break keep theirs.
TEST(Stitch, ABrokenEndSlipsOutOfItsOwnPassages) {
  Zigzag body({.length = 0.1, .friction = 0.05}, 4);
  body.scene.add_tool("hand", {.shape = Sphere{1e-3}, .pose = {.position = {0.04, 0.02, 0}}});
  body.thread->join(ThreadTip::last, at_tool("hand"));
  body.run(1);
  State broken = body.solver->read();
  broken.threads[0].broken[2] = 1;
  body.solver->reset(broken);
  body.scene.tool("hand").move_to({.position = {0.2, 0.02, 0}});
  body.run(400);
  EXPECT_EQ(body.state().passages, (std::vector<Index>{0, 1}));
  EXPECT_EQ(body.state().pulled_out, 2);
}

/// A tip that particles take over from a hand does not jerk the thread: its segment is as long as the way there.
TEST(Stitch, ATipGoesOverToTissueWithoutAJerk) {
  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.006, 0, 0), Vec3(0.03, 0.02, 0)}, 1e-3);
  Scene scene(model);
  const ThreadHandle thread = scene.sew("s", {.length = 0.1}, std::vector<Anchor>{at_particle(0), at_particle(1)});
  thread.join(ThreadTip::last, at_world({0.01, 0, 0}));
  const auto solver = loose_solver("reference", model, scene);
  ASSERT_TRUE(solver->step(1, stitch_dt).ok());
  EXPECT_NEAR(solver->thread_state(thread).rest_length.back(), 0.004, 1e-15);
  for (const auto& [anchor, length] : {std::pair{at_particle(2), (model.rest[2] - model.rest[1]).norm()},
                                       {at_particle(0), 0.006},
                                       {at_world({0.006, 0.02, 0}), 0.02}}) {
    thread.join(ThreadTip::last, anchor);
    ASSERT_TRUE(solver->step(3, stitch_dt).ok());
    EXPECT_NEAR(solver->thread_state(thread).rest_length.back(), length, 1e-15);
    EXPECT_EQ(solver->read().velocity, VecList(3, Vec3::Zero()));
  }
}

class StitchIn : public WithTools {};
PHYMUL_ON_EVERY_BACKEND(StitchIn);

TEST_P(StitchIn, KeepsTheMomentumOfBothSides) {
  Wound wound({0.02, 0.02, 0.01}, 0.006);
  wound.stitch(0.01, {.friction = 0.1});
  const auto solver = make(wound.model, wound.scene);
  State start = rest_state(wound.model);
  for (const Index i : wound.model.group("right/all")) start.velocity[i] = Vec3(0.05, 0.02, -0.01);
  solver->reset(start);
  const Momentum before = solver->momentum();
  double most = 0.0;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(solver->step(1, 0.5 * solver->stable_step()).ok());
    for (const double t : solver->thread_state("stitch 1").tension) most = std::max(most, t);
  }
  EXPECT_GT(most, 0.003);
  const Momentum after = solver->momentum();
  const double rounding = GetParam() == "reference" ? 1e-12 : 2e-5;
  EXPECT_LT((after.linear - before.linear).norm(), rounding * before.linear.norm());
  EXPECT_LT((after.angular - before.angular).norm(), rounding * before.angular.norm());
}

TEST(Stitch, PullsAsMuchAsWhatHoldsTheTissue) {
  Wound wound({0.02, 0.02, 0.01}, 0.006);
  wound.scene.fix("left/x0").fix("right/x1");
  wound.stitch(0.01, {.friction = 0.1});
  wound.tighten(0, 0.02);
  const auto solver = make_solver("reference", wound.model, wound.scene, {}, {.damping = {.rate = 40.0}});
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(static_cast<int>(2.0 / dt), dt).ok());
  wound.tie_all();
  ASSERT_TRUE(solver->step(static_cast<int>(3.0 / dt), dt).ok());
  const State end = solver->read();
  const VecList force = forces_at(solver->topology(), end.position);
  Vec3 reaction = Vec3::Zero(), pull = Vec3::Zero();
  for (const Index i : wound.model.group("left/x0")) reaction += force[i];
  const ThreadState& thread = solver->thread_state("stitch 1");
  const auto along = [&](std::size_t a, std::size_t b) {
    return (thread.position[b] - thread.position[a]).normalized();
  };
  pull += thread.tension[2] * along(2, 3);  // deep, and at the knot
  pull += thread.knots.at(0).tension * along(1, 4);
  EXPECT_GT(pull.x(), 0.01);
  EXPECT_LT((pull - reaction).norm() / pull.norm(), 1e-9);
}

TEST(Stitch, MoreStitchesCloseAWoundFurther) {
  double last = 6e-3;
  for (const int count : {1, 2, 3, 5}) {
    Wound wound({0.03, 0.05, 0.01}, 0.006);
    wound.scene.fix("left/x0").fix("right/x1");
    for (int k = 0; k < count; ++k) wound.stitch(0.05 * (k + 0.5) / count, {.friction = 0.1});
    for (int k = 0; k < count; ++k) wound.tighten(k, 0.02);
    const auto solver = make_solver("reference", wound.model, wound.scene, {}, {.damping = {.rate = 30.0}});
    const double dt = 0.6 * solver->stable_step();
    ASSERT_TRUE(solver->step(static_cast<int>(0.6 / dt), dt).ok());
    wound.tie_all();
    ASSERT_TRUE(solver->step(static_cast<int>(0.3 / dt), dt).ok());
    const double gap = wound.gap_of(solver->read());
    EXPECT_LT(gap, last - 1e-4) << count;
    EXPECT_EQ(solver->thread_state("stitch 1").torn, 0);
    last = gap;
  }
  EXPECT_LT(last, 3e-3);
}

/// A thread that breaks and a passage that tears do so once, and the simulation continues.
TEST(Stitch, AThreadBreaksAndTissueTearsAtTheirLimits) {
  for (const bool breaks : {true, false}) {
    for (const double share : {0.4, 1.3}) {
      Wound wound({0.02, 0.02, 0.01}, 0.006);
      wound.scene.fix("left/x0").fix("right/x1");
      const double limit = 0.05;
      wound.stitch(0.01, breaks ? Thread{.breaking_force = limit} : Thread{.passage_limit = limit});
      const auto solver = make_solver("reference", wound.model, wound.scene, {}, {.damping = {.rate = 100.0}});
      const double dt = 0.5 * solver->stable_step();
      for (int k = 0; k < 50; ++k) {
        wound.tighten(0, share * limit * (k + 1) / 50);
        ASSERT_TRUE(solver->step(static_cast<int>(0.02 / dt), dt).ok());
      }
      const ThreadState& thread = solver->thread_state("stitch 1");
      EXPECT_EQ(std::ranges::count(thread.broken, 1) > 0, breaks && share > 1.0) << share;
      EXPECT_EQ(thread.torn > 0, !breaks && share > 1.0) << share;
      EXPECT_EQ(thread.passages.size(), 4u - static_cast<std::size_t>(thread.torn + thread.pulled_out));
      EXPECT_TRUE(is_finite(solver->read()));
      const double gap = wound.gap_of(solver->read());
      if (share > 1.0) {
        EXPECT_GT(gap, 5.5e-3);
      } else {
        EXPECT_LT(gap, 5.5e-3);
      }
    }
  }
}

/// Of the whole: the body's energy, and that of the stretched thread.
TEST(Stitch, AddsNoEnergy) {
  for (const double young : {1e7, 3e9}) {
    for (const double dt : {1e-4, 5e-4, 1e-3}) {
      if (sanitized && (young < 1e9 || dt != 1e-3)) continue;  // a minute in all; memory is used alike in all
      Wound wound({0.02, 0.02, 0.01}, 0.006);
      wound.scene.fix("left/x0").fix("right/x1");
      wound.stitch(0.01, {.young = young, .friction = 0.1});
      wound.tighten(0, 0.01);
      const auto solver = make_solver("reference", wound.model, wound.scene);
      ASSERT_GT(solver->stable_step(), 1.1e-3);
      static_cast<void>(solver->run_to_rest(2000, 1e-3, {.rate = 50.0}));
      wound.tie_all();
      static_cast<void>(solver->run_to_rest(2000, 1e-3, {.rate = 50.0}));
      State kicked = solver->read();
      std::mt19937 bits(5);
      for (Vec3& v : kicked.velocity) v = 0.02 * random_vector(bits, 3);
      solver->start(kicked, dt);
      const double stretch = axial_stiffness({.young = young});
      const auto energy = [&] {
        const ThreadState& thread = solver->thread_state("stitch 1");
        double sum = solver->energy().total();
        for (std::size_t k = 1; k + 1 < thread.tension.size(); ++k) {
          sum += 0.5 * thread.rest_length[k] / stretch * std::pow(thread.tension[k], 2);
        }
        return sum + 0.5 * thread.knots[0].rest_length / stretch * std::pow(thread.knots[0].tension, 2);
      };
      double early = 0.0, late = 0.0;
      for (double t = 0.0; t < 1.0; t += 10 * dt) {
        ASSERT_TRUE(solver->step(10, dt).ok());
        (t < 0.1 ? early : late) = std::max(t < 0.1 ? early : late, energy());
      }
      EXPECT_GT(early, 1e-6);
      EXPECT_LT(late, (1.0 + 1e-4) * early) << young << ' ' << dt;
    }
  }
}

/// Undamped, with taut stitches that share cells and are as stiff as they like.
TEST(Stitch, LeavesTheStableStepOfTheTissue) {
  struct Case {
    double young, friction, apart;
    int steps;
  };
  for (const Case& of : {Case{1e6, 0.1, 3.5e-3, 4000}, {3e9, 0.1, 3.5e-3, 20000}, {1e15, 1.0, 5e-4, 8000}}) {
    Wound wound({0.015, 0.015, 0.01}, 0.006);
    wound.scene.fix("left/x0").fix("right/x1");
    for (const int k : {-1, 0, 1}) wound.stitch(0.0075 + k * of.apart, {.young = of.young, .friction = of.friction});
    for (const int k : {0, 1, 2}) wound.tighten(k, 0.002);
    const auto solver = make_solver("reference", wound.model, wound.scene);
    const double dt = 0.99 * solver->stable_step();
    const auto largest_of = [&](int steps) {
      double largest = 0.0;
      for (int k = 0; k < steps && largest < 1.0; k += 10) {
        EXPECT_TRUE(solver->step(10, dt).ok());
        largest = std::max(largest, solver->energy().total());
      }
      return largest;
    };
    largest_of(200);
    wound.tie_all();
    largest_of(200);
    const double early = largest_of(2000), late = largest_of(sanitized ? 1000 : of.steps - 2000);
    EXPECT_GT(early, 1e-7);
    EXPECT_LT(late, 1.02 * early) << of.young << ' ' << of.friction;
  }
}

TEST(Stitch, RefusesPlacesItCannotPass) {
  Wound wound({0.02, 0.02, 0.01}, 0.006);
  const auto sew = [&](const VecList& places, const Thread& thread = {}) {
    return [=, &wound] { wound.scene.sew("s", thread, places); };
  };
  const Vec3 left(-0.01, 0.01, 0.005), right(0.01, 0.01, 0.005);
  EXPECT_TRUE(refuses(sew({left}), "thread \"s\": expected 2 to 100 places to sew through, got 1"));
  EXPECT_TRUE(refuses(sew({left, left}), "expected places that differ"));
  EXPECT_TRUE(refuses(sew({left, Vec3(1, 1, 1)}), "thread \"s\": the places to sew through: "));
  EXPECT_TRUE(refuses(sew({left, Vec3(0, std::nan(""), 0)}), "not within 1 cells"));
  EXPECT_TRUE(refuses(sew({left, right}, {.length = 0.01}), "expected a thread as long as its way"));
  const ThreadHandle thread = wound.scene.sew("s", {}, VecList{left, right});
  EXPECT_TRUE(refuses([&] { thread.tie(0, 2, 3); }, "thread \"s\": expected passages from 0 to 1, got 2"));
  EXPECT_TRUE(refuses([&] { thread.tie(1, 1, 3); }, "expected two passages"));
  EXPECT_TRUE(refuses([&] { thread.tie(0, 1, 0); }, "expected 1 throw of a knot or more"));
  EXPECT_TRUE(refuses([&] { thread.hold(0, Vec3::Zero()); }, "it is sewn"));
  const ThreadControl before = thread.thread().control;
  EXPECT_TRUE(refuses([&] { thread.set({.knots = {{0, 2, 3}}}); }, "thread \"s\": expected passages from 0 to 1"));
  EXPECT_EQ(thread.thread().control, before);
}

}  // namespace
}  // namespace phymul::test
