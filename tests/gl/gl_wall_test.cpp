// SPDX-License-Identifier: MIT
//
// Walls on the GL backends: against the float mirror bit by bit where the renderer allows (llvmpipe), and against the
// double reference.
#include <algorithm>

#include "gl_single_steps.h"
#include "support/cut_bodies.h"
#include "support/gl_bodies.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

class GlWall : public TwinsOnBothDevices {};

PHYMUL_ON_BOTH_DEVICES(GlWall);

Model clamped_sheet() {
  Model model = sheet();
  clamp_edges(model, [](const Vec3& x) { return x.x() < 1e-6; });
  return model;
}

/// One triangle, whose patch has no other vertices; free edges; none; edges of three triangles; clamped ones; on cells.
std::vector<Body> wall_bodies() {
  Surface one;
  one.vertices = {{0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.005}};
  one.triangles = {{0, 1, 2}};
  return {{"triangle", make_wall(one, {.material = film})},
          {"sheet", sheet()},
          {"sphere", sphere()},
          {"tee", tee()},
          {"clamped", clamped_sheet()},
          {"capsule", slab_in_capsule()}};
}

TEST_P(GlWall, SingleStepsHaveTheMirrorsBits) {
  for (const Body& body : wall_bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    expect_the_mirrors_bits(twins_of(tables_of(body.model, {}), scene), body.model, sanitized ? 2 : 5, 0.1);
    if (IsSkipped()) return;
  }
}

/// The bound is wide: forces are held to ten times the largest error measured too (llvmpipe 15, 2026-11-30).
TEST_P(GlWall, SingleStepsAreWithinTheRoundingBound) {
  SingleStepErrors worst;
  for (const Body& body : wall_bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    const auto tables = tables_of(body.model, {});
    worst.measure(twins_of(tables, scene, uncut()), *tables, 3, 0.06);
  }
  worst.print();
  EXPECT_LE(worst.of_force, 4e-6);
}

TEST_P(GlWall, RestIsAFixedPointToTheLastBit) {
  for (const Body& body : wall_bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    expect_rest_is_kept(twins_of(tables_of(body.model, {}), scene), body.model, {0.125, -0.25, 0}, 20);
  }
}

/// Free in space, thrown and turning, and swinging through its ovals. Momentum moves as far as floats let it: the
/// bounds are ten times what llvmpipe gave.
TEST_P(GlWall, AFreeBagKeepsItsMomentumAndEnergy) {
  const Model model = sphere();
  const Scene scene(model);
  const GlTwins twins = twins_of(tables_of(model, {}), scene);
  State state = rest_state(model);
  double scale = 0.0;
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    const Vec3& X = model.rest[i];
    state.velocity[i] = Vec3(0.03, -0.01, 0.02) + Vec3(0, 0, 2).cross(X) + Vec3(1.5 * X.x(), -1.5 * X.y(), 0.0);
    scale += model.mass[i] * state.velocity[i].norm();
  }
  twins.reset(state);
  const Momentum start = twins.gl->momentum();
  const double energy = twins.gl->energy().total();
  ASSERT_TRUE(all_step(200, 0.5 * twins.gl->stable_step(), twins.gl, twins.mirror));
  twins.expect_same_bits("a free bag");
  const Momentum end = twins.gl->momentum();
  const double linear = (end.linear - start.linear).norm() / scale;
  const double angular = (end.angular - start.angular).norm() / (scale * body_size(model));
  const double kept = std::abs(twins.gl->energy().total() / energy - 1.0);
  std::printf("[  WALLS   ] momentum moved by %.2g, angular by %.2g, energy by %.2g\n", linear, angular, kept);
  EXPECT_LE(linear, 5e-7);
  EXPECT_LE(angular, 5e-7);
  EXPECT_LE(kept, 1e-3);
}

struct WallScene {
  std::string name;
  Model model;
  void (*act)(Scene&, double dt);
};

