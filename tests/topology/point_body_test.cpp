// SPDX-License-Identifier: MIT
//
// Law::particle_averaged on bodies of points: particles with neighbours and a material, but no cells.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "model/cell_geometry.h"
#include "support/failure_states.h"
#include "support/mechanics.h"
#include "support/message_of.h"
#include "support/point_clouds.h"

namespace phymul::test {
namespace {

const TopologyOptions averaged{.law = Law::particle_averaged};

double volume(const Model& model) {
  return total_mass(model) / 1000.0;  // of soft_tissue
}

double energy_of_cells(const Mat3& F, double poisson) {
  const Model one = with_material(make_block({0.01, 0.01, 0.01}, 1, 1, 1), soft_tissue(poisson));
  const TopologyTextures tables = build_topology(one, averaged);
  VecList x = tables.rest;
  for (Vec3& p : x) p = F * p;
  return elastic_energy(tables, x) / volume(one);
}

/// Points on the sides of a box span it; points thrown into it only what is between them.
TEST(PointBody, VolumesAddUpToWhatThePointsSpan) {
  for (const Body& body : clouds()) {
    const double part = volume(body.model) / beam.prod();
    std::printf("%s: %zu points, %.1f neighbours, volume %.4f of the box\n", body.name.c_str(), body.model.rest.size(),
                static_cast<double>(body.model.neighbours.entry.size()) / static_cast<double>(body.model.rest.size()),
                part);
    if (body.name == "random") {
      EXPECT_NEAR(part, 0.81, 0.03);
    } else if (body.name == "random, apart") {
      EXPECT_NEAR(part, 0.92, 0.02);
    } else if (body.name.starts_with("cylinder")) {
      const double octagon = 2.0 * std::sqrt(2.0) * 0.01 * 0.01 * 0.04;
      EXPECT_NEAR(volume(body.model), octagon, 0.01 * octagon);
    } else {
      EXPECT_NEAR(part, 1.0, 0.002) << body.name;
    }
    ASSERT_EQ(body.model.notes.size(), 1u);
    EXPECT_TRUE(body.model.notes[0].starts_with("set_material: no cell fills space; the particles are taken for a"));
  }
}

TEST(PointBody, UniformStrainIsExactOnEveryCloud) {
  Mat3 F;
  F << 1.1, 0.07, 0.04, -0.05, 0.93, -0.06, 0.02, 0.03, 1.05;
  const double nu = 0.45, density = energy_of_cells(F, nu);
  for (Body body : clouds()) {
    set_material(body.model, soft_tissue(nu));
    for (const double s : {0.0, 1.0}) {
      const TopologyTextures tables = build_topology(body.model, {.law = averaged.law, .stabiliser = s});
      VecList x = tables.rest;
      for (Vec3& p : x) p = F * p;
      const double expected = density * volume(body.model);
      EXPECT_NEAR(elastic_energy(tables, x), expected, 1e-11 * expected) << body.name << ", s " << s;
    }
  }
}

/// Nothing is gained by any motion, and uniform strain alone costs nothing of it (the test above).
TEST(PointBody, TheStabiliserIsNeverNegative) {
  for (const Body& body : clouds()) {
    const TopologyTextures without = build_topology(body.model, {.law = averaged.law, .stabiliser = 0.0});
    const TopologyTextures with = build_topology(body.model, {.law = averaged.law, .stabiliser = 1.0});
    double least = std::numeric_limits<double>::infinity();
    const auto look = [&](const VecList& x) {
      least = std::min(least, elastic_energy(with, x) - elastic_energy(without, x));
    };
    for (std::uint32_t seed = 0; seed < 20; ++seed) look(random_positions(body.model, 0.1, seed));
    for (Index i = 0; i < body.model.particle_count(); i += 7) {  // one particle alone
      VecList x = body.model.rest;
      x[i] += 0.1 * mean_spacing(body.model) * Vec3(0.6, -0.3, 0.7);
      look(x);
    }
    EXPECT_GT(least, 0.0) << body.name;
  }
}

TEST(PointBody, MomentumIsKeptAndForcesAreTheSlopeOfTheEnergy) {
  for (const Body& body : clouds()) {
    const TopologyTextures tables = build_topology(body.model, averaged);
    VecList force(body.model.rest.size());
    const VecList x = random_positions(body.model, 0.1, 2);
    elastic_forces(tables, x, force);
    const double scale = largest_norm(force);
    EXPECT_LE(sum(force).norm(), 1e-11 * norm(force)) << body.name;
    EXPECT_LE(torque(x, force).norm(), 1e-11 * norm(force) * body_size(body.model)) << body.name;
    const double h = 1e-5 * mean_spacing(body.model);
    VecList plus = x, minus = x;
    double slope = 0.0;
    std::mt19937 bits(3);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Vec3 way = random_vector(bits, 3);
      plus[i] += h * way;
      minus[i] -= h * way;
      slope -= force[i].dot(way);
    }
    const double found = (elastic_energy(tables, plus) - elastic_energy(tables, minus)) / (2.0 * h);
    EXPECT_NEAR(found, slope, 1e-5 * std::abs(slope) + 1e-7 * norm(force)) << body.name;
    elastic_forces(tables, rigidly_moved(body.model, 5), force);
    EXPECT_LE(largest_norm(force), 1e-9 * scale) << body.name;
  }
}

TEST(PointBody, StretchBetweenPlatesHasTheMaterialsConstants) {
  for (const double nu : {0.0, 0.3, 0.45}) {
    for (const Body& body : clouds()) {
      if (!body.model.has_group("x0")) continue;  // no points on the plates
      const Model model = with_material(body.model, soft_tissue(nu));
      const Moduli found = stretch_block(model, build_topology(model, averaged), 1e-3);
      std::printf("%s, nu %.2f: E %.4f of the material's, nu %.4f\n", body.name.c_str(), nu, found.young / 10e3,
                  found.poisson);
      EXPECT_NEAR(found.young, 10e3, 0.05 * 10e3) << body.name;
      EXPECT_NEAR(found.poisson, nu, 0.03) << body.name;
    }
  }
}

TEST(PointBody, CantileversBendAsTheyShould) {
  for (const double nu : {0.0, 0.3, 0.45}) {
    for (const Body& body : clouds()) {
      if (!body.model.has_group("x0")) continue;
      const Model model = with_material(body.model, soft_tissue(nu));
      const TopologyTextures tables = build_topology(model, averaged);
      const double ratio = cantilever_ratio(model, tables, soft_tissue(nu), Root::clamped);
      std::printf("%s, nu %.2f: s %.3f, tip at %.4f of the beam's\n", body.name.c_str(), nu, *tables.options.stabiliser,
                  ratio);
      EXPECT_NEAR(ratio, 1.0, 0.1) << body.name << ", nu " << nu;
    }
  }
}

/// Without a point on its sides a body has no root face and no cross section of its own. Here the points near the root
/// are held on the beam's line, and the beam is one of the volume and second moment of area that the points span.
TEST(PointBody, RandomCloudsBendAsTheBodyTheySpan) {
  const double L = beam.x(), H = beam.z(), g = 1e-3, nu = 0.3, mu = 10e3 / 2.6;
  const double cowper = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
  for (const Body& body : clouds()) {
    if (!body.name.starts_with("random")) continue;
    const Model& model = body.model;
    const std::vector<PointCell> cells = point_cells(model, point_neighbours(model));
    double area = 0.0, inertia = 0.0, height = 0.0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      height += (cells[i].volume * model.rest[i].z() + cells[i].first.z()) / volume(model);
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const double z = model.rest[i].z() - height;
      area += cells[i].volume / L;
      inertia += (cells[i].volume * z * z + 2.0 * z * cells[i].first.z() + cells[i].second(2, 2)) / L;
    }
    const double q = 1000.0 * g * area;
    const auto drop = [&](double x) {
      return q / (24.0 * 10e3 * inertia) * x * x * (x * x - 4.0 * L * x + 6.0 * L * L) +
             q / (cowper * mu * area) * x * (L - 0.5 * x);
    };
    const double near = 0.8 * std::cbrt(beam.prod() / 1000.0);
    std::vector<std::uint8_t> fixed(cells.size(), 0);
    VecList load(cells.size()), x = model.rest;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      load[i] = {0.0, 0.0, -g * model.mass[i]};
      if (model.rest[i].x() > near) continue;
      fixed[i] = 7;
      x[i].z() -= drop(model.rest[i].x());
    }
    const TopologyTextures tables = build_topology(model, averaged);
    const VecList u = StaticSolve(tables, fixed, load).linear(x);
    double found = 0.0, expected = 0.0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (model.rest[i].x() < L - near) continue;
      found -= u[i].z() + x[i].z() - model.rest[i].z();
      expected += drop(model.rest[i].x());
    }
    std::printf("%s: s %.3f, second moment of area %.3f of the box's, tip at %.4f of that beam's\n", body.name.c_str(),
                *tables.options.stabiliser, inertia / (H * H * H * H / 12.0), found / expected);
    EXPECT_NEAR(found / expected, 1.0, 0.15) << body.name;
  }
}

