// SPDX-License-Identifier: MIT
//
// Bodies that touch each other, and themselves, on the GL backends: against the double reference step by step and over
// whole motions, and what contact is to do.
#include <cmath>

#include "model/closed_surface.h"
#include "support/gl_bodies.h"

namespace phymul::test {
namespace {

class GlBodyContact : public OnBothDevices {};

PHYMUL_ON_BOTH_DEVICES(GlBodyContact);

/// Of gl-compute alone: the host's contacts are tested in tests/interaction.
using GlContactMotion = OnCompute;

/// A cube that falls and slides on a slab, also 1.4 km from the origin.
TEST_P(GlBodyContact, AgreesWithTheReference) {
  double worst = 0.0, worst_step = 0.0;
  for (const Vec3& origin : {Vec3(0, 0, 0), Vec3(800, -600, 1000)}) {
    const Model model = stacked(0.0012, origin);
    Scene scene = Scene(model).gravity({3.0, 1.0, -9.81}).fix("low/z0").contacts({.friction = 0.2});
    BesideReference pair(model, scene, damped(5.0), GetParam());
    double pushed = 0.0;
    for (int call = 0; call < 12; ++call) worst = std::max(worst, pair.off_after(10));
    for (int step = 0; step < 10; ++step) {
      const auto [off, change] = pair.one_step();
      worst_step = std::max(worst_step, off);
      pushed = std::max(pushed, change);
    }
    EXPECT_GT(pushed, 1e-3);
    EXPECT_GT(lowest(pair.reference->read(), model.group("high")),
              lowest(rest_state(model), model.group("low")) + 0.009);
  }
  std::printf("[ CONTACT  ] off the reference by at most %.2g of the motion; a step by %.2g of 2^-24 of a way a step\n",
              worst, worst_step);
  EXPECT_LE(worst, 1e-5);
  EXPECT_LE(worst_step, 20.0);
}

/// What one body loses the other gains, at every step, in floats' rounding of what moves.
TEST_P(GlBodyContact, MomentumIsKeptToRounding) {
  const Model model = stacked(0.0005);
  for (const double friction : {0.0, 0.6}) {
    Scene scene = Scene(model).contacts({.friction = friction});
    BesideReference pair(model, scene, uncut(), GetParam());
    State state = rest_state(model);
    double scale = 0.0;
    for (const Index i : model.group("high")) state.velocity[i] = Vec3(0.3, 0.2, -1.0);
    for (Index i = 0; i < model.particle_count(); ++i) scale += model.mass[i] * state.velocity[i].norm();
    pair.device->reset(state);
    const Momentum start = pair.device->momentum();
    double worst = 0.0;
    for (int k = 0; k < 30; ++k) {
      ASSERT_TRUE(pair.device->step(5, 0.25 * pair.dt).ok());
      worst = std::max(worst, (pair.device->momentum().linear - start.linear).norm() / (5 * (k + 1) * 0x1p-24 * scale));
    }
    double given = 0.0;
    const State end = pair.device->read();
    for (const Index i : model.group("low")) given += model.mass[i] * end.velocity[i].z();
    EXPECT_LT(given, -0.1 * scale);  // they met
    std::printf("[ CONTACT  ] momentum off by at most %.2g of 2^-24 of what moves, a step\n", worst);
    EXPECT_LE(worst, 4.0);
  }
}

TEST_F(GlContactMotion, ABodyDroppedOnAnotherStaysOnIt) {
  const Model model = stacked(0.004);
  Scene scene = Scene(model).gravity({0, 0, -9.81}).fix("low/z0").contacts({.friction = 0.5});
  const BesideReference pair(model, scene, damped(40.0));
  const std::vector<Index> high = model.group("high"), low = model.group("low");
  double deepest = 1e9;
  for (int k = 0; k < static_cast<int>(0.3 / (20 * pair.dt)); ++k) {
    ASSERT_TRUE(pair.device->step(20, pair.dt).ok());
    deepest = std::min(deepest, lowest(pair.device->read(), high));
  }
  const State end = pair.device->read();
  EXPECT_GT(deepest, 0.007);  // m: in the slab's upper half at all times
  EXPECT_GT(mean_place(end, high).z(), mean_place(end, low).z() + 0.007);
  EXPECT_LT(mean_place(end, high).z(), mean_place(end, low).z() + 0.012);
  Vec3 speed = Vec3::Zero();
  for (const Index i : high) speed += end.velocity[i] / static_cast<double>(high.size());
  EXPECT_LT(speed.norm(), 0.01);
}

/// Under gravity that leans: beyond the angle of friction it slides as Coulomb's law says, below it stays.
TEST_F(GlContactMotion, FrictionHoldsAndSlides) {
  const Model model = joined_bodies(tissue({0, 0, -0.005}, {12, 4, 1}), tissue({0.0073, 0.0047, 0.001}, {2, 2, 2}));
  constexpr double g = 9.81, mu = 0.5, rate = 30.0, seconds = 0.12;
  for (const double slope : {0.25, 0.8}) {
    Scene scene = Scene(model).fix("low").gravity({0, 0, -g}).contacts({.friction = mu});
    const BesideReference pair(model, scene, damped(rate));
    ASSERT_TRUE(pair.device->step(static_cast<int>(0.12 / pair.dt), pair.dt).ok());
    const double start = mean_place(pair.device->read(), model.group("high")).x();
    scene.gravity({slope * g, 0, -g});
    ASSERT_TRUE(pair.device->step(static_cast<int>(seconds / pair.dt), pair.dt).ok());
    const double way = mean_place(pair.device->read(), model.group("high")).x() - start;
    const double free = (slope - mu) * g / rate * (seconds - (1.0 - std::exp(-rate * seconds)) / rate);
    if (slope < mu) {
      EXPECT_LT(std::abs(way), 0.0005);  // it shears by itself
    } else {
      EXPECT_NEAR(way, free, 0.15 * free);
    }
  }
}

/// A strip whose ends are pressed together above its middle: with `self` they stay apart, as on the reference.
TEST_F(GlContactMotion, ABodyTouchesItself) {
  const Model model = long_strip();
  const PressedStrip strip(model, 0.016);
  double apart[2] = {0.0, 0.0}, off = 0.0;  // m, of the ends along x
  for (const bool self : {false, true}) {
    Scene scene = Scene(model).contacts({.self = self});
    strip.press(scene);
    BesideReference pair(model, scene, damped(10.0));
    for (int k = 0; k < 14; ++k) {
      ASSERT_TRUE(pair.device->step(14, pair.dt).ok());
      if (self) off = std::max(off, pair.one_step().off);
    }
    const State end = pair.device->read();
    apart[self] = mean_place(end, strip.last_end).x() - mean_place(end, strip.first_end).x();
  }
  std::printf("[ CONTACT  ] with itself: ends apart by %.2g m, without contact %.2g m; a step off by %.2g\n", apart[1],
              apart[0], off);
  EXPECT_LT(apart[0], -0.005);  // they went through each other
  EXPECT_GT(apart[1], 0.004);   // the thickness is 0.005
  EXPECT_LE(off, 20.0);
}

/// Many bodies, each on two others, many cells apart from each other in pairs.
TEST_P(GlBodyContact, ManyBodiesAgreeWithTheReference) {
  std::vector<Model> parts;
  for (int k = 0; k < 4; ++k) {
    const Vec3 at(0.3 * k, 0.1 * k, 0);
    parts.push_back(tissue(at, {2, 2, 1}));
    parts.push_back(tissue(at + Vec3(0.0113, 0.0007, 0), {2, 2, 1}));
    parts.push_back(tissue(at + Vec3(0.006, 0.0012, 0.0057), {2, 1, 1}));
  }
  std::vector<NamedBody> named;
  for (const Model& part : parts) named.push_back({"b" + std::to_string(named.size()), &part});
  const Model model = merge_models(named);
  Scene scene = Scene(model).gravity({0.5, 0.2, -9.81}).contacts({.friction = 0.4});
  for (int k = 0; k < 12; ++k) {
    if (k % 3 != 2) scene.fix("b" + std::to_string(k) + "/z0");
  }
  BesideReference pair(model, scene, damped(10.0), GetParam());
  double worst = 0.0;
  for (int k = 0; k < 6; ++k) worst = std::max(worst, pair.off_after(20));
  for (int k = 2; k < 12; k += 3) {
    EXPECT_GT(lowest(pair.device->read(), model.group("b" + std::to_string(k))), 0.0045);
  }
  std::printf("[ CONTACT  ] twelve bodies: off by %.2g of the motion\n", worst);
  EXPECT_LE(worst, 1e-5);
}

/// Hundreds of particles on one triangle press one after another, further than a dispatch of this renderer goes.
TEST_P(GlBodyContact, ALongChainOfContactsIsPressedToItsEnd) {
  const Material soft{5e3, 0.3, 1000.0};
  const Model floor = with_material(make_block({0.06, 0.06, 0.03}, 1, 1, 1), soft),
              sheet = with_material(make_block({0.05, 0.05, 0.003}, 16, 16, 1), soft);
  const Model model = joined_bodies(floor, moved(sheet, {0.005, 0.0045, 0.0306}));
  Scene scene = Scene(model).fix("low/z0").contacts({.friction = 0.3, .margin = 0.0004});
  BesideReference pair(model, scene, damped(5.0), GetParam());
  State falling = rest_state(model);
  for (const Index i : model.group("high")) falling.velocity[i] = Vec3(0.02, 0.01, -0.05);
  pair.device->reset(falling);
  double worst = 0.0, pushed = 0.0;
  for (int k = 0; k < 3; ++k) {
    const auto [off, change] = pair.one_step();
    worst = std::max(worst, off);
    pushed = std::max(pushed, change);
  }
  EXPECT_GT(pushed, 0.04);
  std::printf("[ CONTACT  ] a chain: a step off by %.2g of 2^-24 of a way a step\n", worst);
  EXPECT_LE(worst, 20.0);
}

/// From rest a jaw takes the cube down, past the gap in its first step: the slab gives way in that step.
TEST_P(GlBodyContact, WhatAToolSetsGoingIsSeenInThatStep) {
  const Model model = stacked(0.002);
  const Vec3 middle(0.0122, 0.0131, 0.017);
  Scene scene = Scene(model).contacts({.friction = 0.0});
  scene.add_tool("jaw", {.shape = Box{{0.0055, 0.0055, 0.0055}}, .pose = {.position = middle}});
  scene.tool("jaw").grasp(0.0);
  BesideReference pair(model, scene, damped(5.0), GetParam());
  scene.tool("jaw").move_to({.position = middle - Vec3(0, 0, 0.003)});
  EXPECT_LE(pair.off_after(1), 1e-5);
  double deepest = 0.0;
  const State end = pair.device->read();
  for (const Index i : model.group("low")) deepest = std::min(deepest, (end.position[i] - model.rest[i]).z());
  EXPECT_LT(deepest, -0.001);
}

/// What is deeper than the longer edge of the two is in no body, and no coarse side behind leads it out.
TEST_P(GlBodyContact, InsideIsAsDeepAsTheLongerEdgeOfTheTwo) {
  const Model big = make_block({0.04, 0.02, 0.02}, 2, 4, 4);  // edges of 5 mm across x, else of 20 mm
  for (const double below : {0.003, 0.0065, 0.012}) {
    const Model small = moved(make_block({0.001, 0.001, 0.001}, 1, 1, 1), {0.039 - below, 0.011, 0.0095});
    const Model model = joined_bodies(big, small);
    Scene scene = Scene(model).contacts({.margin = 1e-4});
    BesideReference pair(model, scene, damped(5.0), GetParam());
    if (below == 0.0065) {
      ASSERT_TRUE(pair.device->step(1, pair.dt).ok());
      EXPECT_EQ(pair.device->read().position, model.rest);
      continue;
    }
    EXPECT_LE(pair.off_after(1), 1e-3) << below;
    const Vec3 way =
        mean_place(pair.device->read(), model.group("high")) - mean_place(rest_state(model), model.group("high"));
    EXPECT_GT(below < 0.006 ? way.x() : way.y(), 1e-7) << way.transpose();
  }
}

/// A particle is nearest to a corner, which floats place to 1e-10 m. By that much two triangles there rank alike, of
/// other edges and so of other margins: the one that faces the particle more is met.
TEST_P(GlBodyContact, OfTrianglesAtACornerTheOneThatFacesMoreIsMet) {
  const Model low = make_tetrahedral_block({0.025, 0.025, 0.01}, 4, 4, 2, 0.2, 7);
  const Model high = moved(make_tetrahedral_block({0.01, 0.01, 0.01}, 2, 2, 2, 0.2, 3), {0.0072, 0.0081, 0.0104});
  const Model model = joined_bodies(with_material(low), with_material(high));
  Scene scene = Scene(model).contacts({.friction = 0.3});
  const BesideReference pair(model, scene, damped(5.0), GetParam());
  State state = rest_state(model);
  const Vec3 corner = model.rest[model.group("high").front()];
  const Quaternion turn(Eigen::AngleAxisd(0.085448, Vec3::UnitZ()) * Eigen::AngleAxisd(-0.055189, Vec3::UnitX()));
  for (const Index i : model.group("high")) {
    state.position[i] = corner + turn * (model.rest[i] - corner) + Vec3(0.000626, 0.000798, 0.0006);
  }
  pair.device->reset(state);
  pair.reference->reset(state);
  ASSERT_TRUE(all_step(1, pair.dt, pair.device, pair.reference));
  const State a = pair.device->read(), b = pair.reference->read();
  EXPECT_GT(largest_distance(b.position, state.position), 1e-5) << "they overlap, and part";
  EXPECT_LE(largest_distance(a.position, b.position), 1e-8);
}

/// What a tool holds no contact moves: it presses the slab. What another tool pushes rubs on it.
TEST_P(GlBodyContact, ToolsAndContactsActInOneStep) {
  const Model model = stacked(0.0012);
  Scene scene = Scene(model).fix("low/z0").contacts({.friction = 0.3});
  scene.add_tool("jaw", {.shape = Box{{0.006, 0.006, 0.001}}, .pose = {.position = {0.0122, 0.0131, 0.0222}}});
  scene.add_tool("ball", {.shape = Sphere{0.004}, .pose = {.position = {-0.0045, 0.01, 0.005}}, .friction = 0.3});
  scene.tool("jaw").grasp(0.0105);  // all of the cube, and nothing below it
  BesideReference pair(model, scene, damped(10.0), GetParam());
  double worst = 0.0, deepest = 0.0;
  for (int k = 0; k < 8; ++k) {
    scene.tool("jaw").move_to({.position = {0.0122, 0.0131, 0.0222 - 2e-4 * k}});
    scene.tool("ball").move_to({.position = {-0.0045 + 2e-4 * k, 0.01, 0.005}});
    const double off = pair.off_after(12);
    if (k > 0) worst = std::max(worst, off);  // in the first call nothing moves
    const ToolForce a = pair.device->tool_force("jaw"), b = pair.reference->tool_force("jaw");
    EXPECT_LE((a.mean_force - b.mean_force).norm(), 1e-3 * std::max(b.mean_force.norm(), 0.01)) << k;
  }
  // Held particles go where the jaw goes, so the slab's top is what the cube pressed in.
  const State end = pair.device->read();
  for (const Index i : model.group("high")) EXPECT_NEAR((end.position[i] - model.rest[i]).z(), -1.4e-3, 1e-6);
  for (const Index i : model.group("low")) deepest = std::min(deepest, (end.position[i] - model.rest[i]).z());
  EXPECT_LT(deepest, -5e-4);
  EXPECT_EQ(pair.device->tool_force("jaw").particles, 27);
  EXPECT_GT(pair.reference->tool_force("ball").particles, 0);
  EXPECT_EQ(pair.device->tool_force("jaw").particles, pair.reference->tool_force("jaw").particles);
  std::printf("[ CONTACT  ] with tools: off by %.2g of the motion\n", worst);
  EXPECT_LE(worst, 1e-5);
}

/// Contacts come first, then volumes: what a tool holds (the upper layers of the cube) no volume moves either.
TEST_P(GlBodyContact, VolumesAreKeptAfterContacts) {
  const Model model = stacked(0.0012);
  Scene scene = Scene(model).fix("low/z0").contacts({.friction = 0.3}).constrain_volume("low").constrain_volume("high");
  scene.add_tool("jaw", {.shape = Box{{0.006, 0.006, 0.001}}, .pose = {.position = {0.0122, 0.0131, 0.0222}}});
  scene.tool("jaw").grasp(0.006);
  BesideReference pair(model, scene, damped(10.0), GetParam());
  double worst = 0.0;
  for (int k = 0; k < 8; ++k) {
    scene.tool("jaw").move_to({.position = {0.0122, 0.0131, 0.0222 - 2e-4 * k}});
    const double off = pair.off_after(12);
    if (k > 0) worst = std::max(worst, off);
    const State state = pair.device->read();
    for (const VolumeConstraint& kept : scene.volume_constraints()) {
      EXPECT_NEAR(enclosed_volume(kept.triangles, state.position) / kept.volume, 1.0, 1e-6) << kept.applied_to;
    }
  }
  const State end = pair.device->read();
  double deepest = 0.0;
  for (const Index i : model.group("low")) deepest = std::min(deepest, (end.position[i] - model.rest[i]).z());
  EXPECT_LT(deepest, -1e-4);
  EXPECT_GT(pair.device->tool_force("jaw").particles, 0);
  EXPECT_LT(pair.device->tool_force("jaw").particles, 27);
  for (const Index i : end.tools[0].held) EXPECT_NEAR((end.position[i] - model.rest[i]).z(), -1.4e-3, 1e-6);
  std::printf("[ CONTACT  ] with kept volumes: off by %.2g of the motion\n", worst);
  EXPECT_LE(worst, 1e-5);
}

}  // namespace
}  // namespace phymul::test
