// SPDX-License-Identifier: MIT
//
// Bodies that touch each other, and themselves.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "interaction/contact_surface.h"
#include "model/closed_surface.h"
#include "support/every_backend.h"
#include "support/message_of.h"
#include "support/run_scenes.h"
#include "support/touching_bodies.h"

namespace phymul {
namespace {

using namespace test;

TEST(ClosestPoint, IsNoFurtherThanAnyOther) {
  std::mt19937 bits(6);
  for (int k = 0; k < 2000; ++k) {
    const Vec3 a = random_vector(bits, 3), b = random_vector(bits, 3), c = random_vector(bits, 3);
    const Vec3 p = 2.0 * random_vector(bits, 3), share = closest_point(p, a, b, c);
    EXPECT_NEAR(share.sum(), 1.0, 1e-14);
    EXPECT_GE(share.minCoeff(), 0.0);
    const double distance = (p - (share[0] * a + share[1] * b + share[2] * c)).norm();
    for (int m = 0; m < 20; ++m) {
      Vec3 other = (random_vector(bits, 3) + Vec3(1, 1, 1)) / 2.0;
      other /= other.sum();
      EXPECT_LE(distance, (p - (other[0] * a + other[1] * b + other[2] * c)).norm() + 1e-12);
    }
  }
  EXPECT_EQ(closest_point({1, 1, 1}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}).sum(), 1.0);
}

/// A cube of 2 cm over the middle of a slab, a gap above it and off its lattice.
Model cube_on_slab(double gap) {
  return joined_bodies(tissue({0, 0, 0}, {12, 12, 4}), tissue({0.0213, 0.0221, 0.02 + gap}, {4, 4, 4}));
}

/// Bodies that cannot reach themselves move the same, bit for bit, whether they are looked at for it or left out where
/// no other body is near.
TEST(BodyContact, LeavesOutOnlyWhatNothingCanTouch) {
  const Model model = cube_on_slab(0.0002);
  for (const char* backend : {"reference", "cpu"}) {
    State end[2];
    for (const bool self : {false, true}) {
      Scene scene = Scene(model).gravity({0.5, 0, -9.81}).fix("low/z0").contacts({.friction = 0.3, .self = self});
      const auto solver = make_solver(backend, model, scene, {}, {.damping = {.rate = 10.0}, .threads = 1});
      const double dt = 0.4 * solver->stable_step();
      ASSERT_TRUE(solver->step(static_cast<int>(0.025 / dt), dt).ok());
      end[self] = solver->read();
    }
    EXPECT_EQ(end[0], end[1]) << backend;
    EXPECT_GT(lowest(end[0], model.group("high")), 0.0194) << backend;  // m; free it falls to 0.0171
  }
}

/// Dropped from 5 cm: never through, never apart, and at rest on the other in the end.
TEST(BodyContact, ABodyDroppedOnAnotherStaysOnIt) {
  const Model model = cube_on_slab(0.05);
  for (const BackendCase& backend : cpu_backends) {
    Scene scene = Scene(model).gravity({0, 0, -9.81}).fix("low/z0").contacts({.friction = 0.5});
    SolverOptions options = options_for(backend, 10.0);
    const auto solver = make_solver(backend.name, model, scene, {}, options);
    const double dt = 0.4 * solver->stable_step();
    const std::vector<Index> high = model.group("high"), low = model.group("low");
    double deepest = 1e9, fastest = 0.0;
    const int calls = static_cast<int>(1.2 / (20 * dt));
    for (int k = 0; k < calls; ++k) {
      const StepReport report = solver->step(20, dt);
      ASSERT_TRUE(report.ok()) << report.message();
      deepest = std::min(deepest, lowest(solver->read(), high));
      fastest = std::max(fastest, report.max_speed);
    }
    const State end = solver->read();
    EXPECT_GT(deepest, 0.012) << backend.name;  // m: in the slab's upper half at all times
    EXPECT_LT(fastest, 2.5) << backend.name;    // m/s; it falls at 1
    EXPECT_GT(mean_place(end, high).z(), mean_place(end, low).z() + 0.01) << backend.name;
    EXPECT_LT(mean_place(end, high).z(), mean_place(end, low).z() + 0.03) << backend.name;
    Vec3 speed = Vec3::Zero();
    for (const Index i : high) speed += end.velocity[i] / static_cast<double>(high.size());
    EXPECT_LT(speed.norm(), 0.02) << backend.name;
  }
}

/// Thrown at each other at 2 m/s without gravity: what one loses the other gains, to rounding, at every step.
TEST(BodyContact, MomentumIsKeptToRounding) {
  const Model model = cube_on_slab(0.01);
  for (const double friction : {0.0, 0.6}) {
    Scene scene = Scene(model).contacts({.friction = friction});
    const auto solver = make_solver("reference", model, scene, {}, uncut());
    State state = rest_state(model);
    double scale = 0.0;
    for (const Index i : model.group("high")) state.velocity[i] = Vec3(0.5, 0.2, -2.0);
    for (Index i = 0; i < model.particle_count(); ++i) scale += model.mass[i] * state.velocity[i].norm();
    solver->reset(state);
    const Momentum start = solver->momentum();
    const double dt = 0.1 * solver->stable_step();
    double turned = 0.0;
    for (int k = 0; k < 400; ++k) {
      ASSERT_TRUE(is_ok(solver->step(1, dt)));
      const Momentum now = solver->momentum();
      ASSERT_LT((now.linear - start.linear).norm(), 1e-13 * scale) << k;
      turned = std::max(turned, (now.angular - start.angular).norm());
    }
    double given = 0.0;
    const State end = solver->read();
    for (const Index i : model.group("low")) given += model.mass[i] * end.velocity[i].z();
    EXPECT_LT(given, -0.1 * scale);  // they met
    // Along the way between a particle and a triangle there is no torque; what is left is the parting of overlaps.
    if (friction == 0.0) {
      EXPECT_LT(turned, 1e-3 * scale * 0.02);
    }
  }
}

/// On a body that stays, under gravity that leans: below the angle of friction it stays, beyond it it slides, and is
/// then rubbed by the coefficient times what presses it. Both forces from the block's momentum: gravity, less what it
/// gained and what damping took. Not all of its corners press and slide at every instant, hence 1 %.
TEST(BodyContact, FrictionHoldsAndSlides) {
  const Model floor = tissue({0, 0, -0.005}, {24, 8, 1}), block = tissue({0.0113, 0.0097, 0.001}, {4, 4, 4});
  const Model model = merged({{"floor", &floor}, {"block", &block}});
  const std::vector<Index> own = model.group("block");
  constexpr double g = 9.81, mu = 0.5, rate = 20.0;
  for (const double slope : {0.25, 0.8}) {
    Scene scene = Scene(model).fix("floor").gravity({0, 0, -g}).contacts({.friction = mu});
    const auto solver = make_solver("cpu", model, scene, {}, options_for({"cpu", 1}, rate));
    const double dt = 0.4 * solver->stable_step(), lost = (1.0 - std::exp(-rate * dt)) / dt;  // 1/s
    const auto go = [&](double seconds) { ASSERT_TRUE(solver->step(static_cast<int>(seconds / dt), dt).ok()); };
    const auto place_and_velocity = [&] {
      const State state = solver->read();
      std::pair<Vec3, Vec3> mean{Vec3::Zero(), Vec3::Zero()};
      double mass = 0.0;
      for (const Index i : own) mass += model.mass[i];
      for (const Index i : own) {
        mean.first += model.mass[i] / mass * state.position[i];
        mean.second += model.mass[i] / mass * state.velocity[i];
      }
      return mean;
    };
    go(0.2);
    const double start = place_and_velocity().first.x();
    scene.gravity({slope * g, 0, -g});
    go(0.1);
    const auto [place, velocity] = place_and_velocity();
    const double then = solver->read().time;
    go(0.1);
    const auto [end, end_velocity] = place_and_velocity();
    const Vec3 gained = end_velocity - velocity + lost * (end - place);  // m/s
    if (slope < mu) {
      EXPECT_LT(std::abs(end.x() - start), 0.001);  // m: it shears by itself
    } else {
      const double seconds = solver->read().time - then;
      const double rubbed = slope * g * seconds - gained.x(), pressed = g * seconds + gained.z();
      EXPECT_GT(end.x() - place.x(), 0.003);
      EXPECT_NEAR(rubbed, mu * pressed, 0.01 * mu * pressed);
    }
  }
}

TEST(BodyContact, BitsDoNotDependOnThreads) {
  const Model model = cube_on_slab(0.003);
  State end[2];
  for (int threads : {1, 2}) {
    Scene scene = Scene(model).gravity({0, 0, -9.81}).fix("low/z0").contacts({});
    const auto solver = make_solver("cpu", model, scene, {}, options_for({"cpu", threads}));
    ASSERT_TRUE(solver->step(400, 0.4 * solver->stable_step()).ok());
    end[threads - 1] = solver->read();
  }
  EXPECT_EQ(end[0], end[1]);
}

/// A body that meets no other, at rest and bent, has no contact of its own: its skin is no neighbour to itself, nor is
/// the far side of its surface where a coarser body lets the search reach there.
TEST(BodyContact, ASingleBodyIsAsWithoutContacts) {
  Model fine = tissue({0, 0, 0}, {4, 4, 4}), coarse = moved(make_block({0.06, 0.06, 0.06}, 1, 1, 1), {0, 0, 0.5});
  set_material(coarse, {5e3, 0.3, 1000.0});
  for (const Model& model : {fine, merged({{"fine", &fine}, {"coarse", &coarse}})}) {
    State end[2];
    for (const bool touching : {false, true}) {
      Scene scene = Scene(model).gravity({0, 0, -9.81}).fix(model.has_group("x0") ? "x0" : "fine/x0");
      if (touching) scene.contacts({});
      const auto solver = make_solver("reference", model, scene, {}, options_for({"reference", 0}));
      ASSERT_TRUE(solver->step(300, 0.4 * solver->stable_step()).ok());
      end[touching] = solver->read();
    }
    EXPECT_EQ(end[0], end[1]);
  }
}

/// A wedge as a hexahedron has corners twice, and so triangles of two corners, which would be pushed as two particles.
TEST(BodyContact, TrianglesHaveThreeCorners) {
  Model wedge;
  wedge.rest = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 1}};
  wedge.cells = {{.type = CellType::hexahedron, .particles = {0, 1, 2, 3, 4, 4, 5, 5}}};
  const ContactSurface surface = make_contact_surface(wedge);
  EXPECT_EQ(surface.triangles.size(), 8u);  // of three quads, and two ends
  for (const ContactSurface::Triangle& triangle : surface.triangles) {
    EXPECT_EQ(std::set<Index>(triangle.corner.begin(), triangle.corner.end()).size(), 3u);
  }
  for (const ContactSurface::Particle& particle : surface.particles) EXPECT_GT(particle.edge, 0.9);
}