TEST(PointBody, StepsNearTheLimitDoNotGrow) {
  for (const Body& body : clouds()) {
    const Scene scene(body.model);
    for (const char* backend : {"reference", "cpu"}) {
      const auto solver = make_solver(backend, body.model, scene, averaged);
      const double dt = 0.9 * solver->stable_step();
      solver->start(displaced(body.model, 1e-3, 4), dt);
      ASSERT_TRUE(solver->step(100, dt).ok());
      const double before = solver->energy().total();
      ASSERT_TRUE(solver->step(1000, dt).ok()) << body.name;
      EXPECT_NEAR(solver->energy().total(), before, 0.02 * before) << body.name << ", " << backend;
    }
  }
}

TEST(PointBody, BackendsAgree) {
  for (const Body& body : clouds()) {
    const Scene scene(body.model);
    const auto reference = make_solver("reference", body.model, scene, averaged);
    const auto cpu = make_solver("cpu", body.model, scene, averaged);
    const State state = displaced(body.model, 0.1, 4);
    const double dt = 0.5 * reference->stable_step();
    for (Solver* solver : {reference.get(), cpu.get()}) {
      solver->reset(state);
      ASSERT_TRUE(solver->step(50, dt).ok());
    }
    const VecList expected = reference->read().position, found = cpu->read().position;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_LE((expected[i] - found[i]).norm(), 1e-4 * mean_spacing(body.model)) << body.name << ", particle " << i;
    }
  }
}

