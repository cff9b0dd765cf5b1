// SPDX-License-Identifier: MIT
//
// Building the tables of a body, by size, from bases or a material. Items are particles.
#include <benchmark/benchmark.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

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

void sizes(benchmark::internal::Benchmark* bench) {
  bench->ArgName("particles_a_side")->Arg(5)->Arg(10)->Arg(20)->Unit(benchmark::kMillisecond)->UseRealTime();
}

BENCHMARK(topology_thresholded)->Apply(sizes);
BENCHMARK(topology_material)->Apply(sizes);

}  // namespace
