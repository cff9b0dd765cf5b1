// SPDX-License-Identifier: MIT
//
// Needles that are arcs: through both edges of a wound, let go and taken again, with a thread behind them.
#include <phymul/phymul.h>

#include <algorithm>
#include <numeric>

#include "support/message_of.h"
#include "support/needle_insertion.h"
#include "support/run_scenes.h"
#include "support/sutured_wound.h"

namespace phymul::test {
namespace {

constexpr double degree = std::numbers::pi / 180;

/// A wound that is sewn degree by degree, by anything that steps.
struct Sewing {
  ArcSuture wound;
  ThreadHandle thread = wound.scene.swage("suture", {.length = 0.12, .friction = 0.1}, "needle");
  std::unique_ptr<Solver> solver;
  double dt = 0.0;
  double angle = -0.1;        // rad
  std::vector<double> force;  // N, per degree
  bool folded = false;
  double rests = HUGE_VAL;  // N on the needle, before it was taken again

  explicit Sewing(const std::string& backend = "cpu", int threads = 1, double gap = 0.006) : wound(0.002, gap) {
    SolverOptions options = damped(40.0);
    options.threads = threads;
    solver = make_solver(backend, wound.model, wound.scene, {}, options);
    dt = 0.5 * solver->stable_step();
  }
  const NeedleState needle() const { return solver->read().tools.at(0).needle; }
  const ThreadState& sewn() const { return solver->thread_state(thread); }

