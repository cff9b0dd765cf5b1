// SPDX-License-Identifier: MIT
//
// Law::walls: what every energy must hold, its tables and its refusals.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <sstream>

#include "support/bodies.h"
#include "support/dense_operator.h"
#include "support/message_of.h"
#include "support/wall_cases.h"

namespace phymul::test {
namespace {

constexpr double radius = 0.05;

/// A curved open shell of unlike triangles, with free edges and one clamped.
Model bowl(bool clamped = true) {
  Model model = wall_of(grid_surface(6, 5, 0.2,
                                     [](double u, double v) {
                                       const double a = 1.4 * (u - 0.5), b = 1.1 * (v - 0.5);
                                       return Vec3(radius * Vec3(std::sin(a), std::sin(b), std::cos(a) * std::cos(b)));
                                     }),
                        10e3, 0.4, 2e-3);
  if (clamped) clamp_edges(model, [&](const Vec3& X) { return X.x() < -0.55 * radius; });
  return model;
}

TEST(Wall, NeitherRestNorRigidMotionHasForces) {
  for (const Model& model : {bowl(false), wall_of(sphere_surface(radius, 4), 10e3, 0.4, 2e-3)}) {
    const TopologyTextures tables = build_topology(model);
    const double scale = largest_norm(forces_at(tables, random_positions(model, 0.1, 3)));
    EXPECT_LT(largest_norm(forces_at(tables, model.rest)), 1e-12 * scale);
    VecList x = model.rest;
    for (Vec3& p : x) p = Eigen::AngleAxisd(2.0, Vec3(1, 2, 3).normalized()) * p + Vec3(0.1, 0.2, 0.3);
    EXPECT_LT(largest_norm(forces_at(tables, x)), 1e-12 * scale);
    EXPECT_LT(elastic_energy(tables, x), 1e-12 * scale * radius);
  }
}

TEST(Wall, ForcesAreTheSlopeOfTheEnergyAlsoWhereItIsCrushed) {
  const Model model = bowl();
  const TopologyTextures tables = build_topology(model);
  const double spacing = mean_spacing(model);
  for (const double crushed : {1.0, 0.4, 0.1, 1e-3}) {
    VecList x = random_positions(model, 0.1, 7);
    for (Vec3& p : x) p.x() *= crushed, p.y() *= std::sqrt(crushed);
    SCOPED_TRACE(crushed);
    const std::size_t some[] = {0, 9, 17, x.size() - 1};
    expect_slope_of_energy(tables, x, 1e-6 * spacing * std::min(1.0, 10.0 * crushed), some);
  }
}

TEST(Wall, ConservesBothMomenta) {
  const Model model = bowl(false);
  const TopologyTextures tables = build_topology(model);
  const VecList x = random_positions(model, 0.3, 9), force = forces_at(tables, x);
  EXPECT_LT(sum(force).norm(), 1e-12 * largest_norm(force));
  EXPECT_LT(torque(x, force).norm(), 1e-12 * largest_norm(force));
}

/// E A t e^2 / 2 with nu across, on every mesh.
TEST(Wall, StretchesWithYoungsModulusAndPoissonsRatio) {
  constexpr double E = 10e3, nu = 0.4, t = 1e-3, a = 0.1, e = 1e-5;
  for (const double jitter : {0.0, 0.25}) {
    const Model model =
        wall_of(grid_surface(5, 4, jitter, [](double u, double v) { return Vec3(a * u, a * v, 0); }), E, nu, t);
    const TopologyTextures tables = build_topology(model);
    VecList x = model.rest;
    for (Vec3& p : x) p = {p.x() * (1.0 + e), p.y() * (1.0 - nu * e), 0.0};
    EXPECT_NEAR(elastic_energy(tables, x), 0.5 * E * a * a * t * e * e, 1e-4 * 0.5 * E * a * a * t * e * e);
    const VecList force = forces_at(tables, x);
    double pull = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) pull -= force[i].x() * model.rest[i].x() / a;
    EXPECT_NEAR(pull, E * a * t * e, 1e-4 * E * a * t * e);
  }
}

/// A constant moment is in equilibrium.
TEST(Wall, BendsWithoutForcesInside) {
  constexpr double E = 10e3, nu = 0.3, t = 1e-3, a = 0.1, k = 1e-3, D = E * t * t * t / 12.0 / (1.0 - nu * nu);
  const Model model =
      wall_of(grid_surface(12, 12, 0.0, [](double u, double v) { return Vec3(a * u, a * v, 0); }), E, nu, t);
  const TopologyTextures tables = build_topology(model);
  VecList x = model.rest;
  for (Vec3& p : x) p.z() = 0.5 * k * p.x() * p.x();
  const VecList force = forces_at(tables, x);
  double edges = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3& X = model.rest[i];
    const double edge = std::min({X.x(), X.y(), a - X.x(), a - X.y()});
    if (edge > 2.5 * a / 12.0) {
      EXPECT_LT(std::abs(force[i].z()), 1e-5 * D * k);
    }
    edges = std::max(edges, std::abs(force[i].z()));
  }
  EXPECT_GT(edges, 0.1 * D * k);
}