TEST(PointBody, BrokenStatesHeal) {
  constexpr double side = 0.02;
  const Vec3 size = Vec3::Constant(side);
  int lost = 0, all = 0;
  for (Model model : {jittered_lattice(size, 3, 0.2), sampled_box(size, 0.005, 2)}) {
    for (const double poisson : {0.3, 0.45}) {
      set_material(model, soft_tissue(poisson));
      const Scene scene(model);
      const auto solver = make_solver("cpu", model, scene, averaged, {.damping = {.factor = 0.99}});
      for (const FailureState& failure : failure_states()) {
        std::mt19937 bits(5);
        State state = rest_state(model);
        failure.apply(state.position, side, side / 3, bits);
        solver->reset(state);
        const StepReport report = solver->step(12000, 0.5 * solver->stable_step());
        ++all;
        // The energy of a uniform strain of about 0.5 %: nothing folded is left.
        if (report.ok() && solver->energy().elastic < 1e-5 * 10e3 * side * side * side) continue;
        ++lost;
        ADD_FAILURE() << failure.name << ", nu " << poisson << ", " << model.rest.size()
                      << " points: " << solver->energy().elastic / (10e3 * side * side * side) << ' '
                      << report.message();
      }
    }
  }
  std::printf("%d of %d broken states came back\n", all - lost, all);
}

/// The particles and neighbourhoods of a file, its cells left out.
TEST(PointBody, NeighbourhoodsOfAFileMakeABody) {
  Model file = read_pml(PHYMUL_SAMPLE_DATA "/cylinder_275.pml");
  Model whole = file, points = file;
  points.cells.clear();
  for (Component& component : points.components) component.cells.clear(), component.cell_refs.clear();
  points.extras = nullptr;
  set_material(whole, soft_tissue());
  set_material(points, soft_tissue());
  EXPECT_EQ(points.neighbours, file.neighbours);
  EXPECT_NEAR(volume(points), volume(whole), 0.01 * volume(whole));
  double low = 1.0, high = 0.0;
  for (const Vec3& p : file.rest) low = std::min(low, p.z()), high = std::max(high, p.z());
  const auto drop = [&](const Model& model, double& s) {
    const TopologyTextures tables = build_topology(model, averaged);
    s = *tables.options.stabiliser;
    std::vector<std::uint8_t> fixed(model.rest.size(), 0);
    VecList load(model.rest.size());
    for (std::size_t i = 0; i < load.size(); ++i) {
      fixed[i] = model.rest[i].z() < low + 1e-6 ? 7 : 0;
      load[i] = {1e-3 * model.mass[i], 0.0, 0.0};
    }
    const VecList u = StaticSolve(tables, fixed, load).linear(model.rest);
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < load.size(); ++i) {
      if (model.rest[i].z() > high - 1e-6) sum += u[i].x(), ++count;
    }
    return sum / count;
  };
  double s_points = 0.0, s_whole = 0.0;
  const double ratio = drop(points, s_points) / drop(whole, s_whole);
  std::printf("cylinder_275.pml: %.1f neighbours, s %.3f, tip at %.4f of that with cells (s %.3f)\n",
              static_cast<double>(points.neighbours.entry.size()) / 275.0, s_points, ratio, s_whole);
  EXPECT_NEAR(ratio, 1.0, 0.1);
}

