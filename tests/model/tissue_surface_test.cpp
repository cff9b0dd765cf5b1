// SPDX-License-Identifier: MIT
//
// The surface of what cuts and removals leave.
#include <phymul/phymul.h>
#include <phymul/shapes.h>
#include <phymul/surface.h>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "support/message_of.h"
#include "support/removable_body.h"

namespace phymul {
namespace {

using namespace test;

struct Measures {
  double volume = 0.0, of_cut = 0.0, outside = 0.0;  // m^3, m^2
};

Measures measures(const TissueSurface& surface, const VecList& x) {
  Measures found;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    found.volume += x[a].dot(x[b].cross(x[c])) / 6.0;
    (surface.of_cut[t] != 0 ? found.of_cut : found.outside) += 0.5 * (x[b] - x[a]).cross(x[c] - x[a]).norm();
  }
  return found;
}

TEST(TissueSurface, EnclosesWhatIsLeft) {
  Model model = slab();
  set_material(model, {5e3, 0.4, 1000.0});
  Simulation sim(with_spare_particles(model, 900), {.backend = "reference"});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int k = 0; k < 12; ++k) {
    if (k % 3 == 0) sim.restore(Simulation(with_spare_particles(model, 900), {.backend = "reference"}).snapshot());
    const Vec3 through = model.rest[random() % 100], edge(any(random), any(random), any(random));
    CutSurface cut = cut_plane(through, Vec3(any(random), any(random), any(random)));
    if (k % 2 == 0) cut.front = [=](const Vec3& x) { return edge.dot(x - through); };
    sim.cut(cut);
    if (k % 4 == 3) sim.remove_cells(cells_within(sim.model(), through, 0.012));
    const TissueSurface surface = tissue_surface(sim.model());
    EXPECT_NEAR(measures(surface, surface.at(sim.model().rest)).volume / volume(sim.model(), sim.model().rest), 1.0,
                1e-6)
        << k;
  }
}

TEST(TissueSurface, HasBothFacesOfACut) {
  Simulation sim(with_spare_particles(slab(), 300), options_for("reference"));
  const TissueSurface whole = tissue_surface(sim.model());
  EXPECT_EQ(whole.triangles.size(), surface_triangles(sim.model()).size());
  EXPECT_NEAR(measures(whole, whole.at(sim.model().rest)).outside, 2 * (0.06 * 0.04 + 0.06 * 0.03 + 0.04 * 0.03), 1e-9);
  // Between particles: where the surface passes near one it goes through it.
  CutSurface cut = cut_plane({0.0355, 0.0, 0.0}, {1.0, 0.0, 0.0});
  ASSERT_TRUE(sim.cut(cut));
  const TissueSurface parted = tissue_surface(sim.model());
  const Measures found = measures(parted, parted.at(sim.model().rest));
  EXPECT_NEAR(found.of_cut / (2.0 * 0.04 * 0.03), 1.0, 0.02);
  EXPECT_NEAR(found.outside, 2 * (0.06 * 0.04 + 0.06 * 0.03 + 0.04 * 0.03), 1e-9);
}

/// Where a cut ends inside the body, both parts of a cell have one face of the surface.
TEST(TissueSurface, OfTrianglesHasNoHoleAtTheFront) {
  Simulation sim(with_spare_particles(slab(), 300), options_for("reference"));
  const auto places = [](const Model& model) {
    std::set<std::vector<std::array<double, 3>>> found;
    for (const auto& triangle : surface_triangles(model)) {
      std::vector<std::array<double, 3>> corners;
      for (const Index i : triangle) corners.push_back({model.rest[i].x(), model.rest[i].y(), model.rest[i].z()});
      std::ranges::sort(corners);
      found.insert(corners);
    }
    return found;
  };
  const auto whole = places(sim.model());
  const Snapshot before = sim.snapshot();
  int cut_at_all = 0;
  for (double front = 0.002; front < 0.04; front += 0.004) {
    CutSurface cut = cut_plane({0.0355, 0.0, 0.0}, {1.0, 0.0, 0.0});
    cut.front = [front](const Vec3& x) { return x.y() - front; };
    cut_at_all += sim.cut(cut) ? 1 : 0;
    EXPECT_TRUE(std::ranges::includes(places(sim.model()), whole)) << front;
    sim.restore(before);
  }
  EXPECT_GT(cut_at_all, 5);
}

