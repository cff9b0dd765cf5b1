// SPDX-License-Identifier: MIT
//
// SolverOptions::sleep_tolerance on the backend "cpu".
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <chrono>
#include <limits>
#include <map>

#include "support/allocation_count.h"
#include "support/message_of.h"
#include "support/run_scenes.h"

namespace phymul {
namespace {

using namespace test;

struct Body {
  std::shared_ptr<const TopologyTextures> tables;
  Spectrum spectrum;
  explicit Body(const Model& model) : tables(std::make_shared<const TopologyTextures>(build_topology(model, {}))) {
    spectrum = estimate_spectrum(*tables, tables->rest);
  }
  double step() const { return 0.5 * stable_step(spectrum, 1.0); }
  SolverOptions options(std::optional<double> tolerance, int threads = 1, double damping = 150.0) const {
    return {.damping = {.rate = damping}, .sleep_tolerance = tolerance, .spectrum = spectrum, .threads = threads};
  }
};

/// States and reports after every call.
struct Course {
  std::vector<State> states;
  std::vector<StepReport> reports;
  std::vector<double> felt;  // N, on the first tool
};

Course course_of(const SleepingScene& sleeping, const Body& body, const SolverOptions& options) {
  Scene scene(sleeping.model);
  sleeping.set_up(scene);
  const auto solver = make_solver("cpu", body.tables, scene, options);
  Course course;
  for (int call = 0; call < sleeping_calls; ++call) {
    sleeping.drive(scene, call);
    course.reports.push_back(solver->step(steps_a_call, body.step()));
    course.states.push_back(solver->read());
    course.felt.push_back(scene.tools().empty() ? 0.0 : solver->tool_force(scene.tools()[0].name).force.norm());
  }
  return course;
}

/// Made once for each of the bodies that scenes share.
const Body& body_of(const Model& model) {
  static std::map<std::pair<Index, std::size_t>, Body> known;
  return known.try_emplace({model.particle_count(), model.materials.size()}, model).first->second;
}

std::vector<SleepingScene> scenes() {
  return sleeping_scenes(body_of(wide_block()).step());
}

/// Without sleep, on one thread.
const Course& awake_course_of(const SleepingScene& scene) {
  static std::map<std::string, Course> known;
  const auto [found, is_new] = known.try_emplace(scene.name);
  const Body& body = body_of(scene.model);
  if (is_new) found->second = course_of(scene, body, body.options({}));
  return found->second;
}

TEST(Sleep, OfToleranceZeroChangesNoBit) {
  int threads = 0;
  for (const SleepingScene& scene : scenes()) {
    const Body& body = body_of(scene.model);
    const Course& awake = awake_course_of(scene);
    EXPECT_GT(largest_distance(awake.states.back().position, scene.model.rest), 0.0) << scene.name;
    threads = threads % 2 + 1;
    const Course slept = course_of(scene, body, body.options(0.0, threads));
    for (int call = 0; call < sleeping_calls; ++call) {
      ASSERT_TRUE(same_bits(slept.states[call], awake.states[call])) << scene.name << ", call " << call;
      const StepReport &a = slept.reports[call], &b = awake.reports[call];
      EXPECT_TRUE(a.ok()) << scene.name << ": " << a.message();
      EXPECT_EQ(a.residual, b.residual) << scene.name << ", call " << call;
      EXPECT_EQ(a.max_speed, b.max_speed) << scene.name << ", call " << call;
      EXPECT_EQ(a.at_rest, b.at_rest) << scene.name << ", call " << call;
      EXPECT_EQ(slept.felt[call], awake.felt[call]) << scene.name << ", call " << call;
    }
  }
}

/// Whatever wakes a body wakes it in time.
TEST(Sleep, OfASmallToleranceFollowsTheMotion) {
  for (const SleepingScene& scene : scenes()) {
    const Body& body = body_of(scene.model);
    const Course &awake = awake_course_of(scene), slept = course_of(scene, body, body.options(1e-6));
    double largest = 0.0, error = 0.0;
    for (int call = 0; call < sleeping_calls; ++call) {
      largest = std::max(largest, largest_distance(awake.states[call].position, scene.model.rest));
      error = std::max(error, largest_distance(awake.states[call].position, slept.states[call].position));
    }
    EXPECT_GT(largest, 1e-5) << scene.name;
    EXPECT_LT(error, 0.01 * largest) << scene.name;
    // It had nothing to do before.
    EXPECT_EQ(largest_distance(slept.states[woken_at - 2].position, scene.model.rest), 0.0) << scene.name;
  }
}

double particles_at_speed_zero(const State& state) {
  const auto count = std::ranges::count(state.velocity, Vec3(Vec3::Zero()));
  return static_cast<double>(count) / static_cast<double>(state.velocity.size());
}

TEST(Sleep, IsTheSameOnTwoThreads) {
  for (const SleepingScene& scene : scenes()) {
    if (scene.name != "force, two materials" && scene.name != "force, tetrahedra") continue;
    const Body& body = body_of(scene.model);
    const Course one = course_of(scene, body, body.options(1e-4)), two = course_of(scene, body, body.options(1e-4, 2));
    EXPECT_GT(particles_at_speed_zero(one.states.back()), 0.1) << scene.name;
    EXPECT_GT(largest_distance(one.states.back().position, scene.model.rest), 0.0) << scene.name;
    for (int call = 0; call < sleeping_calls; ++call) {
      ASSERT_TRUE(same_bits(one.states[call], two.states[call])) << scene.name << ", call " << call;
    }
  }
}

Model short_beam() {
  return with_material(make_tetrahedral_block({0.06, 0.03, 0.03}, 12, 6, 6, 0.2, 7));
}

/// The bound that the option states: no particle that is held has a net force above m h tolerance / tau^2, nor above a
/// twentieth of its weight.
TEST(Sleep, NeglectsNoForceAboveTheTolerance) {
  const Model model = short_beam();
  const Body& body = body_of(model);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -1.0});
  for (const double tolerance : {1e-5, 1e-4, 1e-3}) {
    const auto solver = make_solver("cpu", body.tables, scene, body.options(tolerance, 1, 60.0));
    State state;
    for (int k = 0; k < 400; ++k) {
      ASSERT_TRUE(solver->step(50, body.step()).ok());
      solver->read(state);
      if (particles_at_speed_zero(state) == 1.0) break;
    }
    ASSERT_EQ(particles_at_speed_zero(state), 1.0) << tolerance;
    const VecList force = forces_at(*body.tables, state.position);
    double neglected = 0.0;
    for (Index i = 0; i < model.particle_count(); ++i) {
      if (model.rest[i].x() < 1e-9) continue;
      neglected = std::max(neglected, (force[i] / body.tables->mass[i] + scene.gravity()).norm());
    }
    const double allowed =
        std::min(tolerance * mean_spacing(model) * body.spectrum.largest, 0.05 * scene.gravity().norm());
    EXPECT_LE(neglected, 1.05 * allowed) << tolerance;
    EXPECT_GT(neglected, 0.01 * allowed) << tolerance;  // else this shows nothing
    EXPECT_NEAR(solver->step(1, body.step()).residual, neglected * body.tables->mass[0], neglected * 1.0);
  }
}

