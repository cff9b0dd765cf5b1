// SPDX-License-Identifier: MIT
//
// Walls and cells that fill space in one model: beside each other, and as a capsule on a body's surface.
#include <phymul/load_frame.h>
#include <phymul/phymul.h>

#include <gtest/gtest.h>

#include "model/cell_geometry.h"
#include "support/bodies.h"
#include "support/cpu_forces.h"
#include "support/dense_operator.h"
#include "support/message_of.h"
#include "support/wall_cases.h"
#include "view/display_lists.h"

namespace phymul::test {
namespace {

constexpr double block_length = 0.04, block_side = 0.02;  // m
const Material capsule_flesh{.young = 5e3, .poisson = 0.4, .density = 1000.0};
const Material capsule_skin{.young = 200e3, .poisson = 0.4, .density = 1100.0, .thickness = 1e-3};

/// n cells across; the capsule leaves the ends bare.
Model capsule_of(int n, bool tetrahedra = false) {
  Model model = tetrahedra ? make_tetrahedral_block({block_length, block_side, block_side}, 2 * n, n, n, 0.2, 5)
                           : make_block({block_length, block_side, block_side}, 2 * n, n, n);
  set_material(model, capsule_flesh);
  add_capsule(model, capsule_skin, [](const Vec3& X) { return X.x() > 1e-9 && X.x() < block_length - 1e-9; });
  return model;
}

Model block_and_sheet() {
  const Model block = with_material(make_block({block_length, block_side, block_side}, 4, 2, 2), capsule_flesh);
  const Model sheet = make_wall(
      grid_surface(6, 5, 0.2, [](double u, double v) { return Vec3(0.06 + 0.03 * u, 0.03 * v, 0.01 * u * v); }),
      {.material = capsule_skin});
  return merged({{"block", &block}, {"sheet", &sheet}});
}

std::vector<Model> bodies_of_both() {
  std::vector<Model> all{capsule_of(2), capsule_of(2, true), block_and_sheet()};
  return all;
}

TEST(WallBeside, HasTheLawOfCellsAndWallsBesides) {
  for (const Model& model : bodies_of_both()) {
    const TopologyTextures tables = build_topology(model);
    EXPECT_EQ(tables.options.law, Law::particle_averaged);
    EXPECT_FALSE(tables.walls.empty());
    EXPECT_FALSE(tables.domains.empty());
  }
}

/// Pressure, springs and pictures have the walls beside cells, and a capsule once with the face that it is on.
TEST(WallBeside, SurfaceHasTheWalls) {
  const Model beside = block_and_sheet(), in_capsule = capsule_of(2, true);
  for (const Model* model : {&beside, &in_capsule}) {
    const bool apart = model == &beside;
    const std::vector<Index> pressed =
        model->particles_in([&](const Vec3& X) { return !apart || X.x() > block_length + 1e-9; });
    double area = 0.0;  // m^2
    for (const Cell& cell : model->cells) {
      if (apart && cell.type == CellType::triangle) area += area_vector(cell.particles, model->rest).norm();
    }
    if (!apart) area = 2.0 * block_side * block_side + 4.0 * block_side * block_length;
    Scene scene(*model);
    Load load{.type = LoadType::pressure, .events = {{0.0, 100.0}}, .direction = {0, 0, 1}};
    load.particles = pressed;
    scene.add(load);
    LoadFrame frame;
    scene.prepare(frame);
    scene.evaluate(0.0, frame);
    EXPECT_NEAR(sum(frame.force).z(), 100.0 * area, 1e-9 * area);
    scene.attach(pressed, World{}, {.stiffness = 1e6});
    double shares = 0.0;
    for (const JointSpring& spring : scene.joints().back().joint.springs) shares += spring.share;
    EXPECT_NEAR(shares, area, 1e-9 * area);
    double drawn = 0.0;
    for (const auto& face : display_lists(*model).faces) {
      drawn += area_vector(std::span(face).first(face[3] < 0 ? 3 : 4), model->rest).norm();
    }
    const double block_area = 2.0 * block_side * block_side + 4.0 * block_side * block_length;
    EXPECT_NEAR(drawn, apart ? area + block_area : area, 1e-9 * drawn);
  }
}

TEST(WallBeside, ForcesAreTheSlopeOfTheEnergyAndKeepMomenta) {
  for (const Model& model : bodies_of_both()) {
    const TopologyTextures tables = build_topology(model);
    const VecList x = random_positions(model, 0.1, 7), force = forces_at(tables, x);
    EXPECT_LT(sum(force).norm(), 1e-11 * largest_norm(force));
    EXPECT_LT(torque(x, force).norm(), 1e-12 * largest_norm(force));
    const std::size_t some[] = {0, 9, x.size() / 2, x.size() - 1};
    expect_slope_of_energy(tables, x, 1e-6 * mean_spacing(model), some);
  }
}

TEST(WallBeside, WeighsBoth) {
  const Model model = capsule_of(4);
  double mass = 0.0;
  for (const double m : model.mass) mass += m;
  EXPECT_NEAR(mass, 1000.0 * block_length * block_side * block_side + 1100.0 * 1e-3 * 4.0 * block_side * block_length,
              1e-12);
}

TEST(WallBeside, StepLimitIsThatOfAllVibrations) {
  for (const Model& model : bodies_of_both()) {
    const TopologyTextures tables = build_topology(model);
    const double largest = dense_eigenvalues(tables, tables.rest).real().maxCoeff();
    EXPECT_NEAR(estimate_spectrum(tables, tables.rest).largest, largest, 0.01 * largest);
  }
}

/// Pulled, a block in a capsule has the E A of both, on every mesh; 8 to 1 here.
TEST(WallBeside, CapsuleAddsItsStiffness) {
  constexpr double e = 1e-5;
  const double stiffness =
      capsule_flesh.young * block_side * block_side + capsule_skin.young * capsule_skin.thickness * 4.0 * block_side;
  for (const Model& model : {capsule_of(3), capsule_of(6), capsule_of(4, true)}) {
    const TopologyTextures tables = build_topology(model);
    VecList x = model.rest;
    for (Vec3& p : x) p = Vec3(p.x() * (1.0 + e), p.y() * (1.0 - 0.4 * e), p.z() * (1.0 - 0.4 * e));
    EXPECT_NEAR(elastic_energy(tables, x) / (0.5 * stiffness * e * e * block_length), 1.0, 1e-3);
  }
}

TEST(WallBeside, ForcesOfCpuAreWithinTheRoundingBound) {
  ShareOfBound worst;
  std::vector<Model> all = bodies_of_both();
  all.push_back(capsule_of(6));        // a lattice of several clusters
  all.push_back(capsule_of(6, true));  // unstructured
  for (const Model& model : all) {
    const auto tables = std::make_shared<const TopologyTextures>(build_topology(model));
    const Scene scene(model);
    for (const double amount : {0.01, 0.2}) {
      worst.look(tables, scene, random_displacements(model, amount, 5), std::to_string(model.particle_count()), {1, 2});
    }
  }
  worst.expect_some();
}

TEST(WallBeside, KeepsItsEnergyAndBothBackendsMoveAlike) {
  const Model model = capsule_of(2);
  const Scene scene(model);
  State end[2];
  for (const char* backend : {"reference", "cpu"}) {
    const auto solver = make_solver(backend, model, scene);
    State state = rest_state(model);
    for (std::size_t i = 0; i < model.rest.size(); ++i) state.velocity[i].z() = 2.0 * (model.rest[i].x() - 0.02);
    solver->reset(state);
    const double dt = 0.9 * solver->stable_step();
    ASSERT_TRUE(solver->step(20, dt).ok());
    const double first = solver->energy().total();
    for (int k = 0; k < 10; ++k) {
      ASSERT_TRUE(solver->step(200, dt).ok());
      EXPECT_NEAR(solver->energy().total(), first, 1e-3 * first) << backend;
      if (k == 0) solver->read(end[backend[0] == 'c']);
    }
  }
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    EXPECT_LT((end[0].position[i] - end[1].position[i]).norm(), 1e-3 * block_side);
  }
}

TEST(WallBeside, RestStaysAtRestExactlyAndBitsDoNotDependOnThreads) {
  const Model model = capsule_of(6);
  const Scene alone(model);
  const auto resting = make_solver("cpu", model, alone);
  ASSERT_TRUE(resting->step(50, 0.5 * resting->stable_step()).ok());
  EXPECT_EQ(resting->read().position, model.rest);
  State end[2];
  for (const int threads : {1, 2}) {
    Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
    const auto solver = make_solver("cpu", model, scene, {}, {.threads = threads});
    ASSERT_TRUE(solver->step(50, 0.5 * solver->stable_step()).ok());
    solver->read(end[threads - 1]);
  }
  EXPECT_EQ(end[0], end[1]);
}

TEST(WallBeside, CapsuleHasAThicknessForEachRegionAndOutlivesANewMaterial) {
  Model model = with_material(make_block({block_length, block_side, block_side}, 4, 2, 2), capsule_flesh);
  model.components.clear();
  EXPECT_EQ(add_capsule(model, capsule_skin), 2 * (2 * 4 + 4 * 8));
  EXPECT_TRUE(model.components.empty());
  Material thick = capsule_skin;
  thick.thickness = 3e-3;
  set_material(model, thick, [](const Vec3& X) { return X.x() > 0.5 * block_length; });
  set_material(model, {.young = 8e3, .poisson = 0.3, .density = 1000.0});
  int with_thickness[2] = {0, 0};
  for (const Cell& cell : model.cells) {
    const double t = model.materials[cell.material].thickness;
    if (cell.type != CellType::triangle) {
      EXPECT_EQ(t, 0.0);
      continue;
    }
    ++with_thickness[t == 3e-3];
    double x = 0.0;
    for (const Index i : cell.particles) x += model.rest[i].x() / 3.0;
    EXPECT_EQ(t, x > 0.5 * block_length ? 3e-3 : 1e-3);
  }
  EXPECT_EQ(with_thickness[0], 40);
  EXPECT_EQ(with_thickness[1], 40);
  // Contacts, tools and pressure see one surface.
  EXPECT_EQ(surface_triangles(model).size(), 80u);
  EXPECT_NEAR(Scene(model).constrain_volume().volume_constraints().front().volume,
              block_length * block_side * block_side, 1e-18);
}

TEST(WallBeside, RefusesWhatItCannotDo) {
  Model model = capsule_of(2);
  EXPECT_NE(message_of([&] { add_capsule(model, capsule_skin); }).find("is a wall on that surface already"),
            std::string::npos);
  EXPECT_NE(message_of([&] { add_capsule(model, capsule_flesh); }).find("a thickness above 0"), std::string::npos);
  EXPECT_NE(
      message_of([&] { add_capsule(model, capsule_skin, [](const Vec3&) { return false; }); }).find("there are none"),
      std::string::npos);
  EXPECT_NE(message_of([&] { build_topology(model, {.law = Law::walls}); }).find("walls alone"), std::string::npos);
  Model wrong = model;
  for (Cell& cell : wrong.cells) {
    if (is_volume(cell.type)) cell.material = 1 - cell.material;
  }
  EXPECT_NE(message_of([&] { build_topology(wrong); }).find("fills space, but its material has a thickness"),
            std::string::npos);
  Simulation sim(model, {.solver = {.sleep_tolerance = 1e-3}});
  bool warned = false;
  for (const std::string& warning : sim.warnings()) warned = warned || warning.find("walls") != std::string::npos;
  EXPECT_TRUE(warned);
}

// Walls that branch: strips that meet in a T against frames of beams.

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
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < model.rest.size(); i += 17) some.push_back(i);
  expect_slope_of_energy(tables, random_positions(model, 0.2, 7), 1e-6 * mean_spacing(model), some);
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
