// SPDX-License-Identifier: MIT
//
// Absurd but finite inputs to what lives on the host: a step is good and all its numbers are finite, or it fails, says
// so and leaves the state as it was. What StepReport says of a body that is strained farther than its law is meant for.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <cmath>
#include <functional>

#include "interaction/tool_frame.h"
#include "support/bodies.h"
#include "support/message_of.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double absurd = 1e300;
const Vec3 far_away(0.5 * absurd, absurd, -absurd);

class NotFiniteOn : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Cpu, NotFiniteOn, testing::Values("reference", "cpu"),
                         [](const auto& backend) { return std::string(backend.param); });

bool all_finite(const VecList& list) {
  return std::ranges::all_of(list, [](const Vec3& v) { return v.allFinite(); });
}
bool all_finite(const std::vector<double>& list) {
  return std::ranges::all_of(list, [](double x) { return std::isfinite(x); });
}

/// What a user can read of a solver.
void expect_finite(const Solver& solver, const Scene& scene) {
  const State state = solver.read();
  EXPECT_TRUE(is_finite(state));
  for (const ThreadState& thread : state.threads) {
    EXPECT_TRUE(all_finite(thread.position) && all_finite(thread.velocity) && all_finite(thread.rest_length) &&
                all_finite(thread.tension) && thread.force[0].allFinite() && thread.force[1].allFinite())
        << thread.name;
  }
  for (const ToolState& tool : state.tools) {
    EXPECT_TRUE(is_finite(tool.pose) && all_finite(tool.held_at)) << tool.name;
    const ToolForce& force = solver.tool_force(tool.name);
    EXPECT_TRUE(force.force.allFinite() && force.torque.allFinite()) << tool.name;
    EXPECT_TRUE(force.mean_force.allFinite() && force.mean_torque.allFinite()) << tool.name;
  }
  for (const FluidState& fluid : state.fluids) {
    EXPECT_TRUE(std::isfinite(fluid.volume + fluid.pressure + fluid.pressure_before)) << fluid.name;
  }
  for (const SceneJoint& joint : scene.joints()) {
    for (const SpringReport& spring : solver.joint_report(joint.name).springs) {
      EXPECT_TRUE(spring.force.allFinite() && std::isfinite(spring.length)) << joint.name;
    }
  }
}

struct Input {
  const char* name;
  std::function<void(Scene&)> begin;  ///< before there is a solver
  std::function<void(Scene&)> then;   ///< after some steps
  bool fails = true;                  ///< some step must fail
};

const Thread free_thread{.length = 0.05, .segment = 5e-3};

/// A ring of a thread through the block.
void sew(Scene& scene) {
  scene.sew("stitch", {.length = 0.2}, std::vector<Anchor>{at_particle(31), at_particle(33), at_particle(62)});
}

