// SPDX-License-Identifier: MIT
//
// Walls that branch: strips that meet in a T against frames of beams.
#include <gtest/gtest.h>
#include <phymul/elasticity.h>

#include "support/bodies.h"
#include "support/cpu_forces.h"
#include "support/message_of.h"
#include "support/wall_cases.h"

namespace phymul::test {
namespace {

constexpr double length = 0.1, height = 0.08, width = 0.02;  // m
constexpr double young = 10e3, thick = 1e-3;                 // Pa, m

/// A strip along x from -length to length, and one from its middle down to z = -height, n cells a length, unlike ones
/// with a jitter.
Model strips(int n, double jitter, double thickness_below) {
  const int across = std::max(2, n / 4);
  Surface surface = grid_surface(2 * n, across, 0.0,
                                 [](double u, double v) { return Vec3(length * (2.0 * u - 1.0), width * v, 0.0); });
  std::mt19937 bits(7);
  const auto move = [&] { return jitter * (2.0 * static_cast<double>(bits()) / 4294967296.0 - 1.0); };
  const double h = length / n;
  for (Vec3& x : surface.vertices) {
    if (std::abs(x.x()) < 1e-9 || std::abs(std::abs(x.x()) - length) < 1e-9) continue;
    x.x() += h * move();
    if (x.y() > 1e-9 && x.y() < width - 1e-9) x.y() += h * move();
  }
  const Surface below =
      grid_surface(n, across, jitter, [](double u, double v) { return Vec3(0.0, width * v, -height * u); });
  const std::size_t upper = surface.triangles.size();
  std::vector<Index> row_of;
  for (const Vec3& x : below.vertices) {
    const auto known = std::ranges::find_if(surface.vertices, [&](const Vec3& own) { return (own - x).norm() < 1e-9; });
    row_of.push_back(static_cast<Index>(known - surface.vertices.begin()));
    if (known == surface.vertices.end()) surface.vertices.push_back(x);
  }
  for (const auto& [a, b, c] : below.triangles) surface.triangles.push_back({row_of[a], row_of[b], row_of[c]});
  Model model = wall_of(surface, young, 0.0, thick);
  model.add_group("below", {});
  for (std::size_t row = upper; row < surface.triangles.size(); ++row) {
    model.components.back().cell_refs.push_back(static_cast<Index>(row));
  }
  set_material(model, {.young = young, .poisson = 0.0, .density = 1000.0, .thickness = thickness_below}, "below");
  return model;
}

/// m, by which the particles of `loaded` move along `way` on the average, where a force of 1 uN pulls them.
double moved_by(Model model, const std::vector<Index>& loaded, const Vec3& way) {
  std::vector<std::uint8_t> fixed(model.rest.size(), 0);
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    if (std::abs(model.rest[i].x()) > length - 1e-9) fixed[i] = 7;
  }
  clamp_edges(model, [](const Vec3& x) { return std::abs(x.x()) > length - 1e-9; });
  const TopologyTextures tables = build_topology(model);
  WallRest rest(tables, fixed);
  double ends = 0.0;  // of the width, which end particles have half of
  const auto share = [&](Index i) {
    const double y = model.rest[i].y();
    return y < 1e-9 || y > width - 1e-9 ? 0.5 : 1.0;
  };
  for (const Index i : loaded) ends += share(i);
  for (const Index i : loaded) rest.force[i] = 1e-6 * share(i) / ends * way;
  rest.step();
  double sum = 0.0;
  for (const Index i : loaded) sum += share(i) / ends * way.dot(rest.x[i] - model.rest[i]);
  return sum;
}

double inertia(double thickness) {
  return width * std::pow(thickness, 3) / 12.0;
}

/// The foot pulled aside: it bends, and turns the joint, which the two arms resist by 4 E I / L each. A wall is too
/// stiff where it is folded, by as much as a part of a cell.
TEST(WallBranch, FrameMovesAsOneOfBeams) {
  for (const double below : {thick, 2.0 * thick, 0.5 * thick}) {
    const double force = 1e-6, turn = force * height / (8.0 * young * inertia(thick) / length);
    const double wanted = force * std::pow(height, 3) / (3.0 * young * inertia(below)) + turn * height;
    for (const double jitter : {0.0, 0.2}) {
      const Model model = strips(32, jitter, below);
      const auto foot = model.particles_in([](const Vec3& x) { return x.z() < -height + 1e-9; });
      EXPECT_NEAR(moved_by(model, foot, Vec3::UnitX()) / wanted, 1.0, 0.04) << below << ' ' << jitter;
    }
  }
}

/// A thin fin does not change the bending stiffness of the strip to which it is joined.
TEST(WallBranch, AThinFinLeavesTheStripAsStiffAsItWas) {
  const double wanted = 1e-6 * std::pow(2.0 * length, 3) / (192.0 * young * inertia(thick));
  const Model model = strips(16, 0.2, 0.05 * thick);
  const auto at_middle = model.particles_in([](const Vec3& x) { return std::abs(x.x()) < 1e-9 && x.z() > -1e-9; });
  EXPECT_NEAR(moved_by(model, at_middle, Vec3::UnitZ()) / wanted, 1.0, 0.02);
}

TEST(WallBranch, ForcesAreTheSlopeOfTheEnergyAndKeepMomenta) {
  const Model model = strips(6, 0.2, thick);
  const TopologyTextures tables = build_topology(model);
  EXPECT_GT(tables.walls.size(), model.cells.size());
  EXPECT_LT(largest_norm(forces_at(tables, rigidly_moved(model, 3))),
            1e-9 * largest_norm(forces_at(tables, random_positions(model, 0.1, 3))));
  const VecList x = random_positions(model, 0.2, 7), force = forces_at(tables, x);
  const double h = 1e-6 * mean_spacing(model);
  for (std::size_t i = 0; i < x.size(); i += 17) {
    for (int axis = 0; axis < 3; ++axis) {
      VecList up = x, down = x;
      up[i][axis] += h;
      down[i][axis] -= h;
      const double slope = (elastic_energy(tables, up) - elastic_energy(tables, down)) / (2.0 * h);
      EXPECT_NEAR(force[i][axis], -slope, 2e-5 * largest_norm(force)) << i;
    }
  }
}

TEST(WallBranch, TwoTrianglesInOnePlaceAreRefused) {
  Surface surface = disc_surface(0.1, 2, 0.0);
  surface.triangles.push_back(surface.triangles.front());
  const Model model = wall_of(surface, young, 0.3, thick);
  EXPECT_TRUE(
      says(message_of([&] { build_topology(model); }), "expected one triangle of a wall between three particles"));
}

}  // namespace
}  // namespace phymul::test
