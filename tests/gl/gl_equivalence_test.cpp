// SPDX-License-Identifier: MIT
//
// The backends "gl" and "gl-compute" against their mirror, bit by bit where the renderer allows (llvmpipe), and against
// the double reference; bodies of Law::particle_averaged by themselves.
#include <algorithm>
#include <thread>

#include "gl_single_steps.h"
#include "support/failure_states.h"
#include "support/gl_bodies.h"
#include "support/message_of.h"
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

class GlAveraged : public TwinsOnBothDevices {};

PHYMUL_ON_BOTH_DEVICES(GlAveraged);

std::shared_ptr<const TopologyTextures> averaged_tables(const Model& model) {
  return tables_of(model, {.law = Law::particle_averaged});
}

std::vector<Body> averaged_bodies() {
  std::vector<Body> all;
  const auto add = [&](std::string name, Model model) {
    set_material(model, soft_tissue());
    all.push_back({std::move(name), std::move(model)});
  };
  const Model tetrahedra = make_tetrahedral_block({0.03, 0.02, 0.02}, 4, 2, 3, 0.2, 5);
  const Model hexahedra = make_block({0.03, 0.02, 0.02}, 4, 3, 2);
  add("one tetrahedron", make_tetrahedron(0.01));
  add("tetrahedra", tetrahedra);
  add("hexahedra", hexahedra);
  add("jittered hexahedra", jittered_block());
  add("hexahedra and wedges", cylinder_275());
  add("strip", make_strip(0.04, 0.02, 6, 3));
  for (const auto& [name, model] : {std::pair("tetrahedra", &tetrahedra), std::pair("hexahedra", &hexahedra)}) {
    all.push_back(
        {name + std::string(" of two materials"), with_harder_half(*model, soft_tissue(0.45), {50e3, 0.2, 1500.0})});
  }
  return all;
}

TEST_P(GlAveraged, SingleStepsHaveTheMirrorsBits) {
  for (const Body& body : averaged_bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    expect_the_mirrors_bits(twins_of(averaged_tables(body.model), scene), body.model, sanitized ? 3 : 30, 0.015);
    if (IsSkipped()) return;
  }
}

/// The bound is wide (llvmpipe uses 0.011 of it), so forces are held to ten times the largest error measured there too:
/// 2.8e-7 of the body's largest force (llvmpipe 15, 2026-11-23).
TEST_P(GlAveraged, SingleStepsAreWithinTheRoundingBound) {
  SingleStepErrors worst;
  for (const Body& body : averaged_bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    const auto tables = averaged_tables(body.model);
    worst.measure(twins_of(tables, scene, uncut()), *tables, 5, 0.05);
  }
  worst.print();
  EXPECT_LE(worst.of_force, 3e-6);
}

/// Damped, under gravity; the limit is that of GlEquivalence for other laws.
TEST_P(GlAveraged, BodiesGoWhereTheReferenceGoes) {
  const int steps = sanitized ? 100 : 600;
  for (const Body& body : averaged_bodies()) {
    SCOPED_TRACE(body.name);
    Scene scene(body.model);
    scene.fix(body.name == "one tetrahedron" ? "base" : body.name == "hexahedra and wedges" ? "bottom" : "x0");
    scene.gravity({0, -9.81, 0});
    const auto tables = averaged_tables(body.model);
    const GlTrio trio = trio_of(tables, scene, {.damping = {.factor = 0.99}});
    const State start = random_state(body.model, 0.05, 0.0, 5);
    trio.reset(start);
    const double dt = 0.3 * trio.reference->stable_step();
    for (int done = 0; done < steps; done += 100) {
      trio.step(100, dt, "step " + std::to_string(done + 100));
      ASSERT_LE(trio.apart(), 1e-5 * body_size(body.model)) << "step " << done + 100;
    }
    std::printf("[ REFERENCE] %s: after %d steps apart by %.2g of the body's size\n", body.name.c_str(), steps,
                trio.apart() / body_size(body.model));
    const Energy a = trio.twins.gl->energy(), b = trio.reference->energy();
    EXPECT_NEAR(a.elastic, b.elastic, 1e-5 * b.elastic);
    EXPECT_GE(largest_distance(start.position, trio.reference->read().position), 1e-3 * body_size(body.model));
  }
}