/// Cells that are listed inside out have their inside where they are all the same.
TEST(BodyContact, TrianglesOfMirroredCellsFaceOutward) {
  Model mirrored = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  for (Vec3& x : mirrored.rest) x.x() = -x.x();
  const ContactSurface surface = make_contact_surface(mirrored);
  EXPECT_EQ(surface.triangles.size(), 48u);
  for (const ContactSurface::Triangle& triangle : surface.triangles) {
    const Vec3 &a = surface.rest[triangle.corner[0]], &b = surface.rest[triangle.corner[1]],
               &c = surface.rest[triangle.corner[2]];
    EXPECT_GT((b - a).cross(c - a).dot((a + b + c) / 3.0 - Vec3(-0.01, 0.01, 0.01)), 0.0);
  }
}

/// A strip of tissue folded over itself: with self the halves stay apart, without they pass through each other.
TEST(BodyContact, ABodyTouchesItself) {
  const Model model = with_material(make_block({0.06, 0.01, 0.005}, 24, 4, 2), {5e3, 0.3, 1000.0});
  const PressedStrip strip(model, 0.012);
  double least[2] = {1e9, 1e9};
  for (const bool self : {false, true}) {
    Scene scene = Scene(model).contacts({.self = self});
    strip.press(scene);
    const auto solver = make_solver("cpu", model, scene, {}, options_for({"cpu", 2}, 10.0));
    const double dt = 0.4 * solver->stable_step();
    for (int k = 0; k < static_cast<int>(0.4 / (40 * dt)); ++k) {
      ASSERT_TRUE(is_ok(solver->step(40, dt)));
      const State state = solver->read();
      for (const Index i : strip.first_end) {
        for (const Index j : strip.last_end) {
          least[self] = std::min(least[self], (state.position[i] - state.position[j]).norm());
        }
      }
    }
  }
  EXPECT_LT(least[0], 0.001);
  EXPECT_GT(least[1], 0.0004);
}

