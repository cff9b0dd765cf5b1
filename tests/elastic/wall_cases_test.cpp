// SPDX-License-Identifier: MIT
//
// Walls against closed forms and the shell obstacle course, on structured and unstructured triangles. The figures of
// docs/measurements/walls.md: this suite prints them.
#include <gtest/gtest.h>
#include <phymul/elasticity.h>

#include <cstdio>

#include "support/wall_cases.h"

namespace phymul::test {
namespace {

constexpr double full_turn = 2.0 * std::numbers::pi;

struct Course {
  const char* name;
  double (*error)(int n, double jitter);
  std::vector<int> sizes;
  double structured, unstructured;  // largest error at the last size
};

TEST(WallCases, ConvergeToTheLiterature) {
  const auto clamped = [](int n, double jitter) { return circular_plate(n, jitter, true); };
  const auto hinged = [](int n, double jitter) { return circular_plate(n, jitter, false); };
  const std::vector<Course> course{{"clamped plate", clamped, {7, 10, 14}, 0.02, 0.02},
                                   {"hinged plate", hinged, {7, 10, 14}, 0.005, 0.005},
                                   {"Scordelis-Lo roof", scordelis_lo_roof, {11, 15, 31}, 0.01, 0.01},
                                   {"pinched cylinder", pinched_cylinder, {15, 31, 62}, 0.04, 0.07},
                                   {"hemisphere with hole", hemisphere_with_hole, {15, 22, 31}, 0.02, 0.02}};
  for (const Course& it : course) {
    for (const double jitter : {0.0, 0.2}) {
      std::printf("%-22s jitter %.1f:", it.name, jitter);
      double last = 1.0;
      for (const int n : it.sizes) {
        last = it.error(n, jitter);
        std::printf("  %d: %+.2f %%", n, 100.0 * last);
      }
      std::printf("\n");
      EXPECT_LT(std::abs(last), jitter == 0.0 ? it.structured : it.unstructured) << it.name << ", jitter " << jitter;
    }
  }
}

/// M = E I 2 pi / L, nu = 0. Two rows at either end are held on the circle.
TEST(WallCases, StripBendsIntoACircle) {
  constexpr double E = 10e3, t = 1e-3, L = 0.1, b = 0.01, R = L / full_turn;
  for (const double jitter : {0.0, 0.2}) {
    const Model model =
        wall_of(grid_surface(60, 6, jitter, [](double u, double v) { return Vec3(L * u, b * v, 0); }), E, 0.0, t);
    const TopologyTextures tables = build_topology(model);
    const double row = 1.3 * L / 60.0;
    WallRest strip(tables, held_of(model, [&](const Vec3& X) { return X.x() < row || X.x() > L - row ? 7 : 0; }));
    for (Vec3& p : strip.x) p = {R * std::sin(p.x() / R), p.y(), R * (1.0 - std::cos(p.x() / R))};
    ASSERT_TRUE(strip.rest(1e-9 * L));
    const VecList force = forces_at(tables, strip.x);
    Vec3 moment = Vec3::Zero();
    for (std::size_t i = 0; i < force.size(); ++i) {
      if (model.rest[i].x() > L - row) moment += strip.x[i].cross(force[i]);
    }
    EXPECT_NEAR(std::abs(moment.y()) / (E * b * t * t * t / 12.0 / R), 1.0, 0.01) << jitter;
  }
}

/// p = 2 mu t / R (1 / s - 1 / s^7) of an incompressible membrane (Adkins and Rivlin 1952).
TEST(WallCases, BalloonFollowsTheClosedForm) {
  constexpr double E = 10e3, t = 1e-4, R = 0.05, rubber = E / 3.0;
  const Model model = wall_of(sphere_surface(R, 12), E, 0.4999, t);
  const TopologyTextures tables = build_topology(model);
  for (const double s : {1.05, 1.38, 2.0}) {
    VecList x = model.rest, force(x.size()), wall(x.size(), Vec3::Zero());
    for (Vec3& p : x) p *= s;
    elastic_forces(tables, x, force);
    add_pressure(model, x, 1.0, wall);
    double work = 0.0, unit = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      work -= force[i].dot(model.rest[i]);
      unit += wall[i].dot(model.rest[i]);
    }
    EXPECT_NEAR(work / unit / (2.0 * rubber * t / R * (1.0 / s - std::pow(s, -7.0))), 1.0, 0.01) << s;
  }
}

/// Stretches p R / (E t) (1 - nu / 2) around and p R / (E t) (1/2 - nu) along a tube with closed ends.
TEST(WallCases, TubeStretchesUnderPressure) {
  constexpr double E = 10e3, nu = 0.3, t = 5e-4, R = 0.01, L = 0.08, p = 1.0;
  for (const double jitter : {0.0, 0.2}) {
    const Model model = wall_of(
        grid_surface(
            48, 60, jitter,
            [](double u, double v) { return Vec3(R * std::cos(full_turn * u), R * std::sin(full_turn * u), L * v); },
            true),
        E, nu, t);
    const TopologyTextures tables = build_topology(model);
    std::vector<std::uint8_t> held = held_of(model, [](const Vec3& X) { return X.z() < 1e-9 ? 4 : 0; });
    held[0] |= 2, held[24] |= 2, held[12] |= 1;
    WallRest tube(tables, held);
    add_pressure(model, model.rest, p, tube.force);
    std::vector<std::size_t> top;
    for (std::size_t i = 0; i < tube.x.size(); ++i) {
      if (model.rest[i].z() > L - 1e-9) top.push_back(i);
    }
    for (const std::size_t i : top) tube.force[i].z() += p * std::numbers::pi * R * R / static_cast<double>(top.size());
    tube.step();
    double around = 0.0, along = 0.0, count = 0.0;
    for (std::size_t i = 0; i < tube.x.size(); ++i) {
      const Vec3 &X = model.rest[i], d = tube.x[i] - X;
      if (std::abs(X.z() - 0.5 * L) > 0.1 * L) continue;
      around += (X.x() * d.x() + X.y() * d.y()) / (R * R);
      along += d.z() / X.z();
      count += 1.0;
    }
    const double unit = p * R / (E * t);
    EXPECT_NEAR(around / count / (unit * (1.0 - nu / 2.0)), 1.0, 0.01) << jitter;
    // Along, the edge that is held free of bending shifts what is measured from it.
    EXPECT_NEAR(along / count / (unit * (0.5 - nu)), 1.0, 0.02) << jitter;
  }
}

/// Euler's load pi^2 E I / L^2 by how much an axial load of half of it softens a hinged strip (Southwell 1932).
TEST(WallCases, StripBucklesAtEulersLoad) {
  constexpr double E = 10e3, t = 1e-3, L = 0.1, b = 0.01;
  constexpr double euler = std::numbers::pi * std::numbers::pi * E * b * t * t * t / 12.0 / (L * L);
  for (const double jitter : {0.0, 0.2}) {
    const Model model =
        wall_of(grid_surface(40, 4, jitter, [](double u, double v) { return Vec3(L * u, b * v, 0); }), E, 0.0, t);
    const TopologyTextures tables = build_topology(model);
    const auto sag = [&](double axial) {
      WallRest strip(tables, held_of(model, [](const Vec3& X) {
                       return (X.x() < 1e-9 ? 5 : X.x() > L - 1e-9 ? 4 : 0) | (X.y() < 1e-9 && X.x() < 1e-9 ? 2 : 0);
                     }));
      for (std::size_t i = 0; i < strip.x.size(); ++i) {
        if (model.rest[i].x() > L - 1e-9) {
          const bool at_corner = model.rest[i].y() < 1e-9 || model.rest[i].y() > b - 1e-9;
          strip.force[i].x() -= axial / (at_corner ? 8.0 : 4.0);
        }
      }
      EXPECT_TRUE(strip.rest(1e-10 * L));
      for (std::size_t i = 0; i < strip.x.size(); ++i) strip.force[i].z() += 1e-9 * model.mass[i];
      strip.step();
      return strip.x[particle_at(model, {0.5 * L, 0.5 * b, 0.0})].z();
    };
    const double plain = sag(0.0), pressed = sag(0.5 * euler);
    EXPECT_NEAR(0.5 / (1.0 - plain / pressed), 1.0, 0.03) << jitter;
  }
}

}  // namespace
}  // namespace phymul::test