/// Skins, anchors and passages of threads: of the parts of a cut cell the one that has tissue there holds the point.
TEST(TissueSurface, PointsBelongToTheirSide) {
  Simulation sim(with_spare_particles(slab(), 300), options_for("reference"));
  ASSERT_TRUE(sim.cut(cut_plane({0.0355, 0.0, 0.0}, {1.0, 0.0, 0.0})));
  const auto pieces = connected_bodies(sim.model());
  ASSERT_EQ(pieces.size(), 2u);
  VecList points, now = sim.model().rest;
  for (double y = 0.003; y < 0.04; y += 0.005) {
    for (double z = 0.003; z < 0.03; z += 0.005) {
      for (const double x : {0.033, 0.0349, 0.0361, 0.038}) points.emplace_back(x, y, z);
    }
  }
  const bool second_is_right = sim.model().rest[pieces[1].particles.front()].x() > 0.0355;
  for (const Index i : pieces[second_is_right ? 1 : 0].particles) now[i].y() += 1.0;
  const VecList moved = Skin(sim.model(), points).deform(now);
  for (std::size_t k = 0; k < points.size(); ++k) {
    EXPECT_NEAR(moved[k].y() - points[k].y(), points[k].x() > 0.0355 ? 1.0 : 0.0, 1e-9) << points[k].transpose();
  }
}

TEST(TissueSurface, RefusesPlanes) {
  EXPECT_TRUE(says(message_of([] { tissue_surface(make_strip(0.06, 0.03, 8, 4)); }), "three dimensions"));
}

/// check_mesh() turns their cuts round with them.
TEST(TissueSurface, OfCutCellsThatWereInsideOut) {
  Model mirrored = slab();
  for (Cell& cell : mirrored.cells) std::swap(cell.particles[0], cell.particles[1]);
  Model cut = cut_body(mirrored, cut_plane({0.05, 0.02, 0.02}, {1, 0.2, 0.1}));
  check_mesh(cut);
  const TissueSurface surface = tissue_surface(cut);
  const double whole = volume(slab(), slab().rest);
  EXPECT_NEAR(measures(surface, surface.at(cut.rest)).volume, whole, 1e-9 * whole);
}

using Triangles = std::vector<std::array<Index, 3>>;

/// What the triangles enclose, m^3, as positive as they point outward.
double enclosed(const Triangles& triangles, const VecList& x) {
  double volume = 0.0;
  for (const auto& [a, b, c] : triangles) volume += x[a].dot(x[b].cross(x[c])) / 6.0;
  return volume;
}