TEST(Wall, StepLimitIsThatOfItsVibrations) {
  for (const Model& model : {bowl(false), wall_of(sphere_surface(radius, 3), 10e3, 0.4, 5e-4)}) {
    const TopologyTextures tables = build_topology(model);
    Eigen::VectorXd squares = dense_eigenvalues(tables, tables.rest).real();
    std::ranges::sort(squares);
    const double largest = squares[squares.size() - 1];
    EXPECT_NEAR(estimate_spectrum(tables, tables.rest).largest, largest, 0.01 * largest);
    // Nothing but rigid motion is free of force: no stabiliser is needed.
    EXPECT_LT(std::abs(squares[5]), 1e-7 * largest);
    EXPECT_GT(squares[6], 1e-6 * largest);
  }
}

TEST(Wall, WeighsItsAreaTimesItsThickness) {
  const Model model = wall_of(disc_surface(0.1, 8, 0.0), 10e3, 0.4, 2e-3);
  double mass = 0.0;
  for (const double m : model.mass) mass += m;
  const double sides = 48.0, area = 0.5 * sides * 0.01 * std::sin(2.0 * std::numbers::pi / sides);
  EXPECT_NEAR(mass, 1000.0 * 2e-3 * area, 1e-9);
}

TEST(Wall, IsDividedUntilNoSideIsTooLong) {
  const Material material{.young = 1e4, .poisson = 0.4, .density = 1e3, .thickness = 1e-3};
  const Surface coarse = disc_surface(0.1, 2, 0.0);
  EXPECT_EQ(make_wall(coarse, {.material = material}).cells.size(), coarse.triangles.size());
  Surface noted = coarse;
  noted.notes = {"surface: of a scan"};
  EXPECT_EQ(make_wall(noted, {.material = material}).notes, noted.notes);
  const Model fine = make_wall(coarse, {.spacing = 0.02, .material = material});
  EXPECT_EQ(fine.cells.size(), 16 * coarse.triangles.size());
  EXPECT_TRUE(build_topology(fine).options.law == Law::walls);
}

/// Clamped edges are lines of their own: they are no triangles, which a removed one leaves without any.
TEST(Wall, ClampsEdgesOfOneTriangle) {
  Model wall = bowl(false);
  const int border = clamp_edges(wall, {});
  EXPECT_EQ(border, 2 * (6 + 5));
  EXPECT_TRUE(refuses([&] { clamp_edges(wall, {}); }, "there are none"));
  const std::vector<Index> ends = wall.cells.back().particles;
  for (Cell& cell : wall.cells) {
    const auto has = [&](Index end) { return std::ranges::count(cell.particles, end) == 1; };
    if (cell.type == CellType::triangle && has(ends[0]) && has(ends[1])) cell.share = 0.0;
  }
  const int inner = clamp_edges(wall, [](const Vec3&) { return true; });  // of the hole
  EXPECT_TRUE(inner == 1 || inner == 2) << inner;
  wall.mass[0] = -1.0;
  EXPECT_TRUE(refuses([&] { clamp_edges(wall, {}); }, "expected a positive, finite mass"));
}

TEST(Wall, HasAThicknessForEachGroup) {
  Model wall = wall_of(disc_surface(0.1, 4, 0.0), 1e4, 0.4, 1e-3);
  std::vector<Index> right;
  for (Index i = 0; i < wall.particle_count(); ++i) {
    if (wall.rest[i].x() >= -1e-9) right.push_back(i);
  }
  wall.add_group("right", right);
  set_material(wall, {.young = 1e4, .poisson = 0.4, .density = 1e3, .thickness = 3e-3}, "right");
  ASSERT_EQ(wall.materials.size(), 2u);
  for (const Cell& cell : wall.cells) {
    const bool all_right = std::ranges::all_of(cell.particles, [&](Index i) { return wall.rest[i].x() >= -1e-9; });
    EXPECT_EQ(wall.materials[cell.material].thickness, all_right ? 3e-3 : 1e-3);
  }
}