/// A run, saved and restored in the middle, with blocks that are held and blocks that are about to be.
TEST(Sleep, ASnapshotHoldsWhatIsHeld) {
  const Model model = two_materials();
  const Body& body = body_of(model);
  Scene scene(model);
  const double pushed_for = 30 * body.step();
  scene.fix("x0").add(
      pull(model, "x1", {0, 1, -1}, {{0.0, 0.0}, {0.5 * pushed_for, 1e-3}, {pushed_for, 0.0}}, LoadType::force));
  const SolverOptions options = body.options(1e-4, 1, 300.0);
  const auto whole = make_solver("cpu", body.tables, scene, options);
  for (int steps = 0; steps < 900; steps += 30) {
    const Snapshot middle = whole->snapshot();
    const auto resumed = make_solver("cpu", body.tables, scene, options);
    resumed->restore(middle);
    whole->step(30, body.step());
    resumed->step(30, body.step());
    ASSERT_TRUE(same_bits(whole->read(), resumed->read())) << steps;
    EXPECT_EQ(whole->snapshot(), resumed->snapshot()) << steps;
  }
  Snapshot last = whole->snapshot();
  ASSERT_EQ(last.parts.size(), 1u);
  EXPECT_GT(particles_at_speed_zero(last.state), 0.2);
  make_solver("cpu", body.tables, scene, body.options({}))->restore(last);  // which has no use for it
  last.parts[0].bytes.pop_back();
  const State before = whole->read();
  EXPECT_TRUE(refuses([&] { whole->restore(last); }, "part \"sleep\""));
  last.parts[0].name = "holes";
  EXPECT_TRUE(refuses([&] { whole->restore(last); }, "knows nothing"));
  EXPECT_TRUE(same_bits(whole->read(), before));
}

