// SPDX-License-Identifier: MIT
#include "sweep_measure.h"

#include <phymul/topology_textures.h>

#include <algorithm>
#include <memory>
#include <thread>

#include "machine.h"
#include "machine_ceilings.h"
#include "stopwatch.h"
#include "triple_work.h"

namespace phymul::bench {
namespace {

struct Runner {
  std::unique_ptr<Solver> solver;
  SweepRow row;
  double dt = 0.0;
  int steps = 1;
  std::vector<double> seconds, processor;  // a step, of each sample

  bool sample() {
    const double before = processor_seconds();
    const Stopwatch watch;
    const StepReport report = solver->step(steps, dt);
    const double wall = watch.seconds();
    if (!report.ok()) {
      row.status = report.message();
      return false;
    }
    seconds.push_back(wall / steps);
    processor.push_back((processor_seconds() - before) / steps);
    return true;
  }

  /// As many steps as last about so long. The first call, in which a device may still set things up, counts for
  /// nothing.
  void calibrate(double sample_seconds) {
    bool good = sample();
    for (double taken = 0.0; good && steps < 1 << 22; steps *= 2) {
      good = sample();
      taken = good ? seconds.back() * steps : 0.0;
      if (taken > 0.5 * sample_seconds) break;
    }
    seconds.clear();
    processor.clear();
  }
};

bool is_cpu(const std::string& backend) {
  return backend == "reference" || backend == "cpu";
}

std::vector<int> thread_counts(const std::string& backend) {
  if (backend == "reference") return {1};
  if (!is_cpu(backend)) return {0};
  const int all = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return all > 1 ? std::vector<int>{1, all} : std::vector<int>{1};
}

SolverOptions options_for(int threads) {
  SolverOptions options;
  options.threads = threads;
  options.on_unstable = UnstableStep::allow;
  options.spectrum = Spectrum{1e6, 0.0, 0};  // of no body: steps are far too short to matter, and estimating takes long
  return options;
}

Runner runner(const std::string& backend, int threads, const std::shared_ptr<const TopologyTextures>& tables,
              const Scene& scene, const State& start) {
  Runner r;
  r.solver = make_solver(backend, tables, scene, options_for(threads));
  r.dt = 1e-3 * r.solver->stable_step();  // hardly moves: every step does the same work
  r.solver->reset(start);
  r.row.backend = backend;
  r.row.threads = threads;
  r.row.device = r.solver->device();
  return r;
}

/// Lanes of the vectors, from the device's name; 0 where it names none.
int lanes_of(const std::string& device) {
  if (device.find("avx512") != std::string::npos) return 16;
  if (device.find("avx2") != std::string::npos) return 8;
  return device.find("portable") != std::string::npos ? 4 : 0;
}

/// `work`: of enumerated triples, in a step. The ceilings are measured beside the body, by processor time as
/// the body's is.
void add_shares(SweepRow& row, const TripleWork& work) {
  if (row.threads != 1 || row.backend != "cpu") return;
  const int lanes = lanes_of(row.device);
  if (work.operations == 0.0 || lanes == 0) return;
  const double most = vector_multiply_adds(0.1) * lanes * row.processor_seconds_a_step;
  row.multiply_share = work.multiplications / most;
  row.operation_share = work.operations / (2.0 * most);
}

/// By a solver of its own: timers cost, and are not in the other times.
double device_seconds(const SweepRow& row, const std::shared_ptr<const TopologyTextures>& tables, const Scene& scene,
                      const State& start) {
  SolverOptions options = options_for(row.threads);
  options.profile = true;
  const auto solver = make_solver(row.backend, tables, scene, options);
  solver->reset(start);
  const double dt = 1e-3 * solver->stable_step();
  constexpr int steps = 16;
  solver->step(steps, dt);
  solver->clear_profile();
  solver->step(steps, dt);
  double sum = 0.0;
  for (const PassProfile& pass : solver->profile()) sum += pass.device_seconds;
  return sum / steps;
}

std::string why_left_out(const std::string& backend, const SweepLimits& limits) {
  const std::string missing = why_unavailable(backend);
  if (!missing.empty()) return "left out: " + missing;
  const double expected = limits.expected(backend) * (limits.repeats + 2);
  if (expected < 0.25 * limits.seconds_a_body) return {};
  return "left out: would take about " + std::to_string(static_cast<int>(expected)) + " s";
}

}  // namespace

void measure_body(const SweepVariant& variant, int size, const SweepLimits& limits,
                  const std::function<void(const SweepRow&)>& done) {
  SweepRow common;
  common.variant = variant.name;
  common.bases = variant.bases;
  common.particles = size;
  common.load = load_before();
  const Model model = sweep_body(variant, size);
  const Scene scene(model);
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, variant.options));
  const State start = sweep_start(model);
  common.base_count = tables->base_count;
  std::vector<Runner> runners;
  for (const std::string& backend : limits.backends) {
    SweepRow row = common;
    row.backend = backend;
    row.status = why_left_out(backend, limits);
    if (!row.status.empty()) {
      done(row);
      continue;
    }
    for (const int threads : thread_counts(backend)) {
      row.threads = threads;
      try {
        Runner made = runner(backend, threads, tables, scene, start);
        if (threads > 1 && made.row.device.starts_with("1 thread,")) continue;  // small: it takes no second one
        row.device = made.row.device;
        row.status = "ok";
        made.row = row;
        made.calibrate(limits.sample_seconds);
        runners.push_back(std::move(made));
      } catch (const Error& error) {
        row.status = std::string("failed: ") + error.what();
        done(row);
      }
    }
  }
  for (int k = 0; k < limits.repeats; ++k) {
    for (Runner& r : runners) {
      if (r.row.status == "ok") r.sample();
    }
  }
  for (Runner& r : runners) {
    SweepRow row = r.row;
    row.repeats = static_cast<int>(r.seconds.size());
    r.solver.reset();
    if (row.status == "ok") {
      row.seconds_a_step = median(r.seconds);
      row.least = *std::ranges::min_element(r.seconds);
      row.greatest = *std::ranges::max_element(r.seconds);
      row.processor_seconds_a_step = median(r.processor);
      row.processor_least = *std::ranges::min_element(r.processor);
      row.processor_greatest = *std::ranges::max_element(r.processor);
      add_shares(row, variant.options.bases == BaseSelection::all ? triple_work(*tables) : TripleWork{});
      if (!is_cpu(row.backend)) row.device_seconds_a_step = device_seconds(row, tables, scene, start);
    }
    done(row);
  }
}

}  // namespace phymul::bench