/// Where the passes of a step are others: a ball is pressed into a slab under a cube whose volume is kept.
TEST_P(GlAveraged, ToolsContactsAndVolumesActOnIt) {
  Model model = stacked(1e-4);
  model.add_group("corner", model.cells[0].particles);
  set_material(model, {20e3, 0.4, 1200.0}, "corner");
  Scene scene = Scene(model).fix("low/z0").gravity({0, 0, -9.81}).contacts({}).constrain_volume("high");
  scene.add_tool("ball", {.shape = Sphere{0.004}, .pose = {.position = Vec3(0.005, 0.005, 0.0142)}, .friction = 0.3});
  SolverOptions damped{.damping = {.rate = 30.0}};
  const auto tables = averaged_tables(model);
  damped.spectrum = estimate_spectrum(*tables, tables->rest);
  gl::DeviceSolver solver(GetParam(), tables, scene, damped);
  const auto reference = make_solver("reference", tables, scene, damped);
  const double dt = 0.4 * reference->stable_step();
  double moved = 0.0, off = 0.0;
  for (int k = 0; k < 10; ++k) {
    scene.tool("ball").move_to({.position = Vec3(0.005, 0.005, 0.0142 - 2e-4 * k)});
    ASSERT_TRUE(all_step(20, dt, solver, reference));
    const State exact = reference->read();
    moved = std::max(moved, largest_distance(exact.position, model.rest));
    off = std::max(off, largest_distance(solver.read().position, exact.position));
  }
  EXPECT_GT(solver.tool_force("ball").force.norm(), 0.0);
  std::printf("[ REFERENCE] off by at most %.2g of the motion\n", off / moved);
  EXPECT_GT(moved, 5e-4);
  EXPECT_LE(off, 1e-5 * moved);
}

TEST_P(GlAveraged, RestIsAFixedPointToTheLastBit) {
  for (const Body& body : averaged_bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    const GlTwins twins = twins_of(averaged_tables(body.model), scene);
    for (const Vec3& shift : {Vec3(0, 0, 0), Vec3(0.125, -0.25, 0)}) expect_rest_is_kept(twins, body.model, shift, 50);
  }
}

/// In 2-D no rounding leads out of the plane.
TEST_P(GlAveraged, AStripStaysInItsPlane) {
  const Model model = with_material(make_strip(0.04, 0.02, 6, 3), soft_tissue(0.45));
  const Scene scene(model);
  const GlTwins twins = twins_of(averaged_tables(model), scene);
  twins.gl->reset(random_state(model, 0.2, 0.0, 5));
  ASSERT_TRUE(twins.gl->step(100, 0.3 * twins.gl->stable_step()).ok());
  for (const Vec3& x : twins.gl->read().position) EXPECT_EQ(x.z(), 0.0);
}

TEST_P(GlAveraged, OnlyThisLawPaysForIt) {
  using Names = std::vector<std::string>;
  const Model block = make_block({0.03, 0.02, 0.02}, 4, 3, 2);
  const Names without = passes_of(block, GetParam());
  EXPECT_EQ(std::ranges::count(without, "domains_pass"), 0);
  const bool draws = GetParam() == GlBackend::fragment;
  EXPECT_EQ(passes_of(with_material(block), GetParam()),
            draws ? Names({"domains_pass", "step_pass"}) : Names({"terms_kernel", "step_kernel"}));
}

TEST_P(GlAveraged, ConstantsBeyondSinglePrecisionAreRefused) {
  const Model model = with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2), {1e40, 0.3, 1e36});
  const Scene scene(model);
  EXPECT_TRUE(refuses([&] { gl::DeviceSolver(GetParam(), averaged_tables(model), scene, {.spectrum = Spectrum{}}); },
                      "is beyond the range of single precision"));
}

}  // namespace
}  // namespace phymul::test