TEST(Sleep, ARecordingReplaysTheSame) {
  const Model model = short_beam();
  const Body& body = body_of(model);
  for (const double tolerance : {0.0, 1e-4}) {
    Scene scene = Scene(model).fix("x0");
    const auto solver = make_solver("cpu", body.tables, scene, body.options(tolerance));
    Recorder recorder(*solver, scene);
    recorder.step(40, body.step());
    scene.add(pull(model, "x1", {0, 0, 1}, {{0.0, 1e-4}}, LoadType::force));
    recorder.step(300, body.step());
    recorder.checkpoint();
    recorder.restore(solver->snapshot());
    recorder.step(100, body.step());
    recorder.checkpoint();
    Scene again(model);
    const auto replayed = make_solver("cpu", body.tables, again, body.options(tolerance, 2));
    Replay(recorder.recording(), *replayed, again).run();
    EXPECT_TRUE(same_bits(replayed->read(), solver->read())) << tolerance;
  }
}

/// Least seconds of `steps` steps.
double seconds_of(Solver& solver, int steps, double dt) {
  double least = 1e9;
  for (int k = 0; k < 3; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_TRUE(solver.step(steps, dt).ok());
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return least;
}

/// An unloaded body repeats itself; a loaded one shakes by rounding and is held.
TEST(Sleep, ABodyAtRestCostsLittle) {
  const Model model = short_beam();
  const Body& body = body_of(model);
  for (const bool loaded : {false, true}) {
    Scene scene = Scene(model).fix("x0");
    if (loaded) scene.gravity({0, 0, -1.0});
    double seconds[2];
    for (const bool sleeps : {false, true}) {
      const double tolerance = loaded ? 1e-5 : 0.0;
      const auto solver =
          make_solver("cpu", body.tables, scene, body.options(sleeps ? std::optional(tolerance) : std::nullopt));
      EXPECT_TRUE(solver->run_to_rest(30000, body.step()).converged());
      solver->step(100, body.step());
      seconds[sleeps] = seconds_of(*solver, 200, body.step());
    }
    EXPECT_LT(seconds[true], 0.25 * seconds[false]) << loaded;
  }
}

/// run_to_rest() comes as close to rest as without sleep.
TEST(Sleep, DoesNotEndTheSearchForRest) {
  const Model model = short_beam();
  const Body& body = body_of(model);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -1.0});
  State ends[2];
  for (const bool sleeps : {false, true}) {
    const auto solver =
        make_solver("cpu", body.tables, scene, body.options(sleeps ? std::optional(1e-2) : std::nullopt));
    if (sleeps) solver->step(500, body.step());  // held in the middle of the motion
    if (sleeps) solver->reset();
    EXPECT_TRUE(has_converged(solver->run_to_rest(30000, body.step())));
    ends[sleeps] = solver->read();
  }
  EXPECT_TRUE(same_bits(ends[0].position, ends[1].position));
}

TEST(Sleep, AllocatesNothingInAStep) {
  const Model model = two_materials();
  const Body& body = body_of(model);
  Scene scene = Scene(model).fix("x0").add(
      pull(model, "x1", {0, 1, -1}, {{0.0, 0.0}, {20 * body.step(), 1e-3}, {40 * body.step(), 0.0}}, LoadType::force));
  const auto solver = make_solver("cpu", body.tables, scene, body.options(1e-4, 1, 300.0));
  solver->step(1, body.step());  // follows the scene
  const std::size_t before = allocation_count();
  for (int k = 0; k < 400; ++k) solver->step(1, body.step());
  EXPECT_EQ(allocation_count(), before);
  EXPECT_GT(particles_at_speed_zero(solver->read()), 0.1);
}

