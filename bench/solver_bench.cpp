// SPDX-License-Identifier: MIT
//
// Stepping, by backend, law and size. Items are particle-steps. Every batch starts from the same settled, deformed
// body: at rest the terms that measure deformation are zero, and a moving body would be another one at each batch.
#include <benchmark/benchmark.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <map>
#include <string>

namespace {

constexpr double spacing = 0.005;  // m
constexpr double stretch = 1.1;    // of the length along x
constexpr int steps_a_batch = 8;

struct Elasticity {
  const char* name;
  phymul::TopologyOptions options;
};

const Elasticity elasticities[] = {
    {"springs", {.law = phymul::Law::springs}},
    {"full", {.reaction = phymul::Reaction::full}},
    {"shared", {.reaction = phymul::Reaction::shared}},
    {"barycentric", {.reaction = phymul::Reaction::barycentric}},
    {"averaged", {.reaction = phymul::Reaction::averaged}},
    {"conservative", {.reaction = phymul::Reaction::conservative}},
    {"conservative_volume", {.reaction = phymul::Reaction::conservative, .volume_stiffness = 100.0}},
};

/// A block whose end x1 is held stretched away from its end x0.
struct StretchedBlock {
  explicit StretchedBlock(int particles_a_side) : model(make_model(particles_a_side)), scene(model) {
    scene.fix("x0");
    phymul::Load pull;
    pull.type = phymul::LoadType::translation;
    pull.particles = model.group("x1");
    pull.events = {{0.0, (stretch - 1.0) * phymul::body_size(model)}};
    pull.direction = {1, 0, 0};
    scene.add(pull);
  }

  static phymul::Model make_model(int particles_a_side) {
    const int n = particles_a_side - 1;
    const double side = n * spacing;
    return phymul::make_block({side, side, side}, n, n, n, 18);
  }

  phymul::Model model;
  phymul::Scene scene;
};

/// The block near its balance: stretched evenly, then let settle under strong damping. Always by the conservative law,
/// because the older reactions have no balance to settle in.
phymul::State settle(const StretchedBlock& block) {
  phymul::SolverOptions options;
  options.damping.factor = 0.9;
  const auto solver = phymul::make_solver("reference", block.model, block.scene, {}, options);
  phymul::State state = phymul::rest_state(block.model);
  for (phymul::Vec3& x : state.position) x.x() *= stretch;
  solver->reset(state);
  solver->step(200, 0.5 * solver->stable_step());
  solver->read(state);
  for (phymul::Vec3& v : state.velocity) v.setZero();
  state.time = 0.0;
  return state;
}

/// A bench function is called several times for one figure.
const phymul::State& settled(const StretchedBlock& block) {
  static std::map<phymul::Index, phymul::State> known;  // by particles
  const auto [row, is_new] = known.try_emplace(block.model.particle_count());
  if (is_new) row->second = settle(block);
  return row->second;
}

void solver_step(benchmark::State& run, const std::string& backend, const Elasticity& elasticity) {
  const StretchedBlock block(static_cast<int>(run.range(0)));
  const phymul::State& start = settled(block);
  phymul::SolverOptions options;
  options.damping.factor = 0.99;
  options.on_unstable = phymul::UnstableStep::allow;
  const auto solver = phymul::make_solver(backend, block.model, block.scene, elasticity.options, options);
  const double dt = 0.2 * solver->stable_step();

  for (auto _ : run) {
    run.PauseTiming();
    solver->reset(start);
    run.ResumeTiming();
    const phymul::StepReport report = solver->step(steps_a_batch, dt);
    if (!report.ok()) run.SkipWithError(report.message().c_str());
  }
  run.SetItemsProcessed(run.iterations() * steps_a_batch * block.model.particle_count());
  run.counters["particles"] = block.model.particle_count();
  run.counters["bases"] = solver->topology().base_count;
  const double steps = static_cast<double>(run.iterations()) * steps_a_batch;
  run.counters["bases_per_second"] =
      benchmark::Counter(steps * solver->topology().base_count, benchmark::Counter::kIsRate);
}

/// One bench for each backend of this build and each law.
const bool registered = [] {
  for (const std::string& backend : phymul::backend_names()) {
    for (const Elasticity& elasticity : elasticities) {
      const std::string name = "solver_step/" + backend + "/" + elasticity.name;
      benchmark::RegisterBenchmark(name.c_str(), solver_step, backend, elasticity)
          ->ArgName("particles_a_side")
          ->Arg(5)
          ->Arg(10)
          ->Arg(20)
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
    }
  }
  return true;
}();

}  // namespace
