// SPDX-License-Identifier: MIT
//
// The backends "gl" and "gl-compute" against their mirror, bit by bit where the renderer allows (llvmpipe), and against
// the double reference.
#include <thread>

#include "gl_single_steps.h"
#include "support/failure_states.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

class GlEquivalence : public TwinsOnBothDevices {};

PHYMUL_ON_BOTH_DEVICES(GlEquivalence);

/// What a sanitizer watches takes ten times as long, of large bodies most of it.
int states_of(const TopologyTextures& tables) {
  if (sanitized) return tables.base_count > 20000 ? 1 : 10;
  return 100;
}

bool slow_software(const gl::ContextInfo& info) {
  return info.software && !info.renderer.starts_with("llvmpipe");
}

TEST_P(GlEquivalence, SingleStepsHaveTheMirrorsBits) {
  for (const Body& body : bodies()) {
    for (const Variant& variant : all_variants()) {
      SCOPED_TRACE(body.name + ", " + variant.name);
      const Model model = prepared(variant, body);
      const Scene scene(model);
      const auto tables = tables_of(model, variant.options);
      expect_the_mirrors_bits(twins_of(tables, scene), model, states_of(*tables), 0.005);
      if (IsSkipped()) return;
    }
  }
}

TEST_P(GlEquivalence, SingleStepsAreWithinTheRoundingBound) {
  SingleStepErrors worst;
  int left_out = 0;
  for (const Body& body : bodies()) {
    for (const Variant& variant : all_variants()) {
      SCOPED_TRACE(body.name + ", " + variant.name);
      const Model model = prepared(variant, body);
      const Scene scene(model);
      const auto tables = tables_of(model, variant.options);
      SolverOptions options = uncut();
      options.gl.layout = BaseLayout::table;  // the bound is that of its rounded edges
      const GlTwins twins = twins_of(tables, scene, options);
      const bool large = tables->base_count > 20000;
      if (large && slow_software(twins.gl->context()->info())) {
        ++left_out;  // a step takes such a renderer minutes
        continue;
      }
      worst.measure(twins, *tables, large ? 1 : 5, 0.05);
    }
  }
  worst.print();
  std::printf("[   BOUND  ] %d pairs left out as too slow here\n", left_out);
}

TEST_P(GlEquivalence, LoadsOfAllKindsHaveTheMirrorsBits) {
  const Model model = with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2));
  Scene scene = Scene(model).fix("x0").gravity({0.3, -0.2, -9.81});
  const auto add = [&](LoadType type, const char* group, const Vec3& direction, double value) {
    scene.add({.type = type,
               .particles = model.group(group),
               .events = {{0.0, 0.0}, {0.01, value}, {0.02, 0.3 * value}},
               .direction = direction});
  };
  add(LoadType::rotation, "x1", {1, 0.2, 0.1}, 0.8);
  add(LoadType::force, "z1", {0.1, 0.5, 1}, 0.002);
  add(LoadType::force, "y1", {1, 0, 0.3}, -0.001);
  add(LoadType::pressure, "z0", {0, 0, 0}, 20.0);
  add(LoadType::acceleration, "y0", {0, 1, 0}, 4.0);
  add(LoadType::translation, "y1", {0, 1, 0}, 0.002);
  scene.add({.type = LoadType::acceleration,
             .particles = every_particle(model),
             .events = {{0.0, 1.0}, {0.05, -3.0}},
             .direction = {0, 0, 1}});

  const GlTwins twins = twins_of(tables_of(model, {}), scene, damped(20.0));
  const double dt = 0.3 * twins.gl->stable_step();
  double residual = 0.0, speed = 0.0, kinetic = 0.0;  // largest so far
  for (int call = 0; call < 20; ++call) {
    const StepReport gl = twins.gl->step(37, dt), mirror = twins.mirror->step(37, dt);
    ASSERT_TRUE(gl.ok()) << gl.message();
    EXPECT_EQ(gl.time, mirror.time);
    residual = std::max(residual, mirror.residual);
    speed = std::max(speed, mirror.max_speed);
    EXPECT_NEAR(gl.residual, mirror.residual, 1e-5 * twins.scale_of(mirror.residual, residual));
    EXPECT_NEAR(gl.max_speed, mirror.max_speed, 1e-5 * twins.scale_of(mirror.max_speed, speed));
    const State a = twins.gl->read(), b = twins.mirror->read();
    twins.expect_same_bits("call " + std::to_string(call));
    ASSERT_LE(largest_distance(a.position, b.position), 1e-5 * body_size(model));
    const Energy e = twins.gl->energy(), f = twins.mirror->energy();
    EXPECT_NEAR(e.elastic, f.elastic, 1e-5 * f.elastic);
    kinetic = std::max(kinetic, f.kinetic);
    EXPECT_NEAR(e.kinetic, f.kinetic, 1e-5 * twins.scale_of(f.kinetic, kinetic));
    EXPECT_NEAR(e.gravity, f.gravity, 1e-5 * std::abs(f.gravity));
  }
  scene.clear().gravity({0, 0, -1});
  ASSERT_TRUE(all_step(50, dt, twins.gl, twins.mirror));
  twins.expect_same_bits("without loads");
}

