// SPDX-License-Identifier: MIT
//
// Twelve short scenes, and the hash of where each ends: whether a compiler, a system or a processor changes a bit.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <sstream>

#include "base/fnv.h"
#include "solver/trajectory_hashes.h"
#include "support/bodies.h"
#include "support/cpu_forces.h"

namespace phymul::test {
namespace {

/// What a scene is made of. Nothing here calls a function of the C library whose last bit systems disagree about
/// (sine), and numbers are literals, so that no compiler rounds them otherwise.
struct Trajectory {
  const char* name;
  std::function<Model()> body;
  std::function<void(Scene&)> act = [](Scene&) {};
  TopologyOptions topology{};
  int steps = 200;
};

Model block() {
  return make_block({0.04, 0.03, 0.03}, 4, 3, 3);
}

Model of(const Material& material, Model model = block()) {
  set_material(model, material);
  return model;
}

Model fibrous() {
  Model model = of({.young = 10e3, .poisson = 0.3, .density = 1000.0, .fibre_ratio = 4.0});
  for (Cell& cell : model.cells) cell.fibre = {1.0, 2.0, 0.0};
  return model;
}

Model two_cubes() {
  const Model lower = make_block({0.02, 0.02, 0.02}, 3, 3, 3), upper = moved(lower, {0.004, 0.003, 0.021});
  return with_material(merged({{"lower", &lower}, {"upper", &upper}}));
}

void hang(Scene& scene) {
  scene.fix("x0").gravity({1.0, 2.0, -9.81});
}

std::vector<Trajectory> trajectories() {
  const auto tissue = [] { return of(soft_tissue()); };
  const TopologyOptions springs{.law = Law::springs};
  TopologyOptions filled = springs;
  filled.volume_stiffness = 50.0;
  return {
      {"material", tissue, hang},
      {"material beyond its law", tissue,
       [](Scene& scene) {
         Load press{.type = LoadType::translation, .events = {{0.0, 0.02}}, .direction = {0, 0, -1}};
         press.particles = scene.model().group("z1");
         scene.fix("z0").add(press);
       }},
      {"fibres", fibrous, hang},
      {"bases of the thesis", jittered_block, hang},
      {"springs", jittered_block, hang, springs},
      {"springs with volume", jittered_block, hang, filled},
      {"tool", tissue,
       [](Scene& scene) {
         const ToolPose pose{.position = {0.02, 0.015, 0.039}, .velocity = {0.02, 0.0, -0.1}};
         scene.fix("z0").add_tool("ball", {.shape = Sphere{0.01}, .pose = pose, .friction = 0.4});
       }},
      {"needle", tissue,
       [](Scene& scene) {
         const Needle needle{.length = 0.1,
                             .radius = 0.6e-3,
                             .puncture = 0.1,
                             .cutting = 0.05,
                             .static_friction = 12.0,
                             .kinetic_friction = 10.0,
                             .spread = 0.012};
         const ToolPose pose{.position = {0.0203, 0.0147, 0.0305}, .velocity = {0.0, 0.0, -0.2}};
         scene.fix("z0").add_tool("needle", {.shape = needle, .pose = pose, .friction = 0.5});
       }},
      {"joints", two_cubes,
       [](Scene& scene) {
         scene.fix("lower/z0").gravity({3.0, 0.0, 9.81});
         scene.attach(scene.model().group("upper/z0"), "lower", {.stiffness = 1e6, .damping = 10.0});
       }},
      {"contact of two bodies", two_cubes,
       [](Scene& scene) { scene.fix("lower/z0").gravity(Vec3(3.0, 0.0, -9.81)).contacts({.friction = 0.3}); }},
      {"dissipation",
       [] {
         return of({.young = 10e3,
                    .poisson = 0.3,
                    .density = 1000.0,
                    .retardation_time = 1e-3,
                    .relaxation_strength = 0.8,
                    .relaxation_time = 0.02});
       },
       hang},
      {"kept volume", tissue,
       [](Scene& scene) {
         hang(scene);
         scene.constrain_volume();
       }},
  };
}

std::uint64_t hash_of_end(const Trajectory& trajectory, const char* backend, int threads) {
  const Model model = trajectory.body();
  Scene scene(model);
  trajectory.act(scene);
  const auto solver =
      make_solver(backend, model, scene, trajectory.topology, {.damping = {.rate = 5.0}, .threads = threads});
  // A power of two, which the last bits of the step limit do not change.
  const double undamped = make_solver(backend, model, scene, trajectory.topology)->stable_step();
  const double dt = std::ldexp(1.0, std::ilogb(0.4 * undamped));
  const StepReport report = solver->step(trajectory.steps, dt);
  EXPECT_TRUE(report.ok()) << report.message();
  const State end = solver->read();
  EXPECT_GT(largest_distance(end.position, model.rest), 1e-4) << "m; or this shows nothing";
  Fnv hash;
  hash.add(end.time);
  hash.add(end.position);
  hash.add(end.velocity);
  return hash.value();
}

std::vector<std::uint64_t> hashes_of(const char* backend, int threads = 1) {
  std::vector<std::uint64_t> hashes;
  for (const Trajectory& trajectory : trajectories()) {
    SCOPED_TRACE(trajectory.name);
    hashes.push_back(hash_of_end(trajectory, backend, threads));
  }
  return hashes;
}

/// The row for tests/solver/trajectory_hashes.h.
std::string as_row(const std::string& key, const std::vector<std::uint64_t>& hashes) {
  std::ostringstream row;
  row << "{\"" << key << "\", {" << std::hex;
  for (std::size_t k = 0; k < hashes.size(); ++k) row << (k ? ", 0x" : "0x") << hashes[k];
  row << "}},";
  return row.str();
}

void expect_row(const std::string& key, const std::vector<std::uint64_t>& hashes) {
  const std::vector<Trajectory> all = trajectories();
  Fnv together;
  for (const std::uint64_t hash : hashes) together.add(hash);
  std::cout << "hash of the twelve trajectories, " << key << ": " << std::hex << together.value() << std::dec << "\n";
  const HashRow* const expected = expected_row(key);
  ASSERT_TRUE(expected) << "tests/solver/trajectory_hashes.h has no row for these kernels:\n" << as_row(key, hashes);
  ASSERT_EQ(all.size(), expected->hashes.size());
  int differ = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    differ += hashes[k] != expected->hashes[k];
    EXPECT_EQ(hashes[k], expected->hashes[k]) << all[k].name;
  }
  EXPECT_EQ(differ, 0) << "of twelve trajectories end elsewhere. Where that is meant, the new row of "
                          "tests/solver/trajectory_hashes.h is\n"
                       << as_row(key, hashes);
}

TEST(Trajectories, OfReferenceAreTheSameEverywhere) {
  expect_row("reference", hashes_of("reference"));
}

TEST(Trajectories, OfCpuAreTheSameEverywhereForTheSameKernels) {
  for (const cpu::simd::Kernels* kernels : cpu::simd::usable_kernels()) {
    SCOPED_TRACE(kernels->name);
    const InstructionSet only(kernels->name);
    const std::vector<std::uint64_t> hashes = hashes_of("cpu");
    EXPECT_EQ(hashes, hashes_of("cpu", 2)) << "of another number of threads";
    expect_row(kernels->name, hashes);
  }
}

}  // namespace
}  // namespace phymul::test