/// The example of docs/guide/choosing.md.
TEST(Sleep, OfASimulation) {
  const Model organ = short_beam();
  const Material soft = soft_tissue();
  phymul::Simulation sim(
      organ, {.material = soft, .backend = "cpu", .damping = {.rate = 60}, .solver = {.sleep_tolerance = 1e-5}});
  sim.scene().fix("x0").gravity({0, 0, -1.0});
  for (int k = 0; k < 20 && (k == 0 || particles_at_speed_zero(sim.solver().read()) < 1.0); ++k) sim.advance(0.25);
  EXPECT_EQ(particles_at_speed_zero(sim.solver().read()), 1.0);
  EXPECT_GT(largest_distance(sim.solver().read().position, organ.rest), 1e-4);
}

/// For a stiff body the threshold is above gravity.
TEST(Sleep, LetsWhatNothingHoldsFall) {
  const Model model = with_material(make_tetrahedral_block({0.06, 0.03, 0.03}, 6, 3, 3, 0.2, 7),
                                    {.young = 1e7, .poisson = 0.3, .density = 1000.0});
  Scene scene = Scene(model).gravity({0, 0, -1.0});
  const auto solver = make_solver("cpu", model, scene, {}, {.sleep_tolerance = 1e-4});
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(2000, dt).ok());
  const double fallen = model.rest[0].z() - solver->read().position[0].z(), time = 2000 * dt;
  EXPECT_NEAR(fallen / (0.5 * time * time), 1.0, 0.01);
}

/// A flap beside a cut is pushed: its copies move with what they hang on.
TEST(Sleep, KnowsWhatACutHasParted) {
  State ends[2];
  for (const bool sleeps : {false, true}) {
    SimulationOptions options{.backend = "cpu", .damping = {.rate = 20}};
    if (sleeps) options.solver.sleep_tolerance = 0.0;
    Simulation sim(with_spare_particles(long_tetrahedra(), 600), options);
    ASSERT_TRUE(sim.cut(cut_plane({0.121, 0.0, 0.0}, {1.0, 0.2, 0.1})));
    const double dt = 0.3 * sim.solver().stable_step();
    sim.step(20, dt);
    sim.scene().add(pull(sim.model(), "x1", {0, 1, -1}, {{sim.time(), 1e-3}}, LoadType::force));
    ASSERT_TRUE(sim.step(100, dt).ok());
    EXPECT_GT(largest_distance(sim.solver().read().position, sim.model().rest), 1e-5);
    ends[sleeps] = sim.solver().read();
  }
  EXPECT_TRUE(same_bits(ends[0], ends[1]));
}

TEST(Sleep, RefusesWhatIsNoTolerance) {
  const Model model = wide_block();
  const Scene scene(model);
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinite, -infinite, -1e-9}) {
    for (const char* backend : {"cpu", "reference"}) {
      const SolverOptions options{.sleep_tolerance = bad};
      EXPECT_TRUE(refuses([&] { make_solver(backend, model, scene, {}, options); }, "sleep_tolerance")) << bad;
    }
  }
}

/// Laws without sleep and the reference ignore the option.
TEST(Sleep, IsIgnoredWhereThereIsNone) {
  const Model model = make_tetrahedral_block({0.06, 0.03, 0.03}, 6, 3, 3, 0.2, 7);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -0.1});
  for (const char* backend : {"cpu", "reference"}) {
    State ends[2];
    for (const bool sleeps : {false, true}) {
      SolverOptions options{.damping = {.rate = 50.0}};
      if (sleeps) options.sleep_tolerance = 1e-2;
      const auto solver = make_solver(backend, model, scene, {.law = Law::springs}, options);
      EXPECT_TRUE(solver->step(300, 0.5 * solver->stable_step()).ok());
      ends[sleeps] = solver->read();
    }
    EXPECT_TRUE(same_bits(ends[0], ends[1])) << backend;
  }
}

}  // namespace
}  // namespace phymul
