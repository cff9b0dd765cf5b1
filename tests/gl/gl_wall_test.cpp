// SPDX-License-Identifier: MIT
//
// Walls on the GL backends: against the float mirror bit by bit where the renderer allows (llvmpipe), and against the
// double reference.
#include <algorithm>

#include "model/enclosed_volume.h"
#include "support/bounded_forces.h"
#include "support/cut_walls.h"
#include "support/gl_block.h"
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

/// One triangle, whose patch has no other vertices; free edges; none; edges of three triangles; clamped ones; beside
/// cells, and on them.
std::vector<Body> wall_bodies() {
  Surface one;
  one.vertices = {{0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.005}};
  one.triangles = {{0, 1, 2}};
  return {{"triangle", make_wall(one, {.material = film})},
          {"sheet", sheet()},
          {"sphere", sphere()},
          {"tee", tee()},
          {"clamped", clamped_sheet()},
          {"fin", block_with_fin()},
          {"capsule", slab_in_capsule()}};
}

TEST_P(GlWall, SingleStepsHaveTheMirrorsBits) {
  for (const Body& body : wall_bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    const GlTwins twins = twins_of(tables_of(body.model, {}), scene);
    if (!twins.same_bits_expected()) {
      GTEST_SKIP() << "NOT TESTED: " << twins.gl->device() << " is not llvmpipe of Mesa 22";
    }
    const double dt = 0.3 * twins.gl->stable_step();
    const double speed = 0.1 * mean_spacing(body.model) / dt;
    for (int k = 0; k < (sanitized ? 3 : 10); ++k) {
      twins.reset(random_state(body.model, 0.02 + 0.05 * k, speed, 17 + k));
      ASSERT_TRUE(all_step(1, dt, twins.gl, twins.mirror));
      ASSERT_EQ(difference(twins.gl->read(), twins.mirror->read()), "") << "state " << k;
    }
  }
}

/// Of a step from standing still, as GlAveraged does. The bound is wide: forces are held to ten times the largest error
/// measured there too.
TEST_P(GlWall, SingleStepsAreWithinTheRoundingBound) {
  double worst = 0.0, worst_force = 0.0;
  for (const Body& body : wall_bodies()) {
    SCOPED_TRACE(body.name);
    const Model& model = body.model;
    const Scene scene(model);
    const auto tables = tables_of(model, {});
    const GlTwins twins = twins_of(tables, scene, uncut());
    const double dt = 0.3 * twins.gl->stable_step();
    for (int k = 0; k < 3; ++k) {
      twins.gl->reset(random_state(model, 0.05 + 0.1 * k, 0.0, 29 + k));
      const State start = twins.gl->read();  // as rounded
      VecList u = start.position, exact(u.size());
      for (std::size_t i = 0; i < u.size(); ++i) u[i] = (u[i] - model.rest[i]).cast<float>().cast<double>();
      elastic_forces(*tables, start.position, exact);
      ASSERT_TRUE(twins.gl->step(1, dt).ok());
      const State moved = twins.gl->read();
      worst = std::max(worst, share_of_bound(*tables, BoundedForces(*tables, u), moved.velocity, dt));
      const double largest = largest_norm(exact);
      for (Index i = 0; i < model.particle_count(); ++i) {
        const Vec3 felt = tables->mass[i] / dt * moved.velocity[i];
        worst_force = std::max(worst_force, (felt - exact[i]).norm() / largest);
      }
    }
  }
  std::printf("[   BOUND  ] worst error %.3f of the bound, %.2g of the largest force\n", worst, worst_force);
  EXPECT_LE(worst_force, 1e-5);
}

TEST_P(GlWall, RestIsAFixedPointToTheLastBit) {
  for (const Body& body : wall_bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    const GlTwins twins = twins_of(tables_of(body.model, {}), scene);
    for (const Vec3& shift : {Vec3(0, 0, 0), Vec3(0.125, -0.25, 0)}) {
      State start = rest_state(body.model);
      for (Vec3& x : start.position) x += shift;
      twins.gl->reset(start);
      start = twins.gl->read();
      ASSERT_TRUE(twins.gl->step(20, 0.3 * twins.gl->stable_step()).ok());
      State end = twins.gl->read();
      end.time = start.time;
      EXPECT_EQ(difference(end, start), "");
    }
  }
}

/// Free in space, thrown and out of shape. Momentum moves as far as floats let it; the bounds are eight times the
/// largest of what llvmpipe gave.
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
  ASSERT_TRUE(all_step(300, 0.5 * twins.gl->stable_step(), twins.gl, twins.mirror));
  twins.expect_same_bits("a free bag");
  const Momentum end = twins.gl->momentum();
  const double linear = (end.linear - start.linear).norm() / scale;
  const double angular = (end.angular - start.angular).norm() / (scale * body_size(model));
  const double kept = std::abs(twins.gl->energy().total() / energy - 1.0);
  std::printf("[  WALLS   ] momentum moved by %.2g, angular by %.2g, energy by %.2g\n", linear, angular, kept);
  EXPECT_LE(linear, 1e-6);
  EXPECT_LE(angular, 1e-6);
  EXPECT_LE(kept, 1e-2);
}

struct WallScene {
  std::string name;
  Model model;
  void (*act)(Scene&);
};

void hold_and_pull(Scene& scene) {
  const Model& model = scene.model();
  scene.fix(model.particles_in([](const Vec3& x) { return x.x() < 1e-9; })).gravity({0, 0, -9.81});
  Load pull;
  pull.type = LoadType::translation;
  pull.particles = model.particles_in([](const Vec3& x) { return x.x() > sheet_side - 1e-9; });
  pull.direction = {0.02, 0, 0.02};
  pull.events = {{0.0, 0.0}, {0.05, 1.0}};
  scene.add(pull);
}

void hang(Scene& scene) {
  scene.fix(scene.model().particles_in([](const Vec3& x) { return x.x() < 1e-6; })).gravity({0, 0, -9.81});
}

void hang_full(Scene& scene) {
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
                              {"capsule", slab_in_capsule(), hang}};
  for (const WallScene& at : scenes) {
    SCOPED_TRACE(at.name);
    Scene scene(at.model);
    at.act(scene);
    const GlTrio trio = trio_of(tables_of(at.model, {}), scene, {.damping = {.rate = 20.0}});
    const double dt = 0.4 * trio.reference->stable_step();
    const int calls = sanitized ? 1 : 4;
    double moved = 0.0, off = 0.0;
    for (int k = 0; k < calls; ++k) {
      trio.step(100, dt);
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

}  // namespace
}  // namespace phymul::test
