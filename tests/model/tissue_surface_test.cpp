// SPDX-License-Identifier: MIT
//
// The surface of what cuts and removals leave. Shapes from meshes: distances against closed forms, and what is refused.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "interaction/distance_to_shape.h"
#include "model/closed_surface.h"
#include "support/cut_bodies.h"
#include "support/message_of.h"
#include "support/tool_backends.h"

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

double box_distance(const Vec3& x, const Vec3& low, const Vec3& high) {
  const Vec3 half = 0.5 * (high - low), q = x - 0.5 * (low + high);
  return distance_from_box<double>({q.x(), q.y(), q.z()}, {half.x(), half.y(), half.z()}).phi;
}

TEST(DistanceGrid, OfABoxIsItsDistance) {
  const Model model = make_block({0.03, 0.02, 0.01}, 3, 2, 1);
  const auto grid = make_distance_grid(model, 0.0013);
  const auto [nx, ny, nz] = grid->count();
  EXPECT_NEAR(grid->depth(), 0.005, 0.0007);
  std::size_t at = 0;
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i, ++at) {
        const Vec3 x = grid->origin() + 0.0013 * Vec3(i, j, k);
        ASSERT_NEAR(grid->values()[at], box_distance(x, Vec3::Zero(), {0.03, 0.02, 0.01}), 1e-9) << x.transpose();
      }
    }
  }
}

/// A star of two spikes: corners and edges where a face's own normal has the wrong sign.
Model spiked() {
  Model model;
  model.rest = {{0, 0, 0.05}, {0, 0, -0.05}, {0.01, 0, 0}, {0, 0.01, 0}, {-0.01, 0, 0}, {0, -0.01, 0}};
  model.mass.assign(6, 1.0);
  model.stiffness.assign(6, 1.0);
  const auto face = [&](Index a, Index b, Index c) {
    model.cells.push_back({.type = CellType::triangle, .particles = {a, b, c}});
  };
  for (Index k = 0; k < 4; ++k) {
    face(0, 2 + k, 2 + (k + 1) % 4);
    face(1, 2 + (k + 1) % 4, 2 + k);
  }
  model.neighbours = neighbours_from_cells(model.cells, 6);
  return model;
}

TEST(DistanceGrid, KnowsInsideFromOutsideAtSharpCorners) {
  const Model model = spiked();
  std::vector<Triangle> triangles;
  for (const Cell& cell : model.cells) {
    triangles.push_back({cell.particles[0], cell.particles[1], cell.particles[2]});
  }
  const ClosestTriangle closest(model.rest, triangles);
  std::mt19937 bits(3);
  for (int k = 0; k < 20000; ++k) {
    const Vec3 x = 0.06 * random_vector(bits, 3).cwiseProduct(Vec3(0.3, 0.3, 1.0));
    // |x| + |y| <= 0.01 (1 - |z| / 0.05)
    const double out = std::abs(x.x()) + std::abs(x.y()) - 0.01 * (1.0 - std::abs(x.z()) / 0.05);
    if (std::abs(out) < 1e-9) continue;
    ASSERT_EQ(closest.signed_distance(x) > 0.0, out > 0.0) << x.transpose();
  }
  EXPECT_NEAR(closest.signed_distance({0, 0, 0.06}), 0.01, 1e-15);
}

TEST(DistanceGrid, WhatIsNotClosedIsRefusedByItsEdge) {
  Model open = spiked();
  open.cells.erase(open.cells.begin());  // 0, 2, 3
  EXPECT_TRUE(refuses([&] { make_distance_grid(open, 0.002); },
                      "not closed, or not wound one way: the edge from particle 0 to 3"));
  Model turned = spiked();
  std::swap(turned.cells[0].particles[1], turned.cells[0].particles[2]);
  EXPECT_TRUE(refuses([&] { make_distance_grid(turned, 0.002); }, "not wound one way"));
  Model sliver = spiked();  // off the line from 0 to 2 by rounding
  sliver.rest.push_back(0.5 * (sliver.rest[0] + sliver.rest[2]) + Vec3(0, 1e-15, 0));
  sliver.mass.push_back(1.0);
  sliver.stiffness.push_back(1.0);
  for (const auto& [a, b, c] : {Triangle{0, 6, 3}, Triangle{6, 2, 3}, Triangle{0, 2, 6}}) {
    sliver.cells.push_back({.type = CellType::triangle, .particles = {a, b, c}});
  }
  sliver.cells.erase(sliver.cells.begin());
  sliver.neighbours = neighbours_from_cells(sliver.cells, 7);
  EXPECT_TRUE(refuses([&] { make_distance_grid(sliver, 0.002); }, "particles 0, 2 and 6 has no area"));
  EXPECT_TRUE(refuses([] { make_distance_grid(spiked(), 1e-6); }, "more than 64 million"));
  EXPECT_TRUE(refuses([] { make_distance_grid(spiked(), -1.0); }, "spacing above 0 m, got -1"));
  EXPECT_TRUE(refuses(
      [] {
        DistanceGrid(Vec3::Zero(), 1.0, {2, 2, 2}, std::vector<float>(8, 1.0f));
      },
      "no corner lies inside"));
  EXPECT_NO_THROW(make_distance_grid(spiked(), 0.002));
}

using GridTool = WithTools;
PHYMUL_ON_EVERY_BACKEND(GridTool);

/// The distances of a ball's surface at the corners of cubes.
std::shared_ptr<const DistanceGrid> ball_grid(double radius, double spacing) {
  const int cubes = 2 * static_cast<int>(std::ceil(radius / spacing)) + 4, n = cubes + 1;
  const Vec3 origin = Vec3::Constant(-0.5 * spacing * cubes);
  std::vector<float> values;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        values.push_back(static_cast<float>((origin + spacing * Vec3(i, j, k)).norm() - radius));
      }
    }
  }
  return std::make_shared<const DistanceGrid>(origin, spacing, std::array<int, 3>{n, n, n}, std::move(values));
}

TEST_P(GridTool, PressesAsTheSameBallDoes) {
  const Model model = soft_block({0.03, 0.03, 0.02}, 6, 6, 4);
  const auto press = [&](const ToolShape& shape) {
    Scene scene(model);
    ToolPose pose{.position = Vec3(0.015, 0.014, 0.0285),
                  .orientation = Quaternion(Eigen::AngleAxisd(0.3, Vec3(0.2, 1, 0).normalized()))};
    scene.fix("z0").add_tool("tool", {.shape = shape, .pose = pose, .friction = 0.3});
    const auto solver = make(model, scene, damped(40.0));
    pose.position.z() -= 0.003;
    scene.tool("tool").move_to(pose);
    EXPECT_TRUE(solver->step(300, 0.4 * solver->stable_step()).ok());
    EXPECT_GT(solver->tool_force("tool").particles, 3);
    return solver->tool_force("tool").mean_force;
  };
  const Vec3 closed_form = press(Sphere{0.008}), grid = press(ball_grid(0.008, 0.5e-3));
  EXPECT_GT(closed_form.z(), 0.02);
  EXPECT_LE((closed_form - grid).norm(), 0.02 * closed_form.norm());
}

}  // namespace
}  // namespace phymul