std::vector<Input> inputs() {
  const auto free = [](Scene& scene) { scene.add_thread("thread", free_thread, {0, 0, 0.1}, {1, 0, 0}); };
  const auto tool = [](const Tool& with) { return [with](Scene& scene) { scene.add_tool("tool", with); }; };
  const auto ball = tool({.shape = Sphere{5e-3}, .pose = {.position = {0.02, 0.02, 0.044}}});
  const auto moved = [](const ToolPose& pose) { return [pose](Scene& scene) { scene.tool("tool").move_to(pose); }; };
  const ToolPose gone{.position = far_away}, flies{.position = {0, 0, 1}, .velocity = far_away},
      spins{.position = {0.02, 0.02, 0.046}, .spin = far_away};
  std::vector<Input> all{
      {"a pulled thread", free, [](Scene& s) { s.thread("thread").pull(ThreadTip::last, far_away); }},
      {"a held node", free, [](Scene& s) { s.thread("thread").hold(3, far_away); }},
      {"a joined tip", free, [](Scene& s) { s.thread("thread").join(ThreadTip::first, at_world(far_away)); }},
      {"a heavy thread",
       [free](Scene& s) {
         free(s);
         s.fix(every_particle(s.model()));
       },
       [](Scene& s) { s.gravity(far_away); }},
      {"a thread at a tool that flies",
       [free, ball](Scene& s) {
         free(s);
         ball(s);
         s.thread("thread").join(ThreadTip::last, at_tool("tool"));
       },
       moved(flies)},
      {"a pulled stitch", sew, [](Scene& s) { s.thread("stitch").pull(ThreadTip::last, far_away); }},
      {"a pulled stitch of a held body",
       [](Scene& s) {
         sew(s);
         s.fix(every_particle(s.model()));
       },
       [](Scene& s) { s.thread("stitch").pull(ThreadTip::last, far_away); }, false},
      {"a stitch that is joined", sew, [](Scene& s) { s.thread("stitch").join(ThreadTip::last, at_world(far_away)); }},
      {"a clip", sew,
       [](Scene& s) {
         s.add_clip("clip", {.gap = absurd, .holding = absurd, .opening = 0.1}, at_particle(0), at_particle(124));
       },
       false},
      {"a load", [](Scene&) {},
       [](Scene& s) {
         s.add({.type = LoadType::force, .particles = {124}, .events = {{0.0, absurd}}, .direction = {1, 0, 0}});
       }},
      {"a joint to a tool",
       [ball](Scene& s) {
         ball(s);
         s.fix(every_particle(s.model()));
         s.add_joint("joint", Joint{.springs = {{at_particle(0), at_tool("tool")}}, .stiffness = 1.0, .damping = 1e-3});
       },
       moved(gone)},
      {"a fluid",
       [](Scene& s) {
         s.constrain_volume();
         s.set_fluid("volume 1", {.law = FluidLaw::gas});
       },
       [](Scene& s) { s.set_volume("volume 1", absurd); }},
      {"a volume", [](Scene& s) { s.constrain_volume(); }, [](Scene& s) { s.set_volume("volume 1", absurd); }},
      {"a fluid in a held body",
       [](Scene& s) {
         s.constrain_volume();
         s.set_fluid("volume 1", {.law = FluidLaw::gas});
         s.fix(every_particle(s.model()));
       },
       [](Scene& s) { s.set_volume("volume 1", absurd); }, false},
      {"a tight fluid in a held body",
       [](Scene& s) {
         s.constrain_volume();
         s.set_fluid("volume 1", {.law = FluidLaw::gas, .exponent = 100.0});
         s.fix(every_particle(s.model()));
       },
       [](Scene& s) { s.set_volume("volume 1", absurd); }},
      {"a tool that holds",
       [ball](Scene& s) {
         ball(s);
         s.tool("tool").grasp(5e-3);
       },
       moved(gone)},
  };
  const std::vector<std::pair<const char*, Tool>> tools{
      {"a ball", {.shape = Sphere{5e-3}, .pose = {.position = {0.02, 0.02, 0.044}}}},
      {"a ball on the surface",
       {.shape = Sphere{5e-3}, .pose = {.position = {0.02, 0.02, 0.044}}, .contact = ToolContact::surface}},
      {"a floor", {.shape = HalfSpace{}, .pose = {.position = {0.02, 0.02, -0.001}}}},
      {"a box", {.shape = Box{{5e-3, 5e-3, 5e-3}}, .pose = {.position = {0.02, 0.02, 0.044}}, .friction = 0.3}},
      {"a needle",
       {.shape = Needle{.length = 0.05, .radius = 0.5e-3},
        .pose = {.position = {0.021, 0.022, 0.03}, .orientation = {0, 1, 0, 0}}}},
      {"a blade",
       {.shape = Blade{.width = 0.02}, .pose = {.position = {0.021, 0.022, 0.04}, .orientation = {0, 1, 0, 0}}}}};
  for (const auto& [name, with] : tools) {
    all.push_back({name, tool(with), moved(gone), false});
    all.push_back({name, tool(with), [gone](Scene& s) { s.tool("tool").teleport(gone); }, false});
    all.push_back({name, tool(with), moved(flies), false});
    all.push_back({name, tool(with), moved(spins), true});
  }
  return all;
}

TEST_P(NotFiniteOn, AStepThatIsNotFiniteFailsAndIsUndone) {
  const Model model = with_material(make_tetrahedral_block(Vec3::Constant(0.04), 4, 4, 4, 0.2, 7), {5e3, 0.4, 1000.0});
  for (const Input& input : inputs()) {
    SCOPED_TRACE(input.name);
    Scene scene(model);
    scene.fix("z0");
    input.begin(scene);
    const auto solver = make_solver(GetParam(), model, scene);
    const double dt = 0.3 * solver->stable_step();
    ASSERT_TRUE(solver->step(5, dt).ok());
    input.then(scene);
    ASSERT_TRUE(solver->step(0, dt).ok());  // sees the scene
    bool failed = false;
    SCOPED_TRACE(input.name);
    for (int k = 0; k < 50 && !failed; ++k) {
      State before = solver->read();
      const StepReport report = solver->step(k % 3 + 1, dt);
      failed = !report.ok();
      if (failed) {
        EXPECT_TRUE(report.status == StepStatus::not_finite || report.status == StepStatus::volume_lost ||
                    report.status == StepStatus::carried_away)
            << report.message();
        const State after = solver->read();
        for (std::size_t t = 0; t < after.tools.size() && scene.tools()[t].places > 0; ++t) {
          before.tools[t].pose = after.tools[t].pose;  // it is there at once
          before.tools[t].placed = after.tools[t].placed;
        }
        EXPECT_TRUE(report.steps > 0 || after == before);
        EXPECT_EQ(report.message().find("-1"), std::string::npos) << report.message();
      }
      expect_finite(*solver, scene);
    }
    EXPECT_TRUE(failed || !input.fails);
  }
}