  template <class Step>
  void turn(int degrees, const Step& step) {
    for (int k = 0; k < degrees; ++k) {
      const ToolPose pose = ArcSuture::pose(angle += degree);
      wound.scene.tool("needle").move_to(pose);
      ASSERT_TRUE(is_ok(step(static_cast<int>(0.003 / dt))));
      force.push_back(ArcSuture::resistance(solver->tool_force("needle"), pose));
      folded = folded || first_folded_cell(wound.model, solver->read().position) >= 0;
    }
  }
  void turn(int degrees) {
    turn(degrees, [this](int steps) { return solver->step(steps, dt); });
  }
  /// Lets the needle go, and takes it where it then is, back onto the course.
  template <class Step>
  void regrasp(const Step& step) {
    wound.scene.tool("needle").release();
    ASSERT_TRUE(is_ok(step(static_cast<int>(0.1 / dt))));
    EXPECT_TRUE(needle().free);
    rests = solver->tool_force("needle").force.norm();
    wound.scene.tool("needle").move_to(ArcSuture::pose(angle));
    ASSERT_TRUE(is_ok(step(static_cast<int>(0.05 / dt))));
    EXPECT_FALSE(needle().free);
  }
  void regrasp() {
    regrasp([this](int steps) { return solver->step(steps, dt); });
  }
};

int ends_in(const NeedleState& needle) {
  return static_cast<int>(std::ranges::count(needle.hole, true, &NeedleNode::out));
}

TEST(ArcNeedle, GoesThroughBothEdgesWithAPeakInAndOutOfEach) {
  Sewing run;
  const double puncture = half_circle().puncture, leaving = half_circle().leaving;
  const auto peak = [&](int degrees) {
    run.turn(degrees);
    return *std::max_element(run.force.end() - degrees, run.force.end());
  };
  const auto least = [&](int degrees) { return *std::min_element(run.force.end() - degrees, run.force.end()); };
  EXPECT_NEAR(peak(30), puncture, 0.1 * puncture);
  run.turn(18);
  EXPECT_LT(run.force.back(), 0.6 * puncture);  // it cuts and rubs
  EXPECT_EQ(ends_in(run.needle()), 0);
  const double out = peak(25), rubs = run.force.back();
  EXPECT_NEAR(out - rubs, leaving, 0.15 * leaving);
  EXPECT_TRUE(run.needle().through);
  EXPECT_EQ(ends_in(run.needle()), 1);
  EXPECT_LT(rubs, 0.25 * puncture);  // in the gap
  EXPECT_NEAR(peak(35) - rubs, puncture, 0.25 * puncture);
  EXPECT_LT(least(5), 0.6 * puncture);
  EXPECT_TRUE(run.needle().punctured);
  EXPECT_EQ(ends_in(run.needle()), 1);
  run.turn(22);
  const double last = peak(25);
  EXPECT_NEAR(last - run.force.back(), leaving, 0.25 * leaving);
  EXPECT_TRUE(run.needle().through);
  EXPECT_EQ(ends_in(run.needle()), 2);
  EXPECT_FALSE(run.folded);
}

/// Nodes of each hole are means of particles of its own edge, also where the other one is nearer than the spread.
void expect_holes_in_both(const Sewing& run) {
  const NeedleState needle = run.needle();
  EXPECT_TRUE(needle.through);
  ASSERT_EQ(ends_in(needle), 2);
  bool right = false;
  for (const NeedleNode& node : needle.hole) {
    const auto of_right = [&](Index i) { return i >= run.wound.model.particle_count() / 2; };
    EXPECT_EQ(std::ranges::count_if(node.particles, of_right), right ? std::ssize(node.particles) : 0);
    right = right || node.out;
  }
}

TEST(ArcNeedle, InANarrowWoundEachHoleIsInItsOwnEdge) {
  Sewing run("cpu", 1, 0.001);
  run.turn(150);
  expect_holes_in_both(run);
  EXPECT_FALSE(run.folded);
}

/// Its whole way is known from where it goes through the surface.
TEST(ArcNeedle, PutIntoTheTissueItIsInBothEdges) {
  Sewing run;
  run.wound.scene.tool("needle").teleport(ArcSuture::pose(2.4));
  ASSERT_TRUE(is_ok(run.solver->step(4, run.dt)));
  expect_holes_in_both(run);
}

TEST(ArcNeedle, IsTakenElsewhereThriceAndItsThreadFollows) {
  Sewing run;
  for (const int degrees : {70, 80, 40}) {  // in the gap, and on the far side
    run.turn(degrees);
    run.regrasp();
    EXPECT_LT(run.rests, 1e-3 * half_circle().puncture * 10);
  }
  run.turn(140);
  EXPECT_FALSE(run.folded);
  EXPECT_TRUE(run.needle().hole.empty());  // the tail is out
  const ThreadState& thread = run.sewn();
  ASSERT_GE(thread.passages.size(), 6u);
  EXPECT_EQ(thread.sewn.size(), thread.passages.size());
  EXPECT_NEAR(std::accumulate(thread.rest_length.begin(), thread.rest_length.end(), 0.0), 0.12, 1e-12);
  for (std::size_t k = 1; k + 1 < thread.position.size(); ++k) {  // from left to right
    EXPECT_LT(thread.position[k].x(), thread.position[k + 1].x());
  }
  EXPECT_NEAR(thread.position[1].x(), -0.007, 1.5e-3);
  ToolPose away = ArcSuture::pose(run.angle);
  const Vec3 tail = shaft_place(half_circle(), half_circle().length);
  EXPECT_LT((thread.position.back() - (away.position + away.orientation * tail)).norm(), 1e-9);
  // Drawn on, the thread runs through the tissue; then the wound is closed.
  away.position += Vec3(0.02, 0, 0.02);
  run.wound.scene.tool("needle").move_to(away);
  const double tail_before = thread.rest_length.front();
  ASSERT_TRUE(is_ok(run.solver->step(static_cast<int>(0.3 / run.dt), run.dt)));
  EXPECT_LT(run.sewn().rest_length.front(), tail_before - 0.01);
  EXPECT_EQ(run.sewn().torn, 0);
  const auto gap = [&] {  // m, between the upper rims
    const State now = run.solver->read();
    double sum = 0.0, count = 0.0;
    for (const auto& [name, sign] : {std::pair{"right/x0", 1.0}, {"left/x1", -1.0}}) {
      for (const Index i : run.wound.model.group(name)) {
        if (run.wound.model.rest[i].z() < slab_top - 1e-6) continue;
        sum += sign * now.position[i].x();
        count += 0.5;
      }
    }
    return sum / count;
  };
  run.thread.pull(ThreadTip::first, {0.03, 0, 0});
  run.thread.pull(ThreadTip::last, {-0.03, 0, 0});
  run.wound.scene.remove_tool("needle");
  ASSERT_TRUE(is_ok(run.solver->step(static_cast<int>(0.3 / run.dt), run.dt)));
  const double closed = gap();
  EXPECT_LT(closed, 5e-3);
  run.thread.tie(0, static_cast<Index>(run.sewn().sewn.size()) - 1, 4);
  for (const ThreadTip tip : {ThreadTip::first, ThreadTip::last}) run.thread.pull(tip, Vec3::Zero());
  ASSERT_TRUE(is_ok(run.solver->step(static_cast<int>(0.2 / run.dt), run.dt)));
  EXPECT_GT(run.sewn().knots.at(0).tension, 1e-3);
  EXPECT_NEAR(gap(), closed, 5e-4);
}

/// A knot of a passage that is still to come waits for it. A thread that was sewn and then joined to the needle's tail
/// is tied by the rows that the needle makes, also after it was cut off, and in a copy of the scene.
TEST(ArcNeedle, KnotsOfPassagesToComeWaitForThem) {
  Sewing run;
  run.wound.scene.remove_thread("suture");
  const Needle needle = half_circle();
  run.thread = run.wound.scene.sew("suture", {.length = 0.12, .friction = 0.1},
                                   VecList{{-0.014, 0.004, 0.008}, {-0.012, 0.006, 0.008}});
  run.thread.pull(ThreadTip::first, Vec3::Zero());
  run.thread.join(ThreadTip::last, at_tool("needle", shaft_place(needle, needle.length)));
  run.thread.tie(1, 2, 3);
  run.turn(10);
  EXPECT_TRUE(run.sewn().knots.empty());
  for (int k = 0; k < 300 && run.sewn().sewn.empty(); ++k) run.turn(1);
  ASSERT_FALSE(run.sewn().sewn.empty());
  ASSERT_EQ(run.sewn().knots.size(), 1u);
  EXPECT_FALSE(run.sewn().knots[0].broken);
  run.thread.pull(ThreadTip::last, Vec3::Zero());
  run.thread.tie(0, 2, 3);
  EXPECT_TRUE(refuses([&] { run.thread.tie(0, 100, 3); }, "expected passages from 0 to 99, got 100"));
  Scene other(run.wound.model);
  other.bring_back(run.wound.scene.parts());
  EXPECT_EQ(other.thread("suture").thread().control, run.thread.thread().control);
  const ThreadHandle again = other.remove_thread("suture").sew("suture", run.thread.thread().thread,
                                                               run.thread.thread().passages);  // not joined yet
  other.bring_back(run.wound.scene.parts());
  EXPECT_EQ(again.thread().control, run.thread.thread().control);
}

/// A whole suture, from states in its middle too.
TEST(ArcNeedle, AReplayOfASutureIsTheRunBitForBit) {
  Sewing run;
  Recorder recorder(*run.solver, run.wound.scene);
  const auto step = [&](int steps) { return recorder.step(steps, run.dt); };
  run.turn(60, step);
  run.regrasp(step);
  run.turn(150, step);
  run.regrasp(step);
  const std::string middle = path_for("suture.state");
  save_state(*run.solver, middle);
  const State at_middle = run.solver->read();
  recorder.checkpoint();
  const double angle = run.angle;
  run.turn(100, step);
  run.thread.pull(ThreadTip::last, {-0.02, 0, 0});
  step(100);
  recorder.checkpoint();
  const State end = run.solver->read();
  ASSERT_GE(end.threads.at(0).sewn.size(), 4u);
  {
    const std::string file = path_for("suture.rec");
    save_recording(recorder.recording(), file);
    Scene again(run.wound.model);
    const auto solver = make_solver("cpu", run.wound.model, again, {}, run.solver->options());
    Replay(read_recording(file), *solver, again).run();
    EXPECT_TRUE(same_bits(solver->read(), end));
    EXPECT_EQ(solver->read().threads, end.threads);
    EXPECT_EQ(solver->read().tools, end.tools);
  }
  Sewing other;
  load_state(*other.solver, middle);
  EXPECT_EQ(other.solver->read(), at_middle);
  other.angle = angle;
  other.turn(100);
  other.thread.pull(ThreadTip::last, {-0.02, 0, 0});
  ASSERT_TRUE(is_ok(other.solver->step(100, other.dt)));
  EXPECT_EQ(other.solver->read(), end);
}

TEST(ArcNeedle, AnyNumberOfThreadsMovesTheSameBits) {
  std::vector<State> ends;
  for (const int threads : {1, 2, 3}) {
    Sewing run("cpu", threads);
    run.turn(70);
    run.regrasp();
    run.turn(20);
    ends.push_back(run.solver->read());
  }
  EXPECT_TRUE(ends[0] == ends[1] && ends[0] == ends[2]);
}

TEST(ArcNeedle, OnCpuIsThatOfTheReference) {
  Sewing fast, exact("reference");
  for (Sewing* run : {&fast, &exact}) {
    run->dt = 1e-4;
    run->turn(60);
  }
  double apart = 0.0;
  for (std::size_t k = 0; k < fast.force.size(); ++k) {
    apart = std::max(apart, std::abs(fast.force[k] - exact.force[k]));
  }
  EXPECT_LT(apart, 0.02 * half_circle().puncture);
  EXPECT_EQ(fast.needle().hole.size(), exact.needle().hole.size());
}

TEST(ArcNeedle, OfAHugeRadiusIsAStraightOne) {
  std::vector<std::vector<double>> both;
  for (const double radius : {0.0, 1e4}) {
    Needle needle = thin_needle();
    needle.arc_radius = radius;
    Insertion run("cpu", 6, 0.4, needle);
    both.push_back(run.go_in_and_out());
  }
  EXPECT_GT(*std::ranges::max_element(both[0]), 0.25);
  EXPECT_LE(apart(both[0], both[1]), 1e-3);
}

/// Of the whole step: what a needle that nobody holds gives to the tissue has no sum.
TEST(ArcNeedle, LetGoItGivesTheTissueNoMomentum) {
  Sewing run;
  run.turn(75);
  EXPECT_GT(run.solver->tool_force("needle").force.norm(), 5e-3);
  run.wound.scene.tool("needle").release();
  ASSERT_TRUE(is_ok(run.solver->step(static_cast<int>(0.2 / run.dt), run.dt)));
  EXPECT_LT(run.solver->tool_force("needle").force.norm(), 1e-4);
  // It goes where the tissue goes.
  State moving = run.solver->read();
  for (Vec3& v : moving.velocity) v = Vec3(0.02, 0.03, -0.01);
  run.wound.scene.clear();
  run.wound.scene.add_tool("needle", {.shape = half_circle(), .friction = 0.3});
  const auto loose = make_solver("cpu", run.wound.model, run.wound.scene);
  moving.threads.clear();
  loose->reset(moving);
  const Vec3 before = loose->tool_pose("needle").position;
  const Momentum start = loose->momentum();
  ASSERT_TRUE(is_ok(loose->step(100, run.dt)));
  const Vec3 went = loose->tool_pose("needle").position - before, goes = 100 * run.dt * Vec3(0.02, 0.03, -0.01);
  EXPECT_LT((went - goes).norm(), 0.3 * goes.norm());
  EXPECT_LT((loose->momentum().linear - start.linear).norm(), 0.02 * start.linear.norm());
}

/// Then nothing is taut where it is taken again.
TEST(ArcNeedle, LetGoItsThreadRunsFreely) {
  Sewing run;
  run.turn(240);
  run.wound.scene.tool("needle").release();
  ASSERT_TRUE(is_ok(run.solver->step(static_cast<int>(0.1 / run.dt), run.dt)));
  ASSERT_GE(run.sewn().passages.size(), 3u);
  const State still = run.solver->read();
  const double before = run.sewn().rest_length.back();
  double longest = 0.0;
  for (const Vec3& kick : {Vec3(0.5, 0, 0), Vec3(-0.5, 0, 0), Vec3(0, 0.5, 0), Vec3(0, 0, 0.5), Vec3(0, 0, -0.5)}) {
    State kicked = still;
    for (std::size_t i = kicked.velocity.size() / 2; i < kicked.velocity.size(); ++i) kicked.velocity[i] += kick;
    run.solver->reset(kicked);
    for (int k = 0; k < 100; ++k) {
      ASSERT_TRUE(is_ok(run.solver->step(1, run.dt)));
      const VecList& at = run.sewn().position;
      EXPECT_EQ(run.sewn().tension.back(), 0.0);
      EXPECT_GE(run.sewn().rest_length.back(), (at.back() - at[at.size() - 2]).norm() - 1e-5);
    }
    longest = std::max(longest, run.sewn().rest_length.back());
    EXPECT_NEAR(std::accumulate(run.sewn().rest_length.begin(), run.sewn().rest_length.end(), 0.0), 0.12, 1e-12);
  }
  EXPECT_GT(longest, before + 1e-4);
}

/// A short needle pushed on: its hole ends at its tail.
TEST(ArcNeedle, AlsoAStraightOneLeavesItsHoleAtTheTail) {
  Needle dart = thin_needle();
  dart.length = 0.03;
  Insertion run("cpu", 5, 0.5, dart);
  run.go(block_side + 0.02, 0.2, 40);  // the tail is 10 mm above the far side
  const State state = run.solver->read();
  ASSERT_FALSE(state.tools.at(0).needle.hole.empty());
  const ToolPose pose = state.tools[0].pose;
  for (const NeedleNode& node : state.tools[0].needle.hole) {
    EXPECT_LE((place_of(node, state) - pose.position).z(), dart.length + 1e-4);
  }
  run.go(block_side + 0.035, 0.2, 20);
  EXPECT_TRUE(run.solver->read().tools[0].needle.hole.empty());
  EXPECT_EQ(run.solver->tool_force("needle").force, Vec3(0, 0, 0));
}

TEST(ArcNeedle, RefusesArcsThatItIsNotMadeFor) {
  const Model model = Insertion::gel(2);
  Scene scene(model);
  const auto add = [&](const Needle& needle) { return [&scene, needle] { scene.add_tool("n", {.shape = needle}); }; };
  EXPECT_TRUE(refuses(add({.length = 0.06, .arc_radius = 0.01}), "expected an arc of at most nine tenths of a circle"));
  EXPECT_TRUE(refuses(add({.length = 0.03, .bending_stiffness = 1e-3, .arc_radius = 0.01}),
                      "expected a bending stiffness of 0 (stiff) for an arc"));
  EXPECT_TRUE(refuses(add({.arc_radius = -1.0}), "radius of an arc (m)"));
  EXPECT_TRUE(refuses(add({.leaving = -1.0}), "force to come out (N)"));
  scene.add_tool("ball", Tool{.shape = Sphere{0.01}});
  EXPECT_TRUE(refuses([&] { scene.swage("s", {}, "ball"); }, "thread \"s\": expected a needle to swage to"));
  EXPECT_TRUE(refuses([&] { scene.swage("s", {}, "no"); }, "\"no\""));
}

}  // namespace
}  // namespace phymul::test