/// Every edge is walked once each way: closed, and wound alike throughout.
bool is_closed(const Triangles& triangles) {
  std::map<std::pair<Index, Index>, int> walked;
  for (const auto& t : triangles) {
    for (int k = 0; k < 3; ++k) ++walked[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [edge, times] : walked) {
    if (times != 1 || !walked.contains({edge.second, edge.first})) return false;
  }
  return true;
}

TEST(Surface, TrianglesCloseABodyAndPointOutward) {
  const Model block = make_block({0.2, 0.1, 0.1}, 4, 2, 3), cylinder = make_cylinder(0.01, 0.04, 3, 8, 11),
              tetrahedra = make_tetrahedral_block({0.1, 0.1, 0.1}, 3, 3, 3, 0.2, 7);
  for (const Model* model : {&block, &cylinder, &tetrahedra}) {
    const Triangles triangles = surface_triangles(*model);
    double volume = 0.0;
    for (const Cell& cell : model->cells) volume += cell_volume(*model, cell);
    EXPECT_TRUE(is_closed(triangles));
    EXPECT_NEAR(enclosed(triangles, model->rest), volume, 2e-3 * volume);
  }
  EXPECT_EQ(surface_triangles(block).size(), 2u * 2u * (4 * 2 + 4 * 3 + 2 * 3));
}

TEST(Surface, TrianglesOfACellThatIsInsideOutPointOutwardToo) {
  Model model = make_tetrahedron(0.01);
  std::swap(model.cells[0].particles[0], model.cells[0].particles[1]);
  EXPECT_TRUE(is_closed(surface_triangles(model)));
  EXPECT_GT(enclosed(surface_triangles(model), model.rest), 0.0);
}

TEST(Surface, TrianglesOfPlanesAndOfBodiesWithoutVolume) {
  Model strip = make_strip(0.04, 0.02, 4, 2);
  std::ranges::reverse(strip.cells.front().particles);
  Triangles triangles = surface_triangles(strip);
  EXPECT_EQ(triangles.size(), 16u);
  VecList normal;
  surface_normals(triangles, strip.rest, normal);
  for (const Vec3& n : normal) EXPECT_NEAR((n - Vec3::UnitZ()).norm(), 0.0, 1e-12);

  Model shell = make_strip(0.04, 0.02, 4, 2);
  shell.dimension = 3;
  EXPECT_EQ(surface_triangles(shell).size(), 16u);
  shell.cells.clear();
  shell.components.clear();
  EXPECT_TRUE(surface_triangles(shell).empty());
}

TEST(Surface, NormalsFollowTheBody) {
  const Model model = make_block({0.2, 0.2, 0.2}, 2, 2, 2);
  const Triangles triangles = surface_triangles(model);
  const Mat3 turn = Eigen::AngleAxisd(1.0, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  VecList turned = model.rest;
  for (Vec3& x : turned) x = turn * x + Vec3(1, 0, 0);
  VecList normal;
  surface_normals(triangles, turned, normal);
  ASSERT_EQ(normal.size(), model.rest.size());
  const Vec3 middle = Vec3::Constant(0.1);
  for (std::size_t i = 0; i < normal.size(); ++i) {
    const Vec3 out = model.rest[i] - middle;
    const auto sides = (out.array().abs() > 1e-9).count();
    if (sides == 0) {
      EXPECT_EQ(normal[i], Vec3(Vec3::Zero()));
    } else if (sides == 1) {
      EXPECT_NEAR((normal[i] - turn * out.normalized()).norm(), 0.0, 1e-12);
    } else {
      EXPECT_NEAR(normal[i].norm(), 1.0, 1e-12);
      EXPECT_GT(normal[i].dot(turn * out.normalized()), 0.8);
    }
  }
  turned.pop_back();
  EXPECT_TRUE(refuses([&] { surface_normals(triangles, turned, normal); }, "0 to 25, got 26"));
}

TEST(Surface, PicksTheFrontmostParticleNearTheRay) {
  const VecList x = {{0, 0, 3}, {0.01, 0, 2}, {0.3, 0, 1}, {0, 0, -1}, {0, 0, std::nan("")}, {0, 0, 0.5}};
  Model model;
  model.mass = {1, 1, 1, 1, 1, 0};  // kg: nothing is at the last one, as at a spare particle
  PickRay ray{.origin = {0, 0, 0}, .direction = {0, 0, 7}};
  EXPECT_EQ(pick_particle(model, x, ray), 0);
  ray.reach = 0.02;
  EXPECT_EQ(pick_particle(model, x, ray), 1);
  ray.widening = 0.29;
  EXPECT_EQ(pick_particle(model, x, ray), 2);
  ray.direction = {0, 0, -1};
  EXPECT_EQ(pick_particle(model, x, ray), 3);
  ray.direction = {0, 1, 0};
  ray.widening = 0.0;
  EXPECT_EQ(pick_particle(model, x, ray), -1);
  ray.direction = Vec3::Zero();
  EXPECT_TRUE(refuses([&] { pick_particle(model, x, ray); }, "direction that is not zero"));
  EXPECT_TRUE(refuses([&] { pick_particle(model, model.rest, ray); }, "expected 6 positions, got 0"));
}

}  // namespace

}  // namespace phymul