/// What tools were asked for is still ahead then.
TEST_P(NotFiniteOn, AStepThatFailsHasNotGraspedNorTakenANeedle) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  Scene scene(model);
  const ToolPose inside{.position = {0.011, 0.012, 0.01}};
  const ToolHandle needle = scene.fix("z0").add_tool("needle", {.shape = Needle{.length = 0.03}, .pose = inside});
  const ToolHandle jaw = scene.add_tool("jaw", {.shape = Sphere{5e-3}, .pose = {.position = {0.01, 0.01, 0.0255}}});
  const ToolHandle far = scene.add_tool("far", {.shape = Sphere{1e-3}, .pose = {.position = {1e308, 0, 0}}});
  const auto solver = make_solver(GetParam(), model, scene);
  const double dt = 0.3 * solver->stable_step();
  needle.release();
  ASSERT_TRUE(solver->step(2, dt).ok());
  const State before = solver->read();
  ASSERT_TRUE(before.tools[0].needle.free && !before.tools[0].needle.hole.empty());
  jaw.grasp(1e-3);
  needle.move_to(inside);
  far.move_to({.position = {-1e308, 0, 0}});
  for (int call = 0; call < 2; ++call) {
    ASSERT_FALSE(solver->step(2, dt).ok());
    EXPECT_EQ(solver->read(), before);
    EXPECT_TRUE(solver->has_grasp_ahead("jaw"));
  }
  far.teleport({});
  ASSERT_TRUE(solver->step(1, dt).ok());
  EXPECT_FALSE(solver->has_grasp_ahead("jaw") || solver->read().tools[0].needle.free);
  EXPECT_EQ(solver->held("jaw"), 1);
}

class StrainReport : public testing::TestWithParam<const char*> {
 protected:
  /// Of one short step from a uniform strain.
  StepReport report_at(const Mat3& F) {
    State state = rest_state(model_);
    for (Vec3& x : state.position) x = F * x;
    solver_->reset(state);
    return solver_->step(1, 1e-6 * solver_->stable_step());
  }

  Model model_ = with_material(make_tetrahedral_block({0.03, 0.03, 0.03}, 3, 3, 3, 0.2, 1));
  Scene scene_{model_};
  std::unique_ptr<Solver> solver_ = make_solver(GetParam(), model_, scene_);
};
INSTANTIATE_TEST_SUITE_P(Backends, StrainReport, testing::Values("reference", "cpu"));

TEST_P(StrainReport, CountsWhatIsBeyondTheLawAndWhatIsInverted) {
  const Index all = model_.particle_count();
  const auto expect = [&](const Vec3& stretch, Index beyond, Index inverted) {
    const StepReport report = report_at(stretch.asDiagonal());
    EXPECT_EQ(report.beyond_law, beyond) << stretch.transpose();
    EXPECT_EQ(report.inverted, inverted) << stretch.transpose();
    EXPECT_EQ(report.first_beyond, beyond > 0 ? 0 : -1) << stretch.transpose();
    return report;
  };
  expect({1, 1, 1}, 0, 0);
  expect({1.65, 1.65, 0.63}, 0, 0);
  expect({0.63, 0.63, 0.63}, 0, 0);
  EXPECT_TRUE(says(expect({1, 1, 0.2}, all, 0).message(), "strained beyond the law, first around particle 0"));
  expect({3, 1, 1}, all, 0);
  EXPECT_TRUE(says(expect({1, 1, -1}, all, all).message(), "inverted around 64"));
}

TEST_P(StrainReport, KeepsWhereAndWhenItBegan) {
  State state = rest_state(model_);
  state.position.back() += Vec3(0.05, 0.05, 0.05);
  solver_->reset(state);
  const double dt = 1e-3 * solver_->stable_step();
  const StepReport began = solver_->step(1, dt), later = solver_->step(5, dt);
  EXPECT_GT(began.beyond_law, 0);
  EXPECT_EQ(began.beyond_since, dt);
  EXPECT_EQ(later.first_beyond, began.first_beyond);
  EXPECT_EQ(later.beyond_since, dt);
  solver_->reset();
  EXPECT_EQ(solver_->step(1, dt).first_beyond, -1);
}