/// Skins in each other, and the cube's bottom in the slab. The parting itself gives no speed, but the surfaces that it
/// pressed in spring back, and without gravity the cube then drifts on.
TEST(BodyContact, AnOverlapAtTheStartGoesGently) {
  for (const double gap : {0.0003, -0.001}) {
    const Model model = cube_on_slab(gap);
    Scene scene = Scene(model).fix("low/z0").contacts({.friction = 0.0});
    const auto solver = make_solver("reference", model, scene, {}, options_for({"reference", 0}, 5.0));
    const double dt = 0.4 * solver->stable_step();
    double fastest = 0.0;
    for (int k = 0; k < 40; ++k) {
      const StepReport report = solver->step(10, dt);
      ASSERT_TRUE(report.ok()) << report.message();
      fastest = std::max(fastest, report.max_speed);
    }
    const double z = lowest(solver->read(), model.group("high"));
    EXPECT_GT(z, 0.0203) << gap;
    EXPECT_LT(z, 0.032) << gap;
    EXPECT_LT(fastest, 0.3) << gap;  // m/s
  }
}

class BodyContactOn : public OnEveryBackend {};
PHYMUL_ON_EVERY_BACKEND(BodyContactOn);

/// Both slide along their common side, and can do nothing about it.
TEST_P(BodyContactOn, AnOverlapOfWhatCannotPartDoesNoHarm) {
  const Model model = stacked(-0.001);
  Scene scene(model);
  scene
      .add({.type = LoadType::translation,
            .particles = every_particle(model),
            .axes = {Axis::free, Axis::free, Axis::held}})
      .contacts({});
  const auto solver = make_solver(GetParam(), model, scene);
  EXPECT_TRUE(is_ok(solver->step(5, 0.5 * solver->stable_step())));
  for (Index i = 0; i < model.particle_count(); ++i) {
    EXPECT_LT((solver->read().position[i] - model.rest[i]).norm(), 1e-9) << i;
  }
}

