// SPDX-License-Identifier: MIT
//
// How fast the vector backend steps, beside plain loops (plain_loop.h; the mirror, whose arithmetic is that of the
// kernels, where those lack a term), interleaved in this process so that other work on the machine hurts all alike.
// Medians of the repeats, of processor time. The gain of a second thread is of time on the clock, beside what two
// threads gained on this machine at that moment without anything in common; "quiet" is the gain of those repeats alone
// in which the machine gave all of two processors, before and after.
//   cpu_speed [filter] [repeats]
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cpu/packed/packed_body.h"
#include "cpu/simd/instruction_set.h"
#include "machine_ceilings.h"
#include "plain_loop.h"
#include "stopwatch.h"
#include "triple_work.h"
#include "usage.h"

namespace {

using namespace phymul;

struct Case {
  std::string name;
  std::function<Model()> body;
  TopologyOptions options;
};

/// A solver and its start: the rest shape, every particle a little off its place.
struct Runner {
  std::unique_ptr<Solver> solver;
  std::optional<bench::PlainLoop> plain;  // in its place
  double dt = 0.0;
  int steps = 1;
  std::vector<double> rates, clock_rates;  // particle-steps a second of processor time, of time on the clock

  /// Takes as many steps as last about `seconds`.
  void calibrate(double seconds) {
    for (steps = 1; steps < 1 << 20; steps *= 2) {
      if (once() > seconds) return;
    }
  }
  double once() {
    const double start = processor_seconds();
    if (plain) {
      plain->step(steps, static_cast<float>(dt));
    } else if (const StepReport report = solver->step(steps, dt); !report.ok()) {
      std::printf("%s\n", report.message().c_str());
      std::exit(1);
    }
    return processor_seconds() - start;
  }
  void measure(double particles) {
    const Stopwatch watch;
    rates.push_back(particles * steps / once());
    clock_rates.push_back(particles * steps / watch.seconds());
  }
};

State start_of(const Model& model) {
  State state = rest_state(model);
  const double h = mean_spacing(model);
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    const double phase = static_cast<double>(i % 7);
    state.position[i] += 0.02 * h * Vec3(std::sin(phase), std::cos(2.0 * phase), std::sin(3.0 * phase + 1.0));
    if (model.dimension == 2) state.position[i].z() = 0.0;
  }
  return state;
}

Runner runner(std::unique_ptr<Solver> solver, const State& start) {
  Runner r;
  r.solver = std::move(solver);
  r.dt = 1e-3 * std::min(r.solver->stable_step(), 1.0);  // hardly moves: every step does the same work
  r.solver->reset(start);
  r.calibrate(0.02);
  return r;
}

double machine_gain() {
  return bench::threads_gain(2, 1, 0.005);
}

/// What two threads gain where nobody else works on their cores; beside a neighbour on one of them it is 1.9 and less.
constexpr double quiet_gain = 1.93;

/// Of two threads over one.
struct Gains {
  std::vector<double> all, machine, quiet;
  void add(double gain, double of_machine) {
    all.push_back(gain);
    machine.push_back(of_machine);
    if (of_machine >= quiet_gain) quiet.push_back(gain);
  }
};

