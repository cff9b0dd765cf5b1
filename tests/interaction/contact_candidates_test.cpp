// SPDX-License-Identifier: MIT
//
// Candidates of contacts that are kept over steps: nothing that counts is missing, and no bit differs from a search at
// every step.
#include <gtest/gtest.h>

#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>

#include "interaction/contact_candidates.h"
#include "support/allocation_count.h"
#include "support/run_scenes.h"
#include "support/sanitized.h"
#include "support/touching_bodies.h"

namespace phymul {
namespace {

using namespace test;

/// A cube over a larger one, a gap above it and off its lattice.
Model two_cubes(double gap) {
  return joined_bodies(tissue({0, 0, 0}, {6, 6, 6}), tissue({0.0063, 0.0071, 0.03 + gap}, {4, 4, 4}));
}

/// Random affine motions of either body, small ones step by step and a jump now and then, particles shaken besides.
TEST(ContactCandidates, MissNothingWhileTheyAreKept) {
  const Model model = two_cubes(0.002);
  const ContactSurface surface = make_contact_surface(model);
  std::mt19937 bits(11);
  for (const ContactOptions& options :
       {ContactOptions{}, ContactOptions{.margin = 0.002}, ContactOptions{.self = false}}) {
    ContactCandidates candidates;
    candidates.follow(surface, options);
    std::size_t counting = 0, steps = 0;
    for (int scene = 0; scene < 6; ++scene) {
      VecList place = surface.rest;
      const double shake = scene % 2 == 0 ? 2e-5 : 4e-4, far = scene == 5 ? 1400.0 : 0.0;  // m a step, m
      Mat3 squeeze[2];
      for (Mat3& own : squeeze) {
        for (int a = 0; a < 3; ++a) own.col(a) = 0.003 * random_vector(bits, 3);
      }
      const Vec3 fall = 1e-4 * random_vector(bits, 3) + Vec3(0, 0, -1e-4);
      for (int step = 0; step < 25; ++step, ++steps) {
        for (std::size_t k = 0; k < place.size(); ++k) {
          const Index body = surface.particles[k].body;
          place[k] += squeeze[body] * (surface.rest[k] - Vec3::Constant(0.015)) + shake * random_vector(bits, 3);
          if (body == 1) place[k] += fall;
          if (step == 12) place[k].x() += far;
        }
        const double margin = (1.0 + uniform(bits)) * 4.0 * shake;
        const Pairs wanted = pairs_that_count(surface, place, options, margin);
        const Pairs listed = pairs_listed(candidates, place, margin);
        counting += wanted.size();
        for (const auto& pair : wanted) ASSERT_TRUE(listed.contains(pair)) << scene << ", step " << step;
      }
    }
    EXPECT_GT(counting, 3000u);
    EXPECT_LT(candidates.searches(), steps * 2 / 3);  // kept for some time
  }
}

/// A bar with a cut is turned and rolled up until its ends meet: what nears there, and the faces of the cut, are in no
/// skin, whatever has moved little against each other.
TEST(ContactCandidates, MissNothingOfABodyThatIsCutAndRolledUp) {
  constexpr double length = 0.12;  // m
  Model bar = make_tetrahedral_block({0.02, 0.02, length}, 4, 4, 24, 0.1, 3);
  set_material(bar, {1e4, 0.3, 1000.0});
  CutSurface cut = cut_plane({0.01, 0.01, 0.041}, {0.1, 0.15, 1.0});
  cut.front = [](const Vec3& x) { return x.x() - 0.012; };
  const ContactSurface surface = make_contact_surface(cut_body(bar, cut));
  std::mt19937 bits(5);
  ContactCandidates candidates;
  candidates.follow(surface, {});
  std::size_t lips = 0, ends = 0;
  constexpr int steps = 60;
  for (int step = 0; step <= steps; ++step) {
    const double angle = 6.2 * step / steps, radius = length / std::max(angle, 1e-9);
    const Mat3 turn = Eigen::AngleAxisd(0.05 * step, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    VecList place;
    for (const Vec3& x : surface.rest) {
      const double at = x.z() / radius, off = radius + x.x() - 0.01;
      place.push_back(turn * Vec3(off * std::cos(at) - radius, x.y(), off * std::sin(at)) +
                      1e-5 * random_vector(bits, 3));
    }
    const Pairs wanted = pairs_that_count(surface, place, {}, 1e-5);
    const Pairs listed = pairs_listed(candidates, place, 1e-5);
    ASSERT_TRUE(std::ranges::includes(listed, wanted)) << step;
    for (const auto& [k, t] : wanted) ++(surface.particles[k].of_cut ? lips : ends);
  }
  EXPECT_GT(lips, 1000u);
  EXPECT_GT(ends, 100u);
}

/// Two bodies that turn about each other, further in each step than lists hold.
TEST(ContactCandidates, SearchesAllocateNothing) {
  const ContactSurface surface = make_contact_surface(two_cubes(0.002));
  ContactCandidates candidates;
  candidates.follow(surface, {});
  VecList place = surface.rest;
  constexpr int steps = 20;
  std::size_t before = 0;
  for (int step = 0; step < steps; ++step) {
    const Mat3 turn = Eigen::AngleAxisd(0.3 * step, Vec3::UnitX()).toRotationMatrix();
    for (std::size_t k = 0; k < place.size(); ++k) place[k] = turn * surface.rest[k];
    if (step == 1) before = allocation_count();
    candidates.each(place, 1e-5, HUGE_VAL, [](const ContactCandidates::List&) { return 0.0; });
  }
  EXPECT_EQ(allocation_count(), before);
  EXPECT_EQ(candidates.searches(), static_cast<std::size_t>(steps));
}

/// What is not finite touches nothing, hides nothing, and is forgotten with the next state.
TEST(ContactCandidates, PlacesThatAreNoNumbersHideNoOthers) {
  const Model model = two_cubes(0.0005);
  const ContactSurface surface = make_contact_surface(model);
  ContactCandidates candidates;
  candidates.follow(surface, {});
  const Pairs usual = pairs_listed(candidates, surface.rest, 0.0);
  ASSERT_GT(usual.size(), 100u);
  VecList broken = surface.rest;
  broken[3].y() = std::numeric_limits<double>::quiet_NaN();
  const Pairs wanted = pairs_that_count(surface, broken, {}, 0.0);
  for (int again = 0; again < 2; ++again) {
    const Pairs listed = pairs_listed(candidates, broken, 0.0);
    for (const auto& pair : wanted) EXPECT_TRUE(listed.contains(pair));
  }
  EXPECT_EQ(candidates.searches(), 3u);
  broken[3].y() = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(pairs_listed(candidates, broken, 0.0).empty());
  EXPECT_EQ(pairs_listed(candidates, surface.rest, 0.0), usual);
}

/// Memory may end within a step, which is then left: lists that were begun are none.
TEST(ContactCandidates, ListsThatWereNotFinishedAreForgotten) {
  const ContactSurface surface = make_contact_surface(two_cubes(0.0005));
  ContactCandidates candidates;
  candidates.follow(surface, {});
  int seen = 0;
  EXPECT_THROW(candidates.each(surface.rest, 0.0, HUGE_VAL,
                               [&](const ContactCandidates::List&) {
                                 if (++seen == 10) throw std::bad_alloc();
                                 return 0.0;
                               }),
               std::bad_alloc);
  EXPECT_EQ(candidates.searches(), 1u);
  const Pairs listed = pairs_listed(candidates, surface.rest, 0.0);
  EXPECT_EQ(candidates.searches(), 2u);
  const Pairs wanted = pairs_that_count(surface, surface.rest, {}, 0.0);
  for (const auto& pair : wanted) EXPECT_TRUE(listed.contains(pair));
  ContactCandidates others;
  others.follow(surface, {});
  ASSERT_GT(listed.size(), 100u);
  EXPECT_EQ(listed, pairs_listed(others, surface.rest, 0.0));
}

/// Skins of two edges and more, with which every particle has hundreds of triangles near: no slack is added to that,
/// and all the same nothing is missing, also when the skins are usual ones again.
TEST(ContactCandidates, ListsTooLongToKeepAreWhole) {
  const ContactSurface surface = make_contact_surface(two_cubes(0.0005));
  ContactCandidates candidates;
  const ContactOptions wide{.margin = 0.012};
  candidates.follow(surface, wide);
  const Pairs wanted = pairs_that_count(surface, surface.rest, wide, 0.0);
  ASSERT_GT(wanted.size(), 64 * surface.particles.size());
  for (int step = 0; step < 20; ++step) {
    const Pairs listed = pairs_listed(candidates, surface.rest, 0.0);
    EXPECT_TRUE(std::ranges::includes(listed, wanted)) << step;
  }
  EXPECT_EQ(candidates.searches(), 20u);
  candidates.change({});
  for (int step = 0; step < 5; ++step) {
    EXPECT_TRUE(std::ranges::includes(pairs_listed(candidates, surface.rest, 0.0),
                                      pairs_that_count(surface, surface.rest, {}, 0.0)));
  }
  EXPECT_EQ(candidates.searches(), 21u);
}

/// A millimetre is used up when each of two has gone half of it; a margin comes on top.
TEST(ContactCandidates, WhatIsApartIsPassedOverUntilItMayTouch) {
  const ContactSurface surface = make_contact_surface(two_cubes(0.0005));
  ContactCandidates candidates;
  candidates.follow(surface, {});
  const auto visits_at = [&](double gone, double margin) {
    int visits = 0;
    candidates.each(surface.rest, margin, gone, [&](const ContactCandidates::List&) { return ++visits, 1e-3; });
    return visits;
  };
  const int all = visits_at(7.0, 1e-4);
  ASSERT_GT(all, 50);
  EXPECT_TRUE(candidates.none_within(1e-4, 7.0004, 7.0));
  EXPECT_FALSE(candidates.none_within(1e-4, 7.0005, 7.0));
  EXPECT_EQ(visits_at(7.0004, 1e-4), 0);
  EXPECT_EQ(visits_at(7.0005, 1e-4), all);
  EXPECT_EQ(visits_at(7.0009, 1e-4), 0);  // from the last visit on
  EXPECT_EQ(candidates.searches(), 1u);
}

/// Set places: what all have moved by counts as motion, whatever gone() says before and after.
TEST(ContactCandidates, WhatIsApartStaysSoWherePlacesAreSetNear) {
  const ContactSurface surface = make_contact_surface(two_cubes(0.0005));
  ContactCandidates candidates;
  candidates.follow(surface, {});
  const auto visits_at = [&](double gone, double moved) {
    VecList place = surface.rest;
    place[0].x() += moved;
    int visits = 0;
    candidates.each(place, 1e-4, gone, [&](const ContactCandidates::List&) { return ++visits, 1e-3; });
    return visits;
  };
  const int all = visits_at(7.0, 0.0);
  candidates.jump();
  EXPECT_FALSE(candidates.none_within(1e-4, 3.0, 3.0));
  EXPECT_EQ(visits_at(3.0, 2e-4), 0);
  EXPECT_EQ(visits_at(3.0002, 2e-4), 0);
  candidates.jump();
  EXPECT_EQ(visits_at(5.0, 2.6e-4), all);  // 0.2, 0.2 and 0.06 mm of the 0.45 that were left
  EXPECT_EQ(candidates.searches(), 1u);
}

/// Lists kept without slack to spare: the body has come nearer by almost all of it, and the step may go as far again.
/// Either alone the lists would bear.
TEST(ContactCandidates, AreLookedForAnewWhereMotionAndMarginTogetherPassTheSlack) {
  constexpr double edge = 0.005;  // m, of two_cubes()
  const ContactSurface surface = make_contact_surface(two_cubes(1.2 * edge));
  const ContactOptions options{.margin = 0.6 * edge};  // further out than what is inside: depth_factor
  for (const double way : {0.05 * edge, 0.15 * edge, 0.24 * edge}) {
    ContactCandidates candidates;
    candidates.follow(surface, options);
    pairs_listed(candidates, surface.rest, 0.0);
    VecList place = surface.rest;
    for (std::size_t k = 0; k < place.size(); ++k) {
      if (surface.particles[k].body == 1) place[k].z() -= way;
    }
    const Pairs wanted = pairs_that_count(surface, place, options, way);
    ASSERT_GT(wanted.size(), 100u);
    EXPECT_TRUE(std::ranges::includes(pairs_listed(candidates, place, way), wanted)) << way;
  }
}

/// Of a particle above the edge between two triangles, near the longest distance: the one that is a little further away
/// may rank before the other, so that it is listed although it alone would not be.
TEST(ContactCandidates, ListWhatMayRankBeforeTheNearest) {
  constexpr double edge = 0.005, top = 0.03;  // m, of two_cubes()
  const ContactSurface surface = make_contact_surface(two_cubes(10.0 * edge));
  const ContactOptions options{.margin = 0.6 * edge};
  const double margin = 0.5 * edge;  // so much that there is no slack
  const double height = (1.0 - 1e-8) * (margin + 2.0 * options.margin);
  const double further = 0.5 * ContactSurface::facing_share * surface.longest_edge;  // the second triangle, m
  const double aside = std::sqrt(further * (2.0 * height + further));
  const auto above = std::ranges::find(surface.particles, 1, &ContactSurface::Particle::body);
  const auto particle = static_cast<std::size_t>(above - surface.particles.begin());
  int pairs = 0;
  for (std::size_t s = 0; s < surface.triangles.size(); ++s) {
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const auto &own = surface.triangles[s].corner, &other = surface.triangles[t].corner;
      const auto on_top = [&](Index c) { return std::abs(surface.rest[c].z() - top) < 1e-9; };
      if (!std::ranges::all_of(own, on_top) || !std::ranges::all_of(other, on_top)) continue;
      const auto apex = std::ranges::find_if(own, [&](Index c) { return std::ranges::count(other, c) == 0; });
      const auto shared = std::ranges::count_if(own, [&](Index c) { return std::ranges::count(other, c) > 0; });
      if (shared != 2) continue;
      const Vec3 &a = surface.rest[own[(apex - own.begin() + 1) % 3]],
                 &b = surface.rest[own[(apex - own.begin() + 2) % 3]];
      const Vec3 along = (b - a).normalized(), inward = surface.rest[*apex] - a;
      VecList place = surface.rest;
      place[particle] =
          0.5 * (a + b) + aside * (inward - inward.dot(along) * along).normalized() + height * Vec3::UnitZ();
      ContactCandidates candidates;
      candidates.follow(surface, options);
      const Pairs listed = pairs_listed(candidates, place, margin);
      EXPECT_TRUE(listed.contains({particle, static_cast<Index>(s)}));
      EXPECT_TRUE(listed.contains({particle, static_cast<Index>(t)}));
      if (++pairs == 40) return;
    }
  }
  ADD_FAILURE() << "expected more triangles on the top of the lower cube, got " << pairs << " pairs";
}

struct Motion {
  std::string name;
  double gap;      // m
  double speed;    // m/s, of the upper cube, down
  double gravity;  // m/s2
  bool self;
};

/// One solver keeps its candidates, the other is given the same contacts anew before every step. Back to the start
/// and on from a state of its own in between.
TEST(ContactCandidates, KeptAndFreshHaveTheSameBits) {
  const Motion motions[] = {{"resting", 0.0008, 0.0, 9.81, true},      {"crumpling", 0.0008, 0.0, 200.0, true},
                            {"colliding", 0.003, 1.0, 0.0, true},      {"fast", 0.01, 6.0, 0.0, true},
                            {"overlapping", -0.0004, 0.0, 9.81, true}, {"others only", 0.003, 1.0, 9.81, false}};
  for (const BackendCase& backend : cpu_backends) {
    for (const Motion& motion : motions) {
      if (sanitized && motion.name != "colliding") continue;  // minutes each; memory is used alike in all
      SCOPED_TRACE(std::string(backend.name) + ", " + motion.name);
      const Model model = two_cubes(motion.gap);
      const ContactOptions options{.friction = 0.4, .self = motion.self};
      Scene kept_scene(model), fresh_scene(model), free_scene(model);
      for (Scene* scene : {&kept_scene, &fresh_scene, &free_scene}) {
        scene->gravity({1.0, 0, -motion.gravity}).fix("low/z0");
        if (scene != &free_scene) scene->contacts(options);
      }
      const auto kept = make_solver(backend.name, model, kept_scene, {}, options_for(backend));
      const auto fresh = make_solver(backend.name, model, fresh_scene, {}, options_for(backend));
      const auto free = make_solver(backend.name, model, free_scene, {}, options_for(backend));
      State start = rest_state(model);
      for (const Index i : model.group("high")) start.velocity[i] = {0.1 * motion.speed, 0, -motion.speed};
      for (Solver* solver : {kept.get(), fresh.get(), free.get()}) solver->reset(start);
      const double dt = 0.4 * kept->stable_step();
      State middle;
      for (int step = 0; step < 80; ++step) {
        if (step == 30) middle = kept->read();
        if (step == 45 || step == 65) {
          for (Solver* solver : {kept.get(), fresh.get()}) solver->reset(step == 45 ? start : middle);
        }
        fresh_scene.contacts(options);
        const StepReport one = kept->step(1, dt), other = fresh->step(1, dt);
        if (step < 30) free->step(1, dt);
        ASSERT_EQ(one.ok(), other.ok()) << step;
        ASSERT_EQ(kept->read(), fresh->read()) << step;
        if (step == 29) {
          EXPECT_FALSE(kept->read() == free->read());  // they touch
        }
      }
    }
  }
}

/// The ends of a strip are bent together until they touch.
TEST(ContactCandidates, KeptAndFreshHaveTheSameBitsInOneBody) {
  const Model model = with_material(make_block({0.06, 0.01, 0.005}, 24, 4, 2), {5e3, 0.3, 1000.0});
  std::vector<std::unique_ptr<Solver>> solvers;
  Scene kept_scene(model), fresh_scene(model), free_scene(model);
  for (Scene* scene : {&kept_scene, &fresh_scene, &free_scene}) {
    PressedStrip(model, 0.012).press(*scene);
    if (scene != &free_scene) scene->contacts({});
    solvers.push_back(make_solver("cpu", model, *scene, {}, options_for({"cpu", 1}, 10.0)));
  }
  const double dt = 0.4 * solvers[0]->stable_step();
  for (int step = 0; step < static_cast<int>(0.2 / dt); ++step) {
    fresh_scene.contacts({});
    for (const auto& solver : solvers) ASSERT_TRUE(is_ok(solver->step(1, dt)));
  }
  EXPECT_EQ(solvers[0]->read(), solvers[1]->read());
  EXPECT_FALSE(solvers[0]->read() == solvers[2]->read());  // they touch
}

/// Nearer by less than the slack of a search.
TEST(ContactCandidates, PlacesThatAreSetAreLookedAtAnew) {
  const Model model = two_cubes(0.002);
  const Scene scene = Scene(model).contacts({});
  State nearer = rest_state(model);
  for (const Index i : model.group("high")) nearer.position[i].z() -= 0.0012;
  State after[2];
  for (const bool steps_before : {false, true}) {
    const auto solver = make_solver("cpu", model, scene, {}, options_for({"cpu", 1}));
    if (steps_before) solver->step(1, 1e-4);
    solver->reset(nearer);
    solver->step(1, 1e-4);
    after[steps_before] = solver->read();
  }
  EXPECT_EQ(after[0], after[1]);
  EXPECT_FALSE(after[0].position == nearer.position);  // they touch
}

}  // namespace
}  // namespace phymul