/// Steps of the reference and of gl on end; where they part by more than a millionth of the spacing is printed.
void follow_reference(const GlTwins& twins, Solver& reference, const Model& model, double dt, const std::string& name) {
  constexpr int steps = sanitized ? 100 : 2000, at_a_time = 50;
  int parted = 0;
  for (int done = 0; done < steps; done += at_a_time) {
    ASSERT_TRUE(all_step(at_a_time, dt, twins.gl, reference));
    if (parted > 0) continue;
    const double apart = largest_distance(twins.gl->read().position, reference.read().position);
    if (apart > 1e-6 * mean_spacing(model)) parted = done + at_a_time;
  }
  ASSERT_TRUE(twins.mirror->step(steps, dt).ok());
  twins.expect_same_bits(name);
  const double apart = largest_distance(twins.gl->read().position, reference.read().position);
  EXPECT_LE(apart, 1e-5 * body_size(model));
  std::printf("[ REFERENCE] %s: %s%d; after %d steps apart by %.2g of the body's size\n", name.c_str(),
              parted > 0 ? "a millionth of the spacing apart by step " : "never a millionth apart, to step ",
              parted > 0 ? parted : steps, steps, apart / body_size(model));
}

TEST_P(GlEquivalence, DampedBodiesComeToTheReferencesRest) {
  const gl::ContextInfo info = gl::Context::open({})->info();
  const bool slow = slow_software(info);
  for (const Body& body : bodies()) {
    for (const Variant& variant : all_variants()) {
      const bool settles = variant.options.reaction != Reaction::full;  // which grows without bound
      const bool chosen_by_name =
          variant.name == "conservative" || variant.name == "material" || variant.name == "shared";
      const bool chosen = body.name == "block18" || body.name == "strip" || chosen_by_name;
      if (!settles || !chosen) continue;
      // Two thousand steps of the larger bodies take a software renderer other than llvmpipe minutes.
      if (slow && (body.model.particle_count() > 20 || !chosen_by_name)) continue;
      SCOPED_TRACE(body.name + ", " + variant.name);
      const Model model = prepared(variant, body);
      const Scene scene(model);
      const auto tables = tables_of(model, variant.options);
      const GlTwins twins = twins_of(tables, scene, {.damping = {.factor = 0.9}});
      const auto reference = make_solver("reference", tables, scene, twins.options());
      const State start = random_state(model, 0.05, 0.0, 5);
      twins.reset(start);
      reference->reset(start);
      follow_reference(twins, *reference, model, 0.3 * reference->stable_step(), body.name + ", " + variant.name);
    }
  }
}

/// Where elastic forces are cut, on the way back from states no tissue is in.
TEST_P(GlEquivalence, FailureStatesHaveTheMirrorsBits) {
  constexpr double side = 0.03;
  const Model model = with_material(make_block({side, side, side}, 3, 3, 3, 6));
  const Scene scene(model);
  const GlTwins twins = twins_of(tables_of(model, {}), scene, {.damping = {.factor = 0.98}});
  for (const FailureState& failure : failure_states()) {
    SCOPED_TRACE(failure.name);
    std::mt19937 bits(5);
    State state = rest_state(model);
    failure.apply(state.position, side, side / 3, bits);
    twins.reset(state);
    for (int k = 0; k < 4; ++k) {
      const StepReport gl = twins.gl->step(50, 0.5 * twins.gl->stable_step());
      const StepReport mirror = twins.mirror->step(50, 0.5 * twins.gl->stable_step());
      EXPECT_TRUE(gl.ok()) << gl.message();
      EXPECT_TRUE(gl.force_clamped || k > 0);
      EXPECT_TRUE(gl.force_clamped == mirror.force_clamped || !twins.same_bits_expected()) << "call " << k;
      twins.expect_same_bits("call " + std::to_string(k));
    }
  }
}

/// Far from the origin, where positions alone would lose the last bits of displacements.
TEST_P(GlEquivalence, SnapshotsGoOnBitForBit) {
  const Model model = moved(jittered_block(), {1000.0, -2000.0, 500.0});
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  gl::DeviceSolver solver(GetParam(), tables_of(model, {}), scene, {});
  const double dt = 0.4 * solver.stable_step();
  solver.step(37, dt);
  const Snapshot snapshot = solver.snapshot();
  solver.step(20, dt);
  const Snapshot there = solver.snapshot();
  solver.restore(snapshot);
  EXPECT_EQ(solver.snapshot(), snapshot);
  solver.step(20, dt);
  EXPECT_EQ(solver.snapshot(), there);
}

TEST_P(GlEquivalence, FourSolversInFourThreads) {
  const Model model = jittered_block();
  const Scene scene(model);
  const auto tables = tables_of(model, {});
  const auto run = [&] {
    gl::DeviceSolver solver(GetParam(), tables, scene, {.spectrum = estimate_spectrum(*tables, tables->rest)});
    solver.reset(random_state(model, 0.1, 0.0, 3));
    for (int k = 0; k < 20; ++k) EXPECT_TRUE(solver.step(5, 0.4 * solver.stable_step()).ok());
    return solver.read();
  };
  const State alone = run();
  std::array<State, 4> states;
  std::vector<std::thread> threads;
  for (State& state : states) threads.emplace_back([&] { state = run(); });
  for (std::thread& thread : threads) thread.join();
  for (const State& state : states) EXPECT_EQ(difference(state, alone), "");
}

TEST_P(GlEquivalence, FarFromTheOriginNoDigitIsLost) {
  const Model model = with_material(moved(jittered_block(), {1000.0, -1000.0, 1000.0}));
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  const GlTwins twins = twins_of(tables_of(model, {}), scene, damped(5.0));
  const auto reference = make_solver("reference", model, scene, {}, twins.options());
  ASSERT_TRUE(all_step(3000, 0.4 * reference->stable_step(), twins.gl, reference));
  const State far = twins.gl->read(), exact = reference->read();
  EXPECT_GE(largest_distance(exact.position, model.rest), 0.01 * body_size(model)) << "the body hardly moved";
  const double error = largest_distance(far.position, exact.position) / body_size(model);
  std::printf("[  OFFSET  ] error against double after 3,000 steps: %.2g of the body's size\n", error);
  EXPECT_LE(error, 1e-6);
}

}  // namespace
}  // namespace phymul::test
