// SPDX-License-Identifier: MIT
//
// Walls and cells that fill space in one model: beside each other, and as a capsule on a body's surface.
#include <gtest/gtest.h>
#include <phymul/elasticity.h>
#include <phymul/load_frame.h>
#include <phymul/simulation.h>

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
    Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
    for (std::size_t i = 0; i < x.size(); ++i) sum += force[i], moment += x[i].cross(force[i]);
    EXPECT_LT(sum.norm(), 1e-11 * largest_norm(force));
    EXPECT_LT(moment.norm(), 1e-12 * largest_norm(force));
    const double h = 1e-6 * mean_spacing(model);
    for (const std::size_t i : {std::size_t{0}, std::size_t{9}, x.size() / 2, x.size() - 1}) {
      for (int axis = 0; axis < 3; ++axis) {
        VecList up = x, down = x;
        up[i][axis] += h;
        down[i][axis] -= h;
        const double slope = (elastic_energy(tables, up) - elastic_energy(tables, down)) / (2.0 * h);
        EXPECT_NEAR(force[i][axis], -slope, 2e-5 * largest_norm(force)) << "particle " << i << ", axis " << axis;
      }
    }
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

}  // namespace
}  // namespace phymul::test