/// By a fifth of its length, and up.
void hold_and_pull(Scene& scene, double dt) {
  const Model& model = scene.model();
  scene.fix(model.particles_in([](const Vec3& x) { return x.x() < 1e-9; })).gravity({0, 0, -9.81});
  Load pull;
  pull.type = LoadType::translation;
  pull.particles = model.particles_in([](const Vec3& x) { return x.x() > sheet_side - 1e-9; });
  pull.direction = {1, 0, 1};
  pull.events = {{0.0, 0.0}, {120 * dt, 0.02}};
  scene.add(pull);
}

void hang(Scene& scene, double /*dt*/) {
  scene.fix(scene.model().particles_in([](const Vec3& x) { return x.x() < 1e-6; })).gravity({0, 0, -9.81});
}

/// By a joint too, and with a force: of all passes that gather, those that read most tables.
void hang_tied(Scene& scene, double dt) {
  hang(scene, dt);
  const std::vector<Index> far = scene.model().particles_in([](const Vec3& x) { return x.x() > 0.059; });
  scene.add_joint({at_particle(far.front()), at_world(scene.model().rest[far.front()] + Vec3(0, 0, 0.01))}, 5.0);
  Load push;
  push.type = LoadType::force;
  push.particles = far;
  push.direction = {0, 1, 0};
  push.events = {{0.0, 1e-3}};
  scene.add(push);
}

void hang_full(Scene& scene, double /*dt*/) {
  scene.fix(scene.model().particles_in([](const Vec3& x) { return x.z() > 0.04; })).gravity({0, 0, -9.81});
  scene.constrain_volume();
}

/// Stretched and bent, hanging, full, branching, clamped, on cells: damped, under gravity. The limit is that of
/// GlEquivalence.
TEST_P(GlWall, BodiesGoWhereTheReferenceGoes) {
  const WallScene scenes[] = {{"sheet, pulled", sheet(), hold_and_pull},
                              {"bag, full", sphere(), hang_full},
                              {"tee", tee(), hang},
                              {"sheet, clamped", clamped_sheet(), hang},
                              {"capsule, tied", slab_in_capsule(), hang_tied}};
  for (const WallScene& at : scenes) {
    SCOPED_TRACE(at.name);
    Scene scene(at.model);
    const auto tables = tables_of(at.model, {});
    const double dt = 0.4 * stable_step(estimate_spectrum(*tables, tables->rest), 1.0);
    at.act(scene, dt);
    const GlTrio trio = trio_of(tables, scene, {.damping = {.rate = 20.0}});
    double moved = 0.0, off = 0.0;
    for (int k = 0; k < (sanitized ? 1 : 3); ++k) {
      trio.step(40, dt);
      moved = std::max(moved, largest_distance(trio.reference->read().position, at.model.rest));
      off = std::max(off, trio.apart());
    }
    std::printf("[ REFERENCE] %s: apart by %.2g of a motion of %.2g of the body's size\n", at.name.c_str(), off / moved,
                moved / body_size(at.model));
    EXPECT_LE(off, 1e-5 * body_size(at.model));
    EXPECT_GE(moved, (sanitized ? 0.0 : 1e-2) * body_size(at.model));
    const Energy a = trio.twins.gl->energy(), b = trio.reference->energy();
    EXPECT_NEAR(a.elastic, b.elastic, 1e-4 * b.elastic);
  }
}