/// The third is an arrowhead, whose shorter diagonal is outside. Each triangle is in the components that its quad is
/// in.
TEST(Wall, OfQuadsHasTwoTrianglesForEach) {
  Model quads;
  quads.rest = {{0, 0, 0}, {1, 0, 0}, {1.1, 1, 0}, {0, 1, 0},     {2, 0, 1}, {4, 0, 1},
                {5, 1, 1}, {3, 1, 1}, {6, 0, 0},   {10, -0.5, 0}, {9, 0, 0}, {10, 0.5, 0}};
  quads.mass.assign(quads.rest.size(), 1.0);
  quads.stiffness = quads.mass;
  quads.neighbours.offset.assign(quads.rest.size() + 1, 0);
  for (const Index first : {0, 4, 8}) {
    quads.cells.push_back({.type = CellType::quad, .particles = {first, first + 1, first + 2, first + 3}});
  }
  quads.components = {{.name = "all", .cells = {0, 1, 2}}, {.name = "last", .exclusive = false, .cell_refs = {2}}};
  const Material material{.young = 1e4, .poisson = 0.4, .density = 1e3, .thickness = 1e-3};
  Model model = quads;
  set_material(model, material, "last");
  EXPECT_EQ(std::ranges::count(model.cells, CellType::quad, &Cell::type), 2);
  EXPECT_EQ(model.components[1].cell_refs, (std::vector<Index>{2, 3}));
  EXPECT_EQ(model.cells[2].particles, (std::vector<Index>{8, 9, 10}));
  EXPECT_EQ(model.cells[3].particles, (std::vector<Index>{8, 10, 11}));
  set_material(model, material);
  EXPECT_EQ(std::ranges::count(model.cells, CellType::triangle, &Cell::type), 6);
  EXPECT_EQ(model.cells[0].particles, (std::vector<Index>{1, 2, 3}));
  EXPECT_EQ(model.cells[4].particles, (std::vector<Index>{1, 3, 0}));
  EXPECT_EQ(model.components[0].cells, (std::vector<Index>{0, 1, 2, 3, 4, 5}));
  EXPECT_NE(model.notes.back().find("2 quad(s) of a wall"), std::string::npos);
  EXPECT_NEAR(std::accumulate(model.mass.begin(), model.mass.end(), 0.0), 1.05 + 2.0 + 1.5, 1e-12);
  Model first = quads;
  first.rest[2].z() = 1.0;
  const double volume = set_material(first, material, [](const Vec3& at) { return at.x() < 1.0; });
  EXPECT_EQ(first.cells.size(), 4u);
  EXPECT_NEAR(volume, 0.5e-3 * (Vec3(-1, -1, 1.1).norm() + 1.0), 1e-15);  // of two triangles
  EXPECT_NEAR(1e3 * volume, std::accumulate(first.mass.begin(), first.mass.begin() + 4, 0.0), 1e-12);
  quads.rest[10] = quads.rest[9];
  EXPECT_TRUE(message_of([&] { set_material(quads, material); }).starts_with("cell 2 (QUAD): expected a quad with"));
}

TEST(Wall, RefusesWhatItCannotDo) {
  const Material material{.young = 1e4, .poisson = 0.4, .density = 1e3, .thickness = 1e-3};
  const Surface disc = disc_surface(0.1, 2, 0.0);
  EXPECT_EQ(message_of([&] { make_wall(disc, {.material = {.young = 1e4, .poisson = 0.4, .density = 1e3}}); }),
            "make_wall: expected a material with a thickness above 0 m, got 0");
  EXPECT_EQ(message_of([&] { make_wall(disc, {.spacing = 0.0, .material = material}); }),
            "make_wall: expected a spacing above 0 m (infinite: the surface's own triangles), got 0");
  Surface out_of_range = disc;
  out_of_range.triangles[1][2] = 99;
  EXPECT_EQ(message_of([&] { make_wall(out_of_range, {.material = material}); }),
            "make_wall: triangle 1: expected rows of vertices from 0 to 18, got 99");
  Surface flat = disc;
  flat.triangles.push_back({0, 1, 1});
  EXPECT_NE(message_of([&] { make_wall(flat, {.material = material}); }), "");
  Material fibrous = material;
  fibrous.fibre_ratio = 2.0;
  EXPECT_NE(message_of([&] { make_wall(disc, {.material = fibrous}); }).find("neither fibres nor"), std::string::npos);
  Model wall = make_wall(disc, {.material = material});
  EXPECT_NE(message_of([&] { build_topology(wall, {.law = Law::particle_averaged}); }).find("needs Law::walls"),
            std::string::npos);
  EXPECT_NE(message_of([&] { Scene(wall).scale_stiffness(2.0); }).find("without walls"), std::string::npos);
  EXPECT_NE(message_of([&] { clamp_edges(wall, [](const Vec3&) { return false; }); }).find("there are none"),
            std::string::npos);
}

TEST(Wall, IsTheSameAfterAPmlFile) {
  for (Model wall : {bowl(), wall_of(sphere_surface(radius, 2), 10e3, 0.4, 2e-3)}) {
    std::vector<Index> low;
    for (Index i = 0; i < wall.particle_count(); ++i) {
      if (wall.rest[i].y() < 1e-9) low.push_back(i);
    }
    wall.add_group("low", low);
    set_material(wall, {.young = 5e3, .poisson = 0.3, .density = 900.0, .thickness = 3e-3}, "low");
    std::ostringstream written;
    write_pml(wall, written);
    const Model read = read_pml_text(written.str(), "wall.pml");
    EXPECT_EQ(read.materials, wall.materials);
    EXPECT_EQ(fingerprint(build_topology(read)), fingerprint(build_topology(wall)));
  }
}

/// Tables of another thickness are of another body.
TEST(Wall, TablesKnowTheirModel) {
  Model wall = bowl();
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(wall));
  Model thicker = wall;
  thicker.materials[0].thickness *= 2.0;
  EXPECT_NE(fingerprint(build_topology(thicker)), fingerprint(*tables));
  const Scene scene(thicker);
  EXPECT_NE(message_of([&] { make_solver("reference", tables, scene); }).find("another model"), std::string::npos);
}

}  // namespace
}  // namespace phymul::test