/// From rest a jaw takes the cube down, past the gap in its first step: the slab is where the cube leaves room.
TEST(BodyContact, WhatAToolSetsGoingIsSeenInThatStep) {
  const Model model = cube_on_slab(0.002);
  const Vec3 middle(0.0313, 0.0321, 0.032), end = middle - Vec3(0, 0, 0.003);
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene = Scene(model).contacts({.friction = 0.0});
    scene.add_tool("jaw", {.shape = Box{{0.0105, 0.0105, 0.0105}}, .pose = {.position = middle}});
    scene.tool("jaw").grasp(0.0);
    const auto solver = make_solver(backend, model, scene, {}, options_for({backend, 1}));
    scene.tool("jaw").move_to({.position = end});
    ASSERT_TRUE(is_ok(solver->step(1, 0.4 * solver->stable_step())));
    const State state = solver->read();
    const double bottom = lowest(state, model.group("high"));
    EXPECT_NEAR(bottom, 0.019, 1e-6) << backend;
    for (const Index i : model.group("low/z1")) {
      const Vec3 off = model.rest[i] - middle;
      if (std::max(std::abs(off.x()), std::abs(off.y())) < 0.01) {
        EXPECT_LT(state.position[i].z(), bottom - 0.0009) << backend;  // m; two skins are 1 mm
      }
    }
  }
}

