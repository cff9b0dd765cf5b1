// SPDX-License-Identifier: MIT
//
// Forces of the vector backend, kind of body by kind of body, within the bound of rounding. Law::walls on the backend
// "cpu": forces within the rounding bound by every instruction set, the energy over many steps, broken states.
#include <gtest/gtest.h>
#include <phymul/elasticity.h>

#include <algorithm>
#include <iostream>
#include <random>
#include <string_view>

#include "cpu/packed/packed_body.h"
#include "elastic/dissipation.h"
#include "support/bodies.h"
#include "support/cpu_forces.h"
#include "support/failure_states.h"
#include "support/wall_cases.h"

namespace phymul::test {
namespace {

struct Deformation {
  const char* name;
  Mat3 gradient;
};

Mat3 stretch(double x, double y, double z) {
  return Vec3(x, y, z).asDiagonal();
}
Mat3 shear(double xy) {
  Mat3 F = Mat3::Identity();
  F(0, 1) = xy;
  return F;
}

/// Around both bounds of triple_lengths.h: edges of twice their length, triangles of a quarter of their area.
std::vector<Deformation> deformations() {
  return {{"small", shear(1e-4)},
          {"sheared 0.01", shear(0.01)},
          {"stretched 1.9", stretch(1.9, 1.0, 1.0)},
          {"stretched 2.1", stretch(1.0, 2.1, 1.0)},
          {"stretched 10", stretch(1.0, 1.0, 10.0)},
          {"grown 1.9", stretch(1.9, 1.9, 1.9)},
          {"grown 3", stretch(3.0, 3.0, 3.0)},
          {"sheared 1", shear(1.0)},
          {"sheared 3", shear(3.0)},
          {"squashed to 0.3", stretch(0.3, 1.0, 1.0)},
          {"squashed to 0.1", stretch(1.0, 0.1, 1.0)},
          {"shrunk to 0.6", stretch(0.6, 0.6, 0.6)},
          {"shrunk to 0.2", stretch(0.2, 0.2, 0.2)},
          {"flat", stretch(1.0, 1.0, 0.0)},
          {"mirrored", stretch(-1.0, 1.0, 1.0)}};
}

/// Lattices, whose slices share constants, and bodies of which no two particles see the same.
std::vector<Body> enumerable_bodies() {
  Model shaken = make_block({0.03, 0.03, 0.03}, 3, 3, 3, 14);
  std::mt19937 bits(5);
  shake(shaken.rest, 0.002, bits);
  Model in_line = make_block({0.03, 0.03, 0.03}, 3, 3, 3, 14);  // all but in line, many triples of neighbours
  shake(in_line.rest, 1e-6, bits);
  return {{"in line", in_line},
          {"6 neighbours", make_block({0.04, 0.03, 0.03}, 4, 3, 3, 6)},
          {"14 neighbours", make_block({0.03, 0.03, 0.03}, 3, 3, 3, 14)},
          {"uneven", shaken},
          {"tetrahedra", make_tetrahedral_block({0.03, 0.03, 0.03}, 3, 3, 3, 0.2, 7)},
          {"cylinder", cylinder_275()}};
}

TEST(TripleLengths, FarFromRestForcesAreWithinTheRoundingBound) {
  ShareOfBound shares;
  for (const Body& body : enumerable_bodies()) {
    for (const Reaction reaction : {Reaction::shared, Reaction::averaged}) {
      const auto tables = std::make_shared<const TopologyTextures>(
          build_topology(body.model, {.reaction = reaction, .bases = BaseSelection::all}));
      const Scene scene(body.model);
      for (const auto& [name, gradient] : deformations()) {
        VecList u = random_displacements(body.model, 0.1 * (gradient - Mat3::Identity()).norm(), 3);
        for (std::size_t i = 0; i < u.size(); ++i) {
          u[i] += gradient * tables->rest[i] - tables->rest[i];
          u[i] = u[i].cast<float>().cast<double>();
        }
        shares.look(tables, scene, u, body.name + ", " + name);
      }
    }
  }
  shares.expect_some();
}

/// What a lattice's particles see is the same but at its faces, wherever it lies.
TEST(TripleLengths, ParticlesThatSeeTheSameShareConstants) {
  const auto bytes_a_particle = [](const Model& model) {
    const TopologyTextures tables = build_topology(model, {.reaction = Reaction::shared, .bases = BaseSelection::all});
    return cpu::make_packed_body(tables, 8)->bytes_a_step() / model.particle_count();
  };
  Model lattice = make_block({0.15, 0.15, 0.15}, 15, 15, 15, 14);
  const double shared = bytes_a_particle(lattice);
  for (Vec3& p : lattice.rest) p += Vec3(0.3, -0.2, 0.1);
  EXPECT_NEAR(bytes_a_particle(lattice), shared, 0.05 * shared);
  std::mt19937 bits(5);
  shake(lattice.rest, 1e-4, bits);
  EXPECT_LT(shared, 0.6 * bytes_a_particle(lattice));
}

// Lattices of Law::particle_averaged, whose links go run by run (simd::Runs).

struct Lattice {
  std::string name;
  Model model;
  bool taken = true;
};

/// Its top pressed in around the middle.
Model dented(Model model) {
  for (Vec3& x : model.rest) {
    const double r = (x - Vec3(0.12, 0.06, 0.06)).norm();
    if (r < 0.025) x += (0.025 - r) * Vec3(0.03, 0.02, -0.3);
  }
  return model;
}

std::vector<Lattice> lattices() {
  const Model block = make_block({0.24, 0.12, 0.06}, 24, 12, 6);
  Model halves = with_material(block);
  halves.add_group("left", halves.particles_in([](const Vec3& X) { return X.x() < 0.125; }));
  set_material(halves, {50e3, 0.3, 1000.0}, "left");
  std::vector<Lattice> all;
  all.push_back({"block", with_material(block)});
  all.push_back({"far", moved(with_material(block), {0.3, -0.2, 0.1})});
  all.push_back({"uneven", with_material(make_block({0.05, 0.24, 0.09}, 6, 24, 7))});
  all.push_back({"dent", with_material(dented(block))});
  all.push_back({"two materials", halves});
  all.push_back({"strip", with_material(make_strip(0.4, 0.1, 40, 10))});
  all.push_back({"tetrahedra", with_material(make_tetrahedral_block({0.06, 0.06, 0.06}, 6, 6, 6, 0.2, 5)), false});
  return all;
}

TEST(CpuRuns, LatticesAreTaken) {
  for (const Lattice& body : lattices()) {
    const TopologyTextures tables = build_topology(body.model, {});
    for (const int lanes : {4, 8, 16}) {
      const auto packed = cpu::make_packed_body(tables, lanes);
      const cpu::PackedRuns& runs = packed->averages.runs;
      EXPECT_EQ(!runs.empty(), body.taken) << body.name << ", " << lanes;
      if (runs.empty()) continue;
      EXPECT_EQ(runs.runs.back().first, packed->averages.slots);
      // The ends of a line are alone, and some lanes of its last slice idle.
      const double least = body.name == "block" ? 0.35 * lanes : 0.2 * lanes;
      EXPECT_GT(runs.slot_links, least * runs.run_links) << body.name << ", " << lanes;
    }
  }
}

TEST(CpuRuns, EqualConstantsAreThereOnce) {
  const TopologyTextures tables = build_topology(with_material(make_block({0.24, 0.12, 0.06}, 24, 12, 6)), {});
  // Inside, on faces, edges and corners; and what stands for nothing.
  EXPECT_LE(cpu::make_packed_body(tables, 8)->averages.runs.stencils.size(), 28u);
}

TEST(CpuRuns, ForcesAreWithinTheRoundingBound) {
  ShareOfBound shares;
  for (const Lattice& body : lattices()) {
    const auto tables = std::make_shared<const TopologyTextures>(build_topology(body.model, {}));
    const Scene scene(body.model);
    for (const double amount : {0.001, 0.2}) {
      shares.look(tables, scene, random_displacements(body.model, amount, 11), body.name, {1, 3});
    }
  }
}

StrainMemory random_strains(const TopologyTextures& topology) {
  std::mt19937 bits(17);
  StrainMemory strains(topology.domains.size() * kept_strains(topology).count());
  for (Strain& strain : strains) {
    for (double& e : strain) e = static_cast<float>(0.1 * uniform(bits));
  }
  return strains;
}

TEST(CpuDissipation, ForcesAreWithinTheRoundingBound) {
  std::vector<Body> all = bodies();
  all.push_back({"lattice", make_block({0.2, 0.06, 0.06}, 20, 6, 6)});
  double worst = 0.0;
  for (const Body& body : all) {
    for (const int kinds : {1, 2, 3}) {
      Model model = body.model;
      Material material = soft_tissue();
      if ((kinds & 1) != 0) material.retardation_time = 2e-3;
      if ((kinds & 2) != 0) material.relaxation_strength = 1.5;
      material.relaxation_time = 0.01;
      set_material(model, material);
      const auto tables =
          std::make_shared<const TopologyTextures>(build_topology(model, {.on_sparse = SparseParticle::free}));
      const Scene scene(model);
      const VecList u = random_displacements(model, 0.1, 5), x = sum_of(model.rest, u);
      const StrainMemory strains = random_strains(*tables);
      const double last_dt = 0x1p-12;

      VecList exact = forces_at(*tables, x);
      Dissipation dissipation(*tables);
      dissipation.reset(strains);
      dissipation.add_forces(*tables, x, tiny_step, last_dt, exact);
      const BoundedForces bounded(*tables, u, BoundedForces::DissipatingStep{strains, tiny_step, last_dt});

      Snapshot start;
      start.state = rest_state(model);
      start.state.position = x;
      start.last_dt = last_dt;
      put_strains(strains, start);
      for (const cpu::simd::Kernels* kernels : cpu::simd::usable_kernels()) {
        const InstructionSet chosen(kernels->name);
        const auto solver = make_solver("cpu", tables, scene, any_step());
        solver->restore(start);
        ASSERT_TRUE(solver->step(1, tiny_step).ok());
        const VecList found = solver->read().velocity;
        for (std::size_t i = 0; i < x.size(); ++i) {
          const Vec3 force = tables->mass[i] / tiny_step * found[i];
          const double share = share_of_bound(bounded.force(static_cast<Index>(i)), exact[i], force);
          ASSERT_LE(share, 1.0) << body.name << ", " << kinds << ", " << kernels->name << ", particle " << i;
          worst = std::max(worst, share);
        }
      }
    }
  }
  std::cout << "worst error: " << worst << " of the bound\n";
  EXPECT_GT(worst, 0.01);
}

constexpr double radius = 0.05;

Model half_sphere(double thickness) {
  Surface sphere = sphere_surface(radius, 5);
  std::erase_if(sphere.triangles, [&](const auto& t) {
    return (sphere.vertices[t[0]] + sphere.vertices[t[1]] + sphere.vertices[t[2]]).z() < 0.0;
  });
  return wall_of(sphere, 10e3, 0.4, thickness);
}

TEST(CpuWalls, ForcesAreWithinTheRoundingBound) {
  ShareOfBound worst;
  // The second has several clusters.
  for (const Model& model : {half_sphere(2e-3), wall_of(sphere_surface(radius, 24), 10e3, 0.49, 1e-3)}) {
    const auto tables = std::make_shared<const TopologyTextures>(build_topology(model));
    const Scene scene(model);
    for (const double amount : {0.0, 0.01, 0.3}) {
      worst.look(tables, scene, random_displacements(model, amount, 5), std::to_string(model.particle_count()), {1, 2});
    }
    if (model.particle_count() > 500) break;
    VecList u = random_displacements(model, 0.1, 6);  // crushed
    for (std::size_t i = 0; i < u.size(); ++i) {
      u[i] -= Vec3(0.9 * model.rest[i].x(), 0.999 * model.rest[i].y(), 0.0);
      u[i] = u[i].cast<float>().cast<double>();
    }
    worst.look(tables, scene, u, "crushed");
  }
  worst.expect_some();
}

/// The ratio of volumes, which the kernel finds in few steps, is that of the energy at any stretch of tissue.
TEST(CpuWalls, LargeStretchesHaveTheForcesOfTheReference) {
  const Surface square = grid_surface(4, 4, 0.2, [](double u, double v) { return Vec3(0.04 * u, 0.04 * v, 0.0); });
  for (const double poisson : {0.0, 0.3, 0.45, 0.499}) {
    const Model model = wall_of(square, 10e3, poisson, 1e-3);
    const auto tables = std::make_shared<const TopologyTextures>(build_topology(model));
    const Scene scene(model);
    const auto solver = make_solver("cpu", tables, scene, any_step(1));
    double largest = 0.0;
    for (const double along : {0.4, 0.6, 1.0, 1.7, 2.5}) {
      for (const double across : {0.4, 0.6, 1.0, 1.7, 2.5}) {
        VecList x = model.rest;
        for (Vec3& at : x) at = Vec3(along * at.x(), across * at.y(), 0.0);
        const VecList exact = forces_at(*tables, x), found = forces_of(*solver, x);
        double error = 0.0, force = 0.0;
        for (std::size_t i = 0; i < x.size(); ++i) {
          error = std::max(error, (found[i] - exact[i]).norm());
          force = std::max(force, exact[i].norm());
        }
        if (force > 1e-6) largest = std::max(largest, error / force);
      }
    }
    EXPECT_LT(largest, 1e-4) << poisson;
  }
}

TEST(CpuWalls, RestStaysAtRestExactly) {
  const Model model = half_sphere(1e-3);
  const Scene scene(model);
  const auto solver = make_solver("cpu", model, scene);
  ASSERT_TRUE(solver->step(100, 0.5 * solver->stable_step()).ok());
  const State state = solver->read();
  for (std::size_t i = 0; i < model.rest.size(); ++i) EXPECT_EQ(state.position[i], model.rest[i]);
}

/// 100,000 steps of 0.9 of the largest, without damping: a bowl that swings through its ovals.
TEST(CpuWalls, KeepsItsEnergyOverManySteps) {
  const Model model = half_sphere(2e-3);
  const Scene scene(model);
  for (const char* backend : {"reference", "cpu"}) {
    const auto solver = make_solver(backend, model, scene);
    State state = rest_state(model);
    double pace = 0.0;  // kg m/s
    for (std::size_t i = 0; i < model.rest.size(); ++i) {
      const Vec3& X = model.rest[i];
      state.velocity[i] = Vec3(0.04 * X.x(), -0.04 * X.y(), 0.0);
      pace += model.mass[i] * state.velocity[i].norm();
    }
    solver->reset(state);
    const double dt = 0.9 * solver->stable_step();
    ASSERT_TRUE(solver->step(20, dt).ok());
    const double first = solver->energy().total();
    const int rounds = std::string(backend) == "cpu" ? 100 : 10;
    double least = first, most = first;
    for (int k = 0; k < rounds; ++k) {
      ASSERT_TRUE(solver->step(1000, dt).ok());
      const double now = solver->energy().total();
      least = std::min(least, now);
      most = std::max(most, now);
    }
    EXPECT_LT(most - least, 1e-3 * first) << backend;
    const Momentum momentum = solver->momentum(Vec3::Zero());
    EXPECT_LT(momentum.linear.norm(), 1e-4 * pace) << backend;
    EXPECT_LT(momentum.angular.norm(), 1e-4 * pace * radius) << backend;
  }
}

/// A sheet sheared in its plane gives way by wrinkles, and stores less than it would flat.
TEST(CpuWalls, ShearedSheetWrinkles) {
  constexpr double length = 0.1, width = 0.05, t = 2e-4, shift = 0.01;
  const Model model = wall_of(
      grid_surface(40, 20, 0.2, [](double u, double v) { return Vec3(length * u, width * v, 0); }), 10e3, 0.4, t);
  const auto held = [&](const Vec3& X) { return X.y() < 1e-9 || X.y() > width - 1e-9; };
  Scene scene(model);
  scene.fix(model.particles_in([](const Vec3& X) { return X.y() < 1e-9; }));
  Load pull;
  pull.type = LoadType::translation;
  pull.particles = model.particles_in([&](const Vec3& X) { return X.y() > width - 1e-9; });
  pull.direction = {1, 0, 0};
  pull.events = {{0.0, shift}};
  scene.add(pull);
  State state = rest_state(model);
  std::mt19937 bits(3);
  for (Vec3& p : state.position)
    p += Vec3(shift * p.y() / width, 0.0, held(p) ? 0.0 : 1e-2 * t * random_vector(bits, 3).x());
  const auto solver = make_solver("cpu", model, scene, {}, damped(20.0));
  const double flat = elastic_energy(solver->topology(), state.position);
  solver->reset(state);
  const StepReport report = solver->step(10000, 0.5 * solver->stable_step());
  ASSERT_TRUE(report.ok()) << report.message();
  EXPECT_FALSE(report.force_clamped);
  solver->read(state);
  double height = 0.0;
  for (const Vec3& p : state.position) height = std::max(height, std::abs(p.z()));
  EXPECT_GT(height, 2.0 * t);
  EXPECT_LT(elastic_energy(solver->topology(), state.position), 0.95 * flat);
}

/// From broken states a damped sheet stays finite, and comes back to its shape, wherever it then lies, unless it
/// folded: a fold by 180 degrees holds itself.
TEST(CpuWalls, ComesBackFromBrokenStates) {
  constexpr int n = 8;
  constexpr double side = 0.04;
  const Model model =
      wall_of(grid_surface(n, n, 0.2, [](double u, double v) { return Vec3(side * u, side * v, 0.5 * side); }), 10e3,
              0.4, 3e-3);
  const Scene scene(model);
  // From the last of them chance decides: it returned by 4 to 6 of 12 seeds.
  constexpr std::string_view folding[] = {"line, noise",     "point, noise", "random",     "random, 3x",
                                          "pulled 10 sides", "swapped",      "noise 0.8 h"};
  int back = 0;
  for (const FailureState& failure : failure_states()) {
    std::mt19937 bits(11);
    State state = rest_state(model);
    failure.apply(state.position, side, side / n, bits);
    const auto solver = make_solver("cpu", model, scene, {}, damped(60.0));
    solver->reset(state);
    EXPECT_TRUE(solver->step(20000, 0.5 * solver->stable_step()).ok()) << failure.name;
    solver->read(state);
    double worst = 0.0;  // of distances between particles, which any rigid motion keeps
    for (std::size_t i = 0; i < model.rest.size(); ++i) {
      const double rest = (model.rest[i] - model.rest[0]).norm(), now = (state.position[i] - state.position[0]).norm();
      worst = std::max(worst, std::abs(now - rest));
    }
    EXPECT_TRUE(std::isfinite(worst)) << failure.name;
    const bool returns = worst < 0.02 * side;
    const bool may_fold = std::ranges::find(folding, std::string_view(failure.name)) != std::end(folding);
    EXPECT_TRUE(returns || may_fold) << failure.name << ": " << worst / side << " sides off";
    back += returns ? 1 : 0;
  }
  EXPECT_GE(back, static_cast<int>(failure_states().size() - std::size(folding)));
}

}  // namespace
}  // namespace phymul::test