/// A bar is drawn out to two and a half times its length within 0.2 s.
Simulation drawn(const char* backend, const SolverOptions& options = {}) {
  const Model bar = with_material(make_tetrahedral_block({0.06, 0.02, 0.02}, 18, 6, 6, 0.1, 7), {5e3, 0.4, 1000});
  Simulation sim(with_spare_particles(bar, 300), {.backend = backend, .damping = {.rate = 50}, .solver = options});
  sim.scene().fix("x0").add({.type = LoadType::translation,
                             .particles = sim.model().group("x1"),
                             .events = {{0.0, 0.0}, {0.2, 0.09}},
                             .direction = {1, 0, 0}});
  return sim;
}

TEST_P(StrainReport, IsKnownAtRestAndOutlivesACut) {
  Simulation sim = drawn(GetParam());
  ASSERT_TRUE(sim.advance(0.21).ok());
  const StepReport at_rest = sim.run_to_rest().report, next = sim.advance(0.01);
  EXPECT_GT(next.beyond_law, 100);
  EXPECT_EQ(at_rest.beyond_law, next.beyond_law);
  EXPECT_NEAR(at_rest.growth, next.growth, 1e-3 * next.growth);
  CutSurface half = cut_plane({0.03, 0.0, 0.0}, {1.0, 0.0, 0.0});
  half.front = [](const Vec3& x) { return x.z() - 0.005; };
  ASSERT_TRUE(sim.cut(half));
  const StepReport after = sim.advance(0.01);
  EXPECT_EQ(after.first_beyond, next.first_beyond);
  EXPECT_EQ(after.beyond_since, next.beyond_since);
}

TEST(StrainReportOfSleep, IsThatOfABodyAwake) {
  Simulation awake = drawn("cpu"), asleep = drawn("cpu", {.sleep_tolerance = 1e-4});
  const Snapshot start = asleep.snapshot();
  StepReport reports[2];
  for (int k = 0; k < 8; ++k) {
    reports[0] = awake.advance(0.25);
    reports[1] = asleep.advance(0.25);
  }
  EXPECT_EQ(reports[1].max_speed, 0.0);
  EXPECT_GT(reports[0].beyond_law, 100);
  EXPECT_EQ(reports[1].beyond_law, reports[0].beyond_law);
  EXPECT_NEAR(reports[1].growth, reports[0].growth, 1e-3 * reports[0].growth);
  asleep.restore(start);
  EXPECT_EQ(asleep.advance(0.0).beyond_law, 0);
}

/// Undamped under ten times its weight, at half of the step limit, a beam that hangs from one end is torn out of its
/// law at the clamp. It is reported from then on, and is a failure before it has gone farther than a few metres.
TEST_P(StrainReport, ABodyThatIsCarriedAwayIsAFailure) {
  const Model beam = with_material(make_tetrahedral_block({0.2, 0.05, 0.05}, 8, 2, 2, 0.2, 1),
                                   {.young = 10e3, .poisson = 0.45, .density = 1000});
  Scene hung = Scene(beam).fix("x0").gravity({0, 0, -98.1});
  const auto solver = make_solver(GetParam(), beam, hung);
  StepReport report;
  for (int k = 0; k < 200 && report.ok(); ++k) report = solver->step(20, 0.5 * solver->stable_step());
  EXPECT_EQ(report.status, StepStatus::carried_away);
  EXPECT_GT(report.first_beyond, -1);
  EXPECT_LT(report.beyond_since, 0.9 * report.time);
  EXPECT_LT(largest_distance(solver->read().position, beam.rest), 5.0);
  EXPECT_TRUE(says(report.message(), "carried_away: particle"));
  const StepReport still = solver->step(1, 1e-9 * report.dt);  // passes time alone
  EXPECT_EQ(still.status, StepStatus::carried_away);
  EXPECT_EQ(still.beyond_law, report.beyond_law);
}

/// Nothing holds it: it may fly as far as it likes.
TEST_P(StrainReport, AFreeBodyMayGoAnywhere) {
  State state = rest_state(model_);
  for (Vec3& x : state.position) x += Vec3(100, 0, 0);
  state.position.back() += Vec3(0.05, 0.05, 0.05);
  solver_->reset(state);
  const StepReport report = solver_->step(1, 1e-3 * solver_->stable_step());
  EXPECT_GT(report.beyond_law, 0);
  EXPECT_TRUE(report.ok()) << report.message();
}

}  // namespace
}  // namespace phymul::test
