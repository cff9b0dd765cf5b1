// SPDX-License-Identifier: MIT
//
// Building the tables of a body, by size and by choice of bases. Items are particles.
#include <benchmark/benchmark.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

namespace {

constexpr double spacing = 0.005;  // m

phymul::Model block(int particles_a_side) {
  const int n = particles_a_side - 1;
  const double side = n * spacing;
  return phymul::make_block({side, side, side}, n, n, n, 26);
}

phymul::Model tetrahedral_block(int particles_a_side) {
  const int n = particles_a_side - 1;
  const double side = n * spacing;
  phymul::Model model = phymul::make_tetrahedral_block({side, side, side}, n, n, n, 0.2, 1);
  phymul::set_material(model, {.young = 1e4, .poisson = 0.45, .density = 1000.0});
  return model;
}

void build(benchmark::State& run, const phymul::Model& model, const phymul::TopologyOptions& options) {
  phymul::Index bases = 0;
  for (auto _ : run) {
    const phymul::TopologyTextures topology = phymul::build_topology(model, options);
    bases = topology.base_count;
    benchmark::DoNotOptimize(topology.bases.data());
  }
  run.SetItemsProcessed(run.iterations() * model.particle_count());
  run.counters["particles"] = model.particle_count();
  run.counters["bases"] = bases;
}

void topology_thresholded(benchmark::State& run) {
  build(run, block(static_cast<int>(run.range(0))), {.bases = phymul::BaseSelection::thresholded});
}

void topology_fitted(benchmark::State& run) {
  build(run, block(static_cast<int>(run.range(0))), {.bases = phymul::BaseSelection::fitted});
}

void topology_opposite_faces(benchmark::State& run) {
  build(run, tetrahedral_block(static_cast<int>(run.range(0))), {.bases = phymul::BaseSelection::opposite_faces});
}

void sizes(benchmark::internal::Benchmark* bench) {
  bench->ArgName("particles_a_side")->Arg(5)->Arg(10)->Arg(20)->Unit(benchmark::kMillisecond)->UseRealTime();
}

BENCHMARK(topology_thresholded)->Apply(sizes);
BENCHMARK(topology_fitted)->Apply(sizes);
BENCHMARK(topology_opposite_faces)->Apply(sizes);

}  // namespace