/// Where the passes of a step are others: a full bag lies on a slab in a capsule, into which a ball is pressed.
TEST_P(GlWall, ToolsContactsAndVolumesActOnIt) {
  const Model low = slab_in_capsule();
  const Model bag = moved(wall_of(sphere_surface(0.01, 3), 20e3, 0.4, 1e-3), {0.0404, 0.0203, 0.0415});
  const Model model = merged({{"low", &low}, {"bag", &bag}});
  Scene scene(model);
  scene.fix(model.particles_in([](const Vec3& x) { return x.z() < 1e-9; }));
  scene.gravity({0, 0, -9.81}).contacts({}).constrain_volume("bag");
  const Index under = low.particles_in([](const Vec3& x) { return x.z() > 0.03 - 1e-9 && x.x() < 0.015; })[2];
  const Vec3 start = low.rest[under] + Vec3(1e-3, 0, 5.2e-3);
  scene.add_tool("ball", {.shape = Sphere{0.005}, .pose = {.position = start}, .friction = 0.3});
  SolverOptions damped{.damping = {.rate = 30.0}};
  const auto tables = tables_of(model, {});
  damped.spectrum = estimate_spectrum(*tables, tables->rest);
  gl::DeviceSolver solver(GetParam(), tables, scene, damped);
  const auto reference = make_solver("reference", tables, scene, damped);
  Scene apart = scene.copy();
  apart.no_contacts();
  const auto untouched = make_solver("reference", tables, apart, damped);
  const double dt = 0.4 * reference->stable_step();
  double moved = 0.0, off = 0.0;
  for (int k = 0; k < 4; ++k) {
    scene.tool("ball").move_to({.position = start - Vec3(0, 0, 5e-4 * k)});
    ASSERT_TRUE(all_step(8, dt, solver, reference, untouched));
    const State exact = reference->read();
    moved = std::max(moved, largest_distance(exact.position, model.rest));
    off = std::max(off, largest_distance(solver.read().position, exact.position));
  }
  EXPECT_GT(solver.tool_force("ball").force.norm(), 0.0);
  const auto bottom = [&](Solver& of) { return lowest(of.read(), model.group("bag")); };
  EXPECT_GT(bottom(solver) - bottom(*untouched), 1e-5);
  std::printf("[ REFERENCE] off by at most %.2g of the motion, %.2g m\n", off / moved, moved);
  EXPECT_GT(moved, 5e-4);
  EXPECT_LE(off, 1e-5 * moved);
}

/// Cut, with triangles removed, and whole again.
TEST_P(GlWall, FollowsEditsOfTheBody) {
  for (const Model& model : {sheet(), slab_in_capsule()}) {
    SCOPED_TRACE(model.particle_count());
    const Model body = with_spare_particles(model, 100);
    Simulation device(body, without_material(name_of(GetParam()))), exact(body, without_material("reference"));
    const double dt = 0.3 * exact.step_limit();
    const auto on_both = [&](auto&& call) {
      call(device);
      call(exact);
      for (Simulation* const sim : {&device, &exact}) ASSERT_TRUE(sim->step(40, dt).ok());
      EXPECT_EQ(device.solver().topology_hash(), exact.solver().topology_hash());
      EXPECT_LE(largest_distance(device.state().position, exact.state().position), 1e-5 * body_size(model));
    };
    for (Simulation* const sim : {&device, &exact}) {
      sim->scene().fix(model.particles_in([](const Vec3& x) { return x.x() < 1e-9; })).gravity({0, 0, -9.81});
    }
    on_both([](Simulation&) {});
    const Vec3 middle = model.rest[static_cast<std::size_t>(model.particle_count() / 2)];
    on_both([&](Simulation& sim) { ASSERT_TRUE(sim.cut(cut_plane(middle, {0.3, 1.0, 0.1}))); });
    const VecList before = exact.state().position;
    on_both([](Simulation& sim) {
      std::vector<Index> rows;
      for (Index row = 0; row < static_cast<Index>(sim.model().cells.size()); row += 9) rows.push_back(row);
      sim.remove_cells(rows);
    });
    EXPECT_GT(largest_distance(exact.state().position, before), 1e-3 * body_size(model));
  }
}

TEST_P(GlWall, OnlyWallsPayForThem) {
  using Names = std::vector<std::string>;
  const bool draws = GetParam() == GlBackend::fragment;
  const Model block = with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2));
  EXPECT_EQ(std::ranges::count(passes_of(block, GetParam()), "walls_pass"), 0);
  EXPECT_EQ(passes_of(sheet(), GetParam()),
            draws ? Names({"walls_pass", "step_pass"}) : Names({"terms_kernel", "step_kernel"}));
  EXPECT_EQ(passes_of(slab_in_capsule(), GetParam()),
            draws ? Names({"walls_pass", "domains_pass", "step_pass"}) : Names({"terms_kernel", "step_kernel"}));
}

}  // namespace
}  // namespace phymul::test