TEST(BodyContact, RefusesWhatMakesNoSense) {
  const Model model = make_tetrahedron(0.01);
  Scene scene(model);
  EXPECT_TRUE(refuses([&] { scene.contacts({.friction = -1}); }, "coefficient of friction of 0 or more"));
  EXPECT_TRUE(refuses([&] { scene.contacts({.margin = -1}); }, "margin"));
  EXPECT_TRUE(refuses([&] { scene.contacts({.rounds = 0}); }, "1 round"));
  EXPECT_FALSE(scene.contacts());
}

/// A cube passes the tip of a tetrahedron, a millimetre above its level, and stops 3 mm from it. Of the sides of a
/// sharp tip the one that faces a particle most may have it on its inner side.
TEST(BodyContact, ATipTouchesNothingBesideIt) {
  Model spike = make_tetrahedron(0.01);
  spike.rest[3] = {0, 0, 0.02};
  for (int k = 0; k < 3; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / 3.0;
    spike.rest[static_cast<std::size_t>(k)] = {0.003 * std::cos(angle), 0.003 * std::sin(angle), 0.005};
  }
  spike = with_material(std::move(spike), {1e4, 0.4, 1000.0});
  const Model cube = with_material(make_block({0.004, 0.004, 0.004}, 2, 2, 2), {1e4, 0.4, 1000.0});
  for (const double angle : {0.0, std::numbers::pi / 3.0, std::numbers::pi}) {
    const Vec3 from(std::cos(angle), std::sin(angle), 0.0);
    const Model passing = moved(cube, Vec3(-0.002, -0.002, 0.021) + 0.009 * from);
    const Model model = joined_bodies(spike, passing);
    const Scene scene = Scene(model).fix("low").contacts({});
    State state = rest_state(model);
    for (const Index i : model.group("high")) state.velocity[i] = -0.3 * from;
    const auto solver = make_solver("cpu", model, scene, {}, options_for({"cpu", 1}, 0.0));
    solver->reset(state);
    ASSERT_TRUE(is_ok(solver->step(150, 0.0032 / 0.3 / 150)));
    for (const Index i : model.group("high")) {
      EXPECT_LT((solver->read().velocity[i] + 0.3 * from).norm(), 1e-5) << angle;
    }
  }
}

/// A cube passes over a soft one whose surface is folded at random, so that the side which a particle is on turns
/// without a touch. One solver passes over what is apart, the other is given the contacts anew before every step.
TEST(BodyContact, FoldedSurfacesArePassedOverWithTheSameBits) {
  const Model low = with_material(tissue({0, 0, 0}, {6, 6, 2}), {10.0, 0.3, 1000.0});
  const Model model = joined_bodies(low, tissue({0.0063, 0.0071, 0.021}, {2, 2, 2}));
  std::mt19937 bits(3);
  for (int seed = 0; seed < 2; ++seed) {
    State state = rest_state(model);
    for (const Index i : model.group("low")) state.position[i] += touching_spacing * random_vector(bits, 3);
    for (const Index i : model.group("high")) state.velocity[i] = Vec3(0.2, 0.1, -0.1);
    Scene kept_scene = Scene(model).contacts({}), fresh_scene = Scene(model).contacts({});
    const auto kept = make_solver("cpu", model, kept_scene, {}, options_for({"cpu", 1}));
    const auto fresh = make_solver("cpu", model, fresh_scene, {}, options_for({"cpu", 1}));
    kept->reset(state);
    fresh->reset(state);
    const double dt = 0.2 * kept->stable_step();
    for (int step = 0; step < 60; ++step) {
      fresh_scene.contacts({});
      kept->step(1, dt);
      fresh->step(1, dt);
      ASSERT_EQ(kept->read(), fresh->read()) << seed << ", " << step;
    }
  }
}

}  // namespace
}  // namespace phymul