void run(const Case& test, int repeats) {
  const Model model = test.body();
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, test.options));
  Scene scene(model);
  SolverOptions options;
  options.on_unstable = UnstableStep::allow;
  options.spectrum = Spectrum{1e6, 0.0, 0};
  const State start = start_of(model);
  options.threads = 1;
  std::vector<Runner> runners;
  runners.push_back(runner(make_solver("reference", tables, scene, options), start));
  const bool plain = bench::PlainLoop::covers(*tables);
  if (plain) {
    runners[0].plain.emplace(*tables, start);
    runners[0].calibrate(0.02);
  }
  runners.push_back(runner(make_solver("cpu", tables, scene, options), start));
  options.threads = 2;
  runners.push_back(runner(make_solver("cpu", tables, scene, options), start));
  std::vector<double> ratios;
  Gains gains;
  for (int k = 0; k < repeats; ++k) {
    runners[0].measure(model.particle_count());
    const double before = machine_gain();
    runners[1].measure(model.particle_count());
    runners[2].measure(model.particle_count());
    gains.add(runners[2].clock_rates.back() / runners[1].clock_rates.back(), std::min(before, machine_gain()));
    ratios.push_back(runners[1].rates.back() / runners[0].rates.back());
  }
  const double best = *std::ranges::max_element(runners[1].rates);
  const double n = model.particle_count();
  std::printf("%-34s %8d | %8.2f%c %8.2f (best %8.2f) %8.2f | %6.2f | %5.2f of %5.2f, quiet %5.2f (%d) | %9.2f us\n",
              test.name.c_str(), model.particle_count(), median(runners[0].rates) * 1e-6, plain ? ' ' : 'r',
              median(runners[1].rates) * 1e-6, best * 1e-6, median(runners[2].clock_rates) * 1e-6, median(ratios),
              median(gains.all), median(gains.machine), gains.quiet.empty() ? 0.0 : median(gains.quiet),
              static_cast<int>(gains.quiet.size()), n / median(runners[1].rates) * 1e6);
  const auto body = cpu::make_packed_body(*tables, cpu::simd::chosen_kernels().lanes);
  const double rate = median(runners[1].rates) / n;  // steps a second
  std::printf("%-34s bytes a particle-step %.0f, so %.1f GB/s", "", body->bytes_a_step() / n,
              body->bytes_a_step() * rate * 1e-9);
  if (tables->base_count > 0) std::printf("; %.1f bases a particle", tables->base_count / n);
  if (!body->enumerated.empty() && body->gives()) {
    const double ceiling = bench::vector_multiply_adds(0.2) * body->lanes;
    const bench::TripleWork work = bench::triple_work(*tables);
    std::printf(
        "; triples: %.0f G operations a second, %.0f %% of what multiply-adds give, multiplying units busy to %.0f %%",
        1e-9 * work.operations * rate, 100.0 * work.operations * rate / (2.0 * ceiling),
        100.0 * work.multiplications * rate / ceiling);
  }
  std::printf("\n");
  std::fflush(stdout);
}

Model block(int a_side, int valence) {
  const double side = 0.005 * (a_side - 1);
  return make_block({side, side, side}, a_side - 1, a_side - 1, a_side - 1, valence);
}
Model tetrahedra(int a_side) {
  const double side = 0.005 * (a_side - 1);
  return make_tetrahedral_block({side, side, side}, a_side - 1, a_side - 1, a_side - 1, 0.2, 7);
}
/// No two cells alike, as of a mesh that was read.
Model bent(Model model) {
  for (Vec3& x : model.rest) x.x() += 2.0 * x.z() * x.z() + 0.5 * x.x() * x.y();
  return model;
}
Model with_material(Model model) {
  set_material(model, {10e3, 0.3, 1000.0});
  return model;
}

/// The surface of a bent block.
Model wall(int a_side) {
  const Model solid = bent(block(a_side, 6));
  const Material sheet{.young = 10e3, .poisson = 0.45, .density = 1000.0, .thickness = 2e-3};
  return make_wall({.vertices = solid.rest, .triangles = surface_triangles(solid), .notes = {}}, {.material = sheet});
}