TEST(PointBody, PlaneBodiesOfPoints) {
  Model strip = without_cells(make_strip(0.2, 0.05, 16, 4));
  std::mt19937 bits(2);
  for (Vec3& p : strip.rest) {
    const Vec3 move = 0.2 * 0.0125 * random_vector(bits, 2);
    if (p.x() > 1e-9 && p.x() < 0.2 - 1e-9) p.x() += move.x();
    if (p.y() > 1e-9 && p.y() < 0.05 - 1e-9) p.y() += move.y();
  }
  strip.neighbours = nearest_neighbours(strip.rest, 8);
  set_material(strip, soft_tissue());
  EXPECT_NEAR(volume(strip), 0.2 * 0.05, 0.002 * 0.2 * 0.05);
  const TopologyTextures tables = build_topology(strip, averaged);
  Mat3 F = Mat3::Identity();
  F.topLeftCorner<2, 2>() << 1.1, 0.07, -0.05, 0.93;
  VecList x = tables.rest;
  for (Vec3& p : x) p = F * p;
  const double expected = energy_of_cells(F, 0.3) * volume(strip);
  EXPECT_NEAR(elastic_energy(tables, x), expected, 1e-11 * expected);
  std::printf("strip: s %.3f\n", *tables.options.stabiliser);
}

TEST(PointBody, WithoutNeighboursGetsTheNearestOnes) {
  Model given = jittered_lattice({0.02, 0.02, 0.02}, 2, 0.2), bare = given;
  given.neighbours = nearest_neighbours(given.rest, 20);
  bare.neighbours = RaggedList{};
  for (Model* model : {&given, &bare, &bare}) set_material(*model, soft_tissue());
  EXPECT_EQ(bare.neighbours, given.neighbours);
  EXPECT_EQ(bare.mass, given.mass);
  EXPECT_EQ(bare.notes, given.notes);  // said once
}

TEST(PointBody, NonsenseIsRefusedWithWhatToDo) {
  const auto refused = [](const Model& model) { return message_of([&] { build_topology(model, averaged); }); };
  const Model good = with_material(jittered_lattice({0.03, 0.03, 0.03}, 3, 0.2));
  EXPECT_EQ(refused(good), "(no error)");
  Model lonely = good;
  lonely.neighbours = RaggedList{};
  for (Index i = 0; i < good.particle_count(); ++i) {
    const Index* first = good.neighbours.begin(i);
    lonely.neighbours.push_row(first, i == 5 ? first : good.neighbours.end(i));
  }
  EXPECT_TRUE(says(refused(lonely), "particle 5 has 0 neighbours"));
  EXPECT_TRUE(says(refused(lonely), "expected at least 4 that are not all in one plane"));
  Model two = good;
  two.materials.push_back(soft_tissue(0.1));
  EXPECT_TRUE(says(refused(two), "one material for all its particles, this one has 2"));
  Model heavy = good;
  for (double& m : heavy.mass) m = 1.0;
  EXPECT_TRUE(says(refused(heavy), "call set_material"));
  Model flat = good;
  for (Vec3& p : flat.rest) p.z() = 0.01;
  EXPECT_TRUE(refuses([&] { set_material(flat, soft_tissue()); }, "not in one plane"));
  Material fibrous = soft_tissue();
  fibrous.fibre_ratio = 5.0;
  EXPECT_TRUE(refuses([model = good, &fibrous]() mutable { set_material(model, fibrous); }, "has no fibres"));
  EXPECT_TRUE(refuses([] { nearest_neighbours({Vec3::Zero()}, 1); }, "nearest_neighbours: expected 1 to 0"));
}

TEST(PointBody, TablesOfAnotherMaterialAreNoticed) {
  Model model = with_material(jittered_lattice({0.03, 0.03, 0.03}, 3, 0.2));
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, averaged));
  model.materials.front().young *= 2.0;
  const Scene scene(model);
  EXPECT_NE(message_of([&] { make_solver("cpu", tables, scene); }), "(no error)");
}

}  // namespace
}  // namespace phymul::test
