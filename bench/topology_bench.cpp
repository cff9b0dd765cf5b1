// SPDX-License-Identifier: MIT
//
// Building the tables of a body, by size, from bases or a material, and changing them. Items are particles.
#include <benchmark/benchmark.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <vector>

#include "stopwatch.h"

namespace {

constexpr double cell_size = 0.005;  // m

phymul::Model block(int particles_a_side) {
  const int n = particles_a_side - 1;
  const double side = n * cell_size;
  return phymul::make_block({side, side, side}, n, n, n, 26);
}

phymul::Model tetrahedral_block(int particles_a_side) {
  const int n = particles_a_side - 1;
  const double side = n * cell_size;
  phymul::Model model = phymul::make_tetrahedral_block({side, side, side}, n, n, n, 0.2, 1);
  phymul::set_material(model, {.young = 1e4, .poisson = 0.45, .density = 1000.0});
  return model;
}

void build(benchmark::State& run, const phymul::Model& model) {
  double bases = 0, links = 0;
  for (auto _ : run) {
    const phymul::TopologyTextures topology = phymul::build_topology(model);
    bases = topology.base_count;
    links = static_cast<double>(topology.links.size());
    benchmark::DoNotOptimize(&topology);
  }
  run.SetItemsProcessed(run.iterations() * model.particle_count());
  run.counters["particles"] = model.particle_count();
  run.counters["bases"] = bases;
  run.counters["links"] = links;
}

void topology_thresholded(benchmark::State& run) {
  build(run, block(static_cast<int>(run.range(0))));
}

void topology_material(benchmark::State& run) {
  build(run, tetrahedral_block(static_cast<int>(run.range(0))));
}

/// Of 13,182 tetrahedra around random places, or spread over the body: 100 cells a call, on "cpu".
void remove_cells(benchmark::State& run) {
  phymul::SimulationOptions options;
  options.backend = "cpu";
  options.solver.threads = 1;
  phymul::Simulation sim(tetrahedral_block(14), options);
  sim.scene().fix("z0").gravity({0, 0, -9.81});
  sim.advance(0.01);
  const phymul::Snapshot whole = sim.snapshot();
  const phymul::Model& model = sim.model();
  const auto count = static_cast<phymul::Index>(model.cells.size());
  std::mt19937 bits(1);
  const auto first = std::vector<phymul::Index>{0};
  sim.remove_cells(first);  // which looks at the whole body
  for (auto _ : run) {
    run.PauseTiming();
    sim.restore(whole);
    std::vector<phymul::Index> rows;
    const phymul::Vec3 place = model.rest[bits() % model.rest.size()];
    double radius = 0.0;
    while (run.range(0) != 0 && rows.size() < 100) {
      radius += 0.05 * cell_size;
      rows = model.cells_in([&](const phymul::Vec3& x) { return (x - place).norm() < radius; });
    }
    while (rows.size() < 100) rows.push_back(static_cast<phymul::Index>(bits() % count));
    rows.resize(100);
    run.ResumeTiming();
    sim.remove_cells(rows);
  }
  run.counters["cells"] = count;
}

/// Ticks of 1 ms in which an edge of 15 mm goes at 5 cm/s through 2,744 particles, on "cpu"; toughness in J/m^2;
/// touch 1: the faces of the cut touch each other; 2: a ball that touches triangles lies beside it.
void blade_ticks(benchmark::State& run) {
  using Clock = std::chrono::steady_clock;
  phymul::SimulationOptions options;
  options.backend = "cpu";
  options.solver.threads = 1;
  options.damping.rate = 20.0;
  phymul::Simulation sim(with_spare_particles(tetrahedral_block(14), 300), options);
  sim.scene().fix("z0");
  if (run.range(1) == 1) sim.scene().contacts({});
  if (run.range(1) == 2) {
    sim.scene().add_tool("ball", {.shape = phymul::Sphere{0.01},
                                  .pose = {.position = {0.02, 0.02, 0.069}},
                                  .contact = phymul::ToolContact::surface});
  }
  phymul::Mat3 axes;
  axes << 0, 0, 1, 0, -1, 0, 1, 0, 0;
  const phymul::ToolPose first{.position = {0.066, 0.034, 0.06},
                               .orientation = phymul::Quaternion(Eigen::Quaterniond(axes))};
  const auto blade = sim.scene().add_tool(
      "blade", {.shape = phymul::Blade{.width = 0.015, .toughness = static_cast<double>(run.range(0))}, .pose = first});
  sim.advance(1e-3);
  const phymul::Snapshot whole = sim.snapshot();
  std::vector<double> cutting, plain;  // ms
  phymul::ToolPose pose = first;
  for (auto _ : run) {
    pose.position.x() -= 0.05e-3;
    blade.move_to(pose);
    const std::size_t cuts = sim.cuts().size();
    const auto start = Clock::now();
    sim.advance(1e-3);
    const double ms = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    (sim.cuts().size() > cuts ? cutting : plain).push_back(ms);
    if (pose.position.x() > 0.005) continue;
    run.PauseTiming();
    sim.restore(whole);
    pose = first;
    run.ResumeTiming();
  }
  run.counters["cutting_ms"] = median(cutting);
  run.counters["plain_ms"] = median(plain);
  run.counters["worst_ms"] = cutting.empty() ? 0.0 : std::ranges::max(cutting);
}

void sizes(benchmark::internal::Benchmark* bench) {
  bench->ArgName("particles_a_side")->Arg(5)->Arg(10)->Arg(20)->Unit(benchmark::kMillisecond)->UseRealTime();
}

BENCHMARK(topology_thresholded)->Apply(sizes);
BENCHMARK(topology_material)->Apply(sizes);
BENCHMARK(blade_ticks)
    ->ArgNames({"toughness", "touch"})
    ->Args({0, 0})
    ->Args({20, 0})
    ->Args({0, 1})
    ->Args({0, 2})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(remove_cells)->ArgName("lump")->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond);

}  // namespace
