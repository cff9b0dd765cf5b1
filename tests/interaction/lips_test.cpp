// SPDX-License-Identifier: MIT
//
// The faces of a cut under Scene::contacts: they carry pressure and friction as the tissue did, and no tension. Sewn
// threads keep their length where knots are tied and loosened, and where no passage is left.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "interaction/contact_surface.h"
#include "support/bodies.h"
#include "support/cut_bodies.h"
#include "support/every_backend.h"
#include "support/joined_particles.h"

namespace phymul {
namespace {

using namespace test;

enum class Lips { whole, cut, touching };

Model bar() {
  Model model = make_tetrahedral_block({0.02, 0.02, 0.06}, 5, 5, 15, 0.25, 7);
  set_material(model, {1e4, 0.3, 1000.0});
  return model;
}

/// Across the bar, a little oblique; `to_x`, m: up to there.
CutSurface across(double to_x, double height = 0.031, const Vec3& normal = {0.1, 0.15, 1.0}) {
  CutSurface cut = cut_plane({0.01, 0.01, height}, normal);
  if (to_x < 0.02) cut.front = [to_x](const Vec3& x) { return x.x() - to_x; };
  return cut;
}

/// N, on the top that has moved by `by`, m, after the bar has come to rest.
Vec3 force_on_top(const CutSurface& cut, Lips lips, const Vec3& by, double friction = 0.0) {
  const Model whole = bar();
  const Model model = lips == Lips::whole ? whole : cut_body(whole, cut);
  SimulationOptions options;
  options.backend = "cpu";
  options.damping.rate = 60.0;
  Simulation sim(model, options);
  sim.scene().fix("z0").add({.type = LoadType::translation,
                             .particles = model.group("z1"),
                             .events = {{0.0, 0.0}, {0.2, by.norm()}},
                             .direction = by});
  if (lips == Lips::touching) sim.scene().contacts({.friction = friction});
  const StepReport report = sim.advance(0.6);
  EXPECT_TRUE(report.ok()) << report.message();
  const VecList force = forces_at(sim.solver().topology(), sim.solver().read().position);
  Vec3 sum = Vec3::Zero();
  for (const Index i : model.group("z1")) sum -= force[i];
  return sum;
}

TEST(Lips, CarryPressureAsTheTissueDid) {
  const Vec3 down(0, 0, -2e-3);
  const CutSurface oblique = across(1.0, 0.031, {0.5, 0.0, 1.0});
  const double whole = force_on_top(oblique, Lips::whole, down).z();
  EXPECT_NEAR(force_on_top(oblique, Lips::cut, down).z(), 0.0, 1e-3 * std::abs(whole));
  EXPECT_NEAR(force_on_top(oblique, Lips::touching, down, 1.0).z(), whole, 0.02 * std::abs(whole));
  // Without friction the upper part slides down the face.
  EXPECT_NEAR(force_on_top(oblique, Lips::touching, down).z() / whole, 0.75, 0.05);
  EXPECT_NEAR(force_on_top(oblique, Lips::touching, -down).z(), 0.0, 1e-3 * std::abs(whole));
}

/// Bent to one side a bar that is cut half through is whole, to the other it is cut.
TEST(Lips, OpenFreelyAndClose) {
  const CutSurface half = across(0.012, 0.0113);
  const Vec3 opening(6e-3, 0, 0), closing(-6e-3, 0, 0);
  const double whole = force_on_top(half, Lips::whole, closing).x();
  EXPECT_GT(force_on_top(half, Lips::cut, closing).x(), 0.9 * whole);
  EXPECT_NEAR(force_on_top(half, Lips::touching, closing).x(), whole, 0.03 * std::abs(whole));
  const double open = force_on_top(half, Lips::cut, opening).x();
  EXPECT_LT(open, 0.7 * std::abs(whole));
  EXPECT_NEAR(force_on_top(half, Lips::touching, opening).x(), open, 1e-4 * open);
}

/// At rest they lie on each other, without a gap and without a force.
TEST(Lips, LeaveABodyAtRestInPeace) {
  for (const double to_x : {0.012, 1.0}) {
    const Model model = cut_body(bar(), across(to_x));
    Scene scene = Scene(model).fix("z0").fix("z1").contacts({.friction = 0.5});
    const auto solver = make_solver("reference", model, scene, {});
    ASSERT_TRUE(solver->step(200, 0.5 * solver->stable_step()).ok());
    const State end = solver->read();
    double moved = 0.0;
    for (std::size_t i = 0; i < model.rest.size(); ++i) {
      moved = std::max(moved, (end.position[i] - model.rest[i]).norm());
    }
    EXPECT_LT(moved, 1e-9);  // m
  }
}

/// Where a cut ends its points are on both faces, and touch neither.
TEST(Lips, AreNoneAtTheFront) {
  int at_front = 0;
  for (const double to_x : {0.006, 0.01, 0.012, 0.016}) {
    const Model model = cut_body(bar(), across(to_x));
    const ContactSurface surface = make_contact_surface(model);
    std::vector<std::array<bool, 2>> faces(surface.particles.size(), {false, false});  // above and below
    for (const ContactSurface::Triangle& triangle : surface.triangles) {
      if (!triangle.of_cut) continue;
      const Vec3 &a = surface.rest[triangle.corner[0]], &b = surface.rest[triangle.corner[1]],
                 &c = surface.rest[triangle.corner[2]];
      for (const Index k : triangle.corner) faces[k][(b - a).cross(c - a).z() > 0.0] = true;
    }
    for (std::size_t k = 0; k < faces.size(); ++k) {
      if (!faces[k][0] || !faces[k][1]) continue;
      ++at_front;
      for (const ContactSurface::Triangle& triangle : surface.triangles) {
        EXPECT_FALSE(surface.are_lips(surface.particles[k], k, triangle)) << surface.particles[k].normal.transpose();
      }
    }
  }
  EXPECT_GT(at_front, 20);
}

/// Points of one face meet triangles of the other one; the faces of a strip between two cuts do not meet through it.
TEST(Lips, AreTheTwoFacesOfOneCut) {
  const double thickness = 1.6e-3;  // m; particles nearer than 0.4 mm to a cut are taken to lie on it
  Model model = cut_body(bar(), cut_plane({0.01, 0.01, 0.0310}, {0, 0, 1}));
  model = cut_body(std::move(model), cut_plane({0.01, 0.01, 0.0310 + thickness}, {0, 0, 1}));
  const ContactSurface surface = make_contact_surface(model);
  int met = 0, of_cuts = 0;
  for (std::size_t k = 0; k < surface.particles.size(); ++k) {
    const ContactSurface::Particle& own = surface.particles[k];
    if (!own.of_cut) continue;
    ++of_cuts;
    bool meets = false;
    for (const ContactSurface::Triangle& triangle : surface.triangles) {
      const Vec3& corner = surface.rest[triangle.corner[0]];
      if ((corner - surface.rest[k]).norm() > 5e-3 || !surface.are_lips(own, k, triangle)) continue;
      EXPECT_NE(own.body, triangle.body);
      if (std::abs(corner.z() - surface.rest[k].z()) < 0.6e-3) meets = true;
    }
    met += meets ? 1 : 0;
  }
  EXPECT_GT(of_cuts, 100);
  EXPECT_EQ(met, of_cuts);
}

/// Nor have other surfaces of bodies with cuts, between each other, but for walls: as far as they are apart at rest.
TEST(Lips, HaveNoSkin) {
  ContactSurface surface;
  surface.rest = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {1, 1, 0.1}};
  const ContactSurface::Particle cut{.body = 0, .edge = 2.0}, whole{.body = 1, .edge = 2.0};
  const ContactSurface::Triangle triangle{.corner = {0, 1, 2}, .body = 0, .edge = 3.0, .has_inside = true};
  ContactSurface::Triangle wall = triangle;
  wall.has_inside = false;
  EXPECT_DOUBLE_EQ(surface.skins(cut, 3, triangle, 0.0), 0.5);
  EXPECT_DOUBLE_EQ(surface.skins(cut, 3, triangle, 0.2), 0.4);
  surface.is_cut = {1, 0};
  EXPECT_EQ(surface.skins(cut, 3, triangle, 0.0), 0.0);
  EXPECT_EQ(surface.skins(cut, 3, triangle, 0.2), 0.0);
  EXPECT_DOUBLE_EQ(surface.skins(cut, 3, wall, 0.0), 0.1);
  EXPECT_DOUBLE_EQ(surface.skins(cut, 3, wall, 0.04), 0.08);
  EXPECT_DOUBLE_EQ(surface.skins(whole, 3, triangle, 0.0), 0.5);
}

/// A freed piece touches the organ that it came from, rim and cut faces included.
TEST(Lips, OfAPieceTouchTheOutside) {
  const Model model = cut_body(bar(), cut_plane({0.01, 0.01, 0.031}, {0, 0, 1}));
  const ContactSurface surface = make_contact_surface(model);
  for (std::size_t k = 0; k < surface.particles.size(); ++k) {
    const ContactSurface::Particle& own = surface.particles[k];
    if (!own.of_cut) continue;
    for (const ContactSurface::Triangle& triangle : surface.triangles) {
      if (triangle.body == own.body || triangle.of_cut) continue;
      const auto is_far = [&](Index corner) {  // m; edges are 4 to 7 mm
        return (surface.rest[corner] - surface.rest[k]).norm() > 0.006;
      };
      if (!std::ranges::all_of(triangle.corner, is_far)) continue;
      EXPECT_FALSE(surface.is_own_skin(own, k, triangle));
    }
  }
}

using LipsOn = OnEveryBackend;

/// A bar cut in a running simulation, and pressed; `off`, m: of its particles at the start.
State pressed_bar(const std::string& backend, double off) {
  SimulationOptions options;
  options.backend = backend;
  options.damping.rate = 20.0;
  Simulation sim(with_spare_particles(bar(), 200), options);
  const Load down{.type = LoadType::translation,
                  .particles = sim.model().group("z1"),
                  .events = {{0.0, 0.0}, {0.02, 2e-3}},
                  .direction = {0, 0, -1}};
  sim.scene().fix("z0").contacts({.friction = 0.3}).add(down);
  const double dt = 0.4 * sim.solver().stable_step();
  State start = sim.solver().read();
  for (std::size_t i = 0; i < start.position.size(); i += 2) start.position[i].x() += off;
  sim.unrecorded_solver().reset(start);
  EXPECT_TRUE(sim.step(5, dt).ok());
  EXPECT_TRUE(sim.cut(across(1.0)));
  EXPECT_TRUE(sim.step(static_cast<int>(0.02 / dt), dt).ok());
  return sim.solver().read();
}

double largest_apart(const State& a, const State& b) {
  double apart = 0.0;
  for (std::size_t i = 0; i < a.position.size(); ++i) {
    apart = std::max(apart, (a.position[i] - b.position[i]).norm());
  }
  return apart;
}

/// Where points lie on edges of triangles, as all of two lips do, rounding chooses the triangle. So the bound is what
/// a thousandth of a micrometre at the start changes of the reference itself.
TEST_P(LipsOn, MoveAsOnTheReference) {
  const State reference = pressed_bar("reference", 0.0);
  const double sensitivity = largest_apart(pressed_bar("reference", 1e-9), reference);
  EXPECT_LT(largest_apart(pressed_bar(GetParam(), 0.0), reference), 3.0 * sensitivity);
  EXPECT_LT(sensitivity, 2e-5);  // m, of 2 mm
}

PHYMUL_ON_EVERY_BACKEND(LipsOn);

/// Pieces between two planes that cross are as they were at rest, however sharp they are.
TEST(Lips, CrossingCutsStayAtRest) {
  for (const unsigned seed : {1u, 3u}) {
    std::mt19937 bits(seed);
    const auto any = [&] { return 2.0 * static_cast<double>(bits()) / 4294967296.0 - 1.0; };
    for (int pair = 0; pair < 12; ++pair) {
      Model model = with_material(slab(), {5e3, 0.4, 1000.0});
      for (int plane = 0; plane < 2; ++plane) {
        const double x = any(), y = any(), z = any(), a = any(), b = any(), c = any();
        model = cut_body(model, cut_plane({0.03 + 0.015 * x, 0.02 + 0.01 * y, 0.015 + 0.005 * z}, {a, b, 0.5 * c}));
      }
      Simulation sim(model, {.backend = "cpu"});
      sim.scene().contacts({});
      ASSERT_TRUE(sim.advance(0.01).ok());
      EXPECT_LT(sim.max_displacement(), 1e-12) << seed << ' ' << pair;
    }
  }
}

/// m, of all its segments and knots.
double whole_length(const Zigzag& body) {
  double sum = body.length();
  for (const KnotState& knot : body.state().knots) sum += knot.rest_length;
  return sum;
}

double way_through(int passages) {
  const VecList places = Zigzag::places(passages);
  double way = 0.0;
  for (std::size_t k = 1; k < places.size(); ++k) way += (places[k] - places[k - 1]).norm();
  return way;
}

TEST(StitchLength, AKnotThatIsLoosenedMakesNoThread) {
  const double way = way_through(5);
  for (const double tails : {0.0, 0.01, 0.1}) {
    SCOPED_TRACE(tails);
    Zigzag body({.length = way + tails});
    body.run(1);
    body.thread->tie(0, 3, 2);
    body.run(1);
    body.thread->loosen(0, 3);
    body.run(1);
    EXPECT_NEAR(whole_length(body), way + tails, 1e-12);
  }
}

/// One tail is drawn short before: the other has what the knot takes.
TEST(StitchLength, AKnotTakesFromTheTailThatHasMore) {
  const double way = way_through(5);
  Zigzag body({.length = way + 0.1, .friction = 0.0});
  body.thread->fix(ThreadTip::first);
  body.run(1);
  body.thread->join(ThreadTip::first, at_world(Zigzag::places(1)[0] + Vec3(-0.05, 0, 0)));
  body.run(1);
  const double before = whole_length(body);
  body.thread->tie(0, 3, 2);
  body.run(1);
  ASSERT_EQ(body.state().knots.size(), 1u);
  EXPECT_GT(body.state().knots[0].rest_length, 0.01);
  EXPECT_NEAR(whole_length(body), before, 1e-12);
  body.thread->loosen(0, 3);
  body.run(1);
  EXPECT_NEAR(whole_length(body), before, 1e-12);
}

/// Both ends of a knot bear the same force: both passages let go at once.
TEST(StitchLength, AKnotBreaksWithThePassagesThatItTies) {
  const Model model = loose_particles({Vec3(0, 0, 0), Vec3(0.006, 0, 0)}, 1e-3);
  Scene scene(model);
  scene.fix(std::vector<Index>{0});
  scene.add(Load{.type = LoadType::force, .particles = {1}, .events = {{0.0, 1.5}}, .direction = {1, 0, 0}});
  const ThreadHandle thread = scene.sew("s", {.length = 0.05, .passage_limit = 1.0, .throw_holding = 100},
                                        std::vector<Anchor>{at_particle(0), at_particle(1)});
  for (const ThreadTip tip : {ThreadTip::first, ThreadTip::last}) thread.pull(tip, Vec3::Zero());
  thread.tie(0, 1, 4);
  const auto solver = loose_solver("reference", model, scene, {.damping = {.rate = 50.0}});
  ASSERT_TRUE(solver->step(400, 0.5e-3).ok());
  const ThreadState& end = solver->thread_state(thread);
  ASSERT_EQ(end.torn, 2);
  ASSERT_EQ(end.knots.size(), 1u);
  EXPECT_TRUE(end.knots[0].broken);
  EXPECT_EQ(end.knots[0].tension, 0.0);
}

TEST(StitchLength, AThreadWithoutPassagesKeepsItsLengthWhenATipIsJoined) {
  Zigzag body({.length = 0.1, .friction = 0.05}, 4);
  body.scene.add_tool("hand", {.shape = Sphere{1e-3}, .pose = {.position = {0.04, 0.02, 0}}});
  body.thread->pull(ThreadTip::first, {0, 0, 0});
  body.thread->join(ThreadTip::last, at_tool("hand"));
  body.run(1);
  body.scene.tool("hand").move_to({.position = {0.2, 0.02, 0}});
  body.run(400);
  ASSERT_TRUE(body.state().passages.empty());
  body.thread->pull(ThreadTip::last, {0, 0, 0});
  body.run(1);
  const double before = body.length();
  body.thread->join(ThreadTip::last, at_world({0.5, 0, 0}));
  body.run(1);
  EXPECT_NEAR(body.length(), before, 1e-12);
}

}  // namespace
}  // namespace phymul
