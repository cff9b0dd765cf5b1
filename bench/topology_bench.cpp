// SPDX-License-Identifier: MIT
//
// Building the tables of a body, by size, from bases or a material, and changing them. Items are particles.
#include <benchmark/benchmark.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <random>
#include <vector>

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

/// Of some 14,600 tetrahedra around random places, or spread over the body: 100 cells a call, on "cpu".
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

void sizes(benchmark::internal::Benchmark* bench) {
  bench->ArgName("particles_a_side")->Arg(5)->Arg(10)->Arg(20)->Unit(benchmark::kMillisecond)->UseRealTime();
}

BENCHMARK(topology_thresholded)->Apply(sizes);
BENCHMARK(topology_material)->Apply(sizes);
BENCHMARK(remove_cells)->ArgName("lump")->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond);

}  // namespace