std::vector<Case> cases() {
  const TopologyOptions shared_all{.reaction = Reaction::shared, .bases = BaseSelection::all};
  const TopologyOptions averaged_all{.reaction = Reaction::averaged, .bases = BaseSelection::all};
  const TopologyOptions conservative_all{.reaction = Reaction::conservative, .bases = BaseSelection::all};
  const TopologyOptions springs{.law = Law::springs};
  const TopologyOptions springs_volume{.law = Law::springs, .volume_stiffness = 50.0};
  return {
      {"n6 full shared 4k", [] { return block(16, 6); }, shared_all},
      {"n6 full averaged 4k", [] { return block(16, 6); }, averaged_all},
      {"n6 full conservative 4k", [] { return block(16, 6); }, conservative_all},
      {"n6 full conservative+volume 4k",
       [] { return block(16, 6); },
       {.bases = BaseSelection::all, .volume_stiffness = 50.0}},
      {"n14 full shared 4k", [] { return block(16, 14); }, shared_all},
      {"n14 full averaged 4k", [] { return block(16, 14); }, averaged_all},
      {"n14 thresholded shared 1k", [] { return block(10, 14); }, {.reaction = Reaction::shared}},
      {"springs 1k", [] { return tetrahedra(10); }, springs},
      {"springs 4k", [] { return tetrahedra(16); }, springs},
      {"springs 10k", [] { return tetrahedra(22); }, springs},
      {"springs 97k", [] { return tetrahedra(46); }, springs},
      {"springs+volume 1k", [] { return tetrahedra(10); }, springs_volume},
      {"springs+volume 4k", [] { return tetrahedra(16); }, springs_volume},
      {"springs+volume 10k", [] { return tetrahedra(22); }, springs_volume},
      {"springs+volume 97k", [] { return tetrahedra(46); }, springs_volume},
      {"tetrahedra material 4k", [] { return with_material(tetrahedra(16)); }, {}},
      {"walls 1k", [] { return wall(14); }, {}},
      {"walls 4k", [] { return wall(27); }, {}},
      {"lattice material 2673", [] { return with_material(make_block(Vec3(0.04, 0.04, 0.16), 8, 8, 32)); }, {}},
      {"hexahedra material 2673", [] { return with_material(bent(make_block(Vec3(0.04, 0.04, 0.16), 8, 8, 32))); }, {}},
      {"lattice material 4k", [] { return with_material(block(16, 6)); }, {}},
      {"lattice material 32k", [] { return with_material(block(32, 6)); }, {}},
      {"cylinder averaged 275", [] { return make_cylinder(0.010, 0.040, 3, 8, 11); }, {.reaction = Reaction::averaged}},
      {"cylinder shared 275", [] { return make_cylinder(0.010, 0.040, 3, 8, 11); }, {.reaction = Reaction::shared}},
      {"cylinder conservative 275", [] { return make_cylinder(0.010, 0.040, 3, 8, 11); }, {}},
  };
}

}  // namespace

int main(int argc, char** argv) {
  if (bench::prints_usage(argc, argv,
                          "cpu_speed [part of the names of the cases to run [repeats]], default all and 7\n"
                          "Particle-steps a second of the backend cpu beside plain loops.")) {
    return 0;
  }
  const std::string filter = argc > 1 ? argv[1] : "";
  const int repeats = argc > 2 ? std::atoi(argv[2]) : 7;
  std::printf(
      "one core: %.1f G vector multiply-adds a second; reads %.0f GB/s of 256 KB, %.0f of 8 MB, %.0f of 256 MB\n",
      1e-9 * bench::vector_multiply_adds(0.3), 1e-9 * bench::read_bandwidth(256e3, 0.2),
      1e-9 * bench::read_bandwidth(8e6, 0.2), 1e-9 * bench::read_bandwidth(256e6, 0.4));
  std::printf("two threads do %.2f times the multiply-adds of one\n", bench::threads_gain(2));
  std::printf("million particle-steps a second, medians of %d; r: the backend \"reference\", in double precision\n",
              repeats);
  std::printf("%-34s %8s | %8s  %8s %15s %8s | %6s | %s\n", "", "particles", "plain", "1 thread", "", "2", "ratio",
              "2 : 1, of two without anything in common");
  bool ran = false;
  for (const Case& test : cases()) {
    if (test.name.find(filter) == std::string::npos) continue;
    run(test, repeats);
    ran = true;
  }
  if (!ran) std::printf("no case has a name with \"%s\"\n", filter.c_str());
  return ran ? 0 : 2;
}
