// SPDX-License-Identifier: MIT
//
// What SolverOptions::sleep_tolerance saves and what it costs in accuracy. Backend cpu, one thread, the same motion
// without sleep and with some tolerances.
//   sleep_table [part of the names of the cases [share of the steps [share of the particles]]]
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stopwatch.h"
#include "usage.h"

namespace {

using namespace phymul;

constexpr int samples = 50;  // of a motion, at which it is compared

struct Case {
  std::string name;
  std::function<Model(double share)> body;        ///< with about so much of its particles
  std::function<void(Scene&, double step)> load;  ///< `step`: s
  /// What a hand does before the call of some steps that begins at this time, s.
  std::function<void(Scene&, double time)> drive;
  double damping = 20.0;  ///< 1/s
  int steps = 1000;
  int call = 20;         ///< steps of one call of Solver::step()
  bool settled = false;  ///< begins at rest under its loads
};

struct Run {
  double seconds = 0.0;  ///< of processor time, of all steps
  int steps = 0;
  double moving = 0.0;  ///< share of particles whose velocity is not 0, mean over the samples
  std::vector<VecList> place;
};

Run run(const Case& test, std::shared_ptr<const TopologyTextures> tables, const Model& model,
        std::optional<double> tolerance, const Spectrum& spectrum, double share) {
  Scene scene(model);
  SolverOptions options;
  options.threads = 1;
  options.damping.rate = test.damping;
  options.spectrum = spectrum;
  options.sleep_tolerance = tolerance;
  const double dt = 0.5 * stable_step(spectrum, 1.0);
  test.load(scene, dt);
  const auto solver = make_solver("cpu", std::move(tables), scene, options);
  const int calls = std::max(1, static_cast<int>(test.steps * share) / test.call), every = std::max(1, calls / samples);
  if (test.settled) {
    if (const RestResult rest = solver->run_to_rest(100000, dt, {.rate = 60.0}); !rest.converged())
      throw Error(rest.message());
    solver->step(200, dt);
  }
  Run done;
  State state;
  for (int call = 0; call < calls; ++call) {
    if (test.drive) test.drive(scene, call * test.call * dt);
    const double begin = processor_seconds();
    const StepReport report = solver->step(test.call, dt);
    done.seconds += processor_seconds() - begin;
    if (!report.ok()) throw Error(report.message());
    done.steps += report.steps;
    if ((call + 1) % every != 0) continue;
    solver->read(state);
    const auto moving = std::ranges::count_if(state.velocity, [](const Vec3& v) { return v != Vec3::Zero(); });
    done.moving += static_cast<double>(moving) / static_cast<double>(state.velocity.size());
    done.place.push_back(state.position);
  }
  done.moving /= static_cast<double>(done.place.size());
  return done;
}

double farthest(const std::vector<VecList>& a, const std::vector<VecList>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    for (std::size_t i = 0; i < a[k].size(); ++i) largest = std::max(largest, (a[k][i] - b[k][i]).norm());
  }
  return largest;
}

void print(const char* name, const Run& with, const Run& without, double largest) {
  std::printf("  %-8s %10.2f us %7.2f %10.1f %% %13.3g %%\n", name, 1e6 * with.seconds / with.steps,
              without.seconds / with.seconds, 100.0 * with.moving,
              largest > 0.0 ? 100.0 * farthest(with.place, without.place) / largest : 0.0);
  std::fflush(stdout);
}

void measure(const Case& test, double steps, double particles) {
  const Model model = test.body(particles);
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, {}));
  const Spectrum spectrum = estimate_spectrum(*tables, tables->rest);
  const Run without = run(test, tables, model, std::nullopt, spectrum, steps);
  const double largest = farthest(without.place, std::vector<VecList>(without.place.size(), model.rest));
  std::printf("%s: %d particles, %d steps of %.3g ms, largest displacement %.3g mm, spacing %.3g mm\n",
              test.name.c_str(), model.particle_count(), without.steps, 500.0 * stable_step(spectrum, 1.0),
              1e3 * largest, 1e3 * mean_spacing(model));
  std::printf("  %-8s %13s %7s %12s %15s\n", "tolerance", "step", "gain", "moving", "largest error");
  print("none", without, without, largest);
  print("0", run(test, tables, model, 0.0, spectrum, steps), without, largest);
  for (const char* tolerance : {"1e-6", "1e-5", "1e-4", "1e-3", "1e-2"}) {
    print(tolerance, run(test, tables, model, std::atof(tolerance), spectrum, steps), without, largest);
  }
}

Model with_material(Model model) {
  set_material(model, {.young = 10e3, .poisson = 0.45, .density = 1000});
  return model;
}

/// What sleep costs a body of which nothing rests: two solvers, in turns.
void measure_awake(const char* name, const Model& model) {
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, {}));
  const Scene scene(model);
  State start = rest_state(model);
  const double h = mean_spacing(model);
  for (std::size_t i = 0; i < start.position.size(); ++i) {
    const double phase = static_cast<double>(i % 7);
    start.position[i] += 0.02 * h * Vec3(std::sin(phase), std::cos(2.0 * phase), std::sin(3.0 * phase + 1.0));
  }
  SolverOptions options;
  options.threads = 1;
  options.spectrum = estimate_spectrum(*tables, tables->rest);
  std::unique_ptr<Solver> solvers[2];
  for (const bool sleeps : {false, true}) {
    if (sleeps) options.sleep_tolerance = 0.0;
    solvers[sleeps] = make_solver("cpu", tables, scene, options);
    solvers[sleeps]->reset(start);
  }
  const double dt = 0.5 * solvers[0]->stable_step();
  const int steps = std::max(1, 400000 / model.particle_count());
  std::vector<double> ratios;
  double least[2] = {HUGE_VAL, HUGE_VAL};
  for (int k = 0; k < 101; ++k) {
    double seconds[2];
    for (const int which : {k % 2, 1 - k % 2}) {
      const double begin = processor_seconds();
      if (const StepReport report = solvers[which]->step(steps, dt); !report.ok()) throw Error(report.message());
      seconds[which] = processor_seconds() - begin;
      least[which] = std::min(least[which], seconds[which]);
    }
    ratios.push_back(seconds[1] / seconds[0]);
  }
  std::printf("all awake, %s: %d particles, a step takes %.3f times as long (median of %zu), least times %.3f\n", name,
              model.particle_count(), median(ratios), ratios.size(), least[1] / least[0]);
}

int cells(double share, int cells) {
  return std::max(4, static_cast<int>(std::lround(cells * std::cbrt(share))));
}

Model block(double share) {
  const int n = cells(share, 63);
  return with_material(make_block({0.005 * n, 0.005 * n, 0.005 * n}, n, n, n));
}

Model tetrahedra(double share) {
  const int n = cells(share, 31);
  return with_material(make_tetrahedral_block({0.005 * n, 0.005 * n, 0.005 * n}, n, n, n, 0.2, 7));
}

/// Lies on its lowest fifth, which is held.
Model organ(double share) {
  Model model = make_body(solid_ellipsoid({0, 0, 0}, {0.09, 0.04, 0.03}), {.spacing = 0.0070 / std::cbrt(share)});
  std::vector<Index> held;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (model.rest[i].z() < -0.02) held.push_back(i);
  }
  model.add_group("held", held);
  return with_material(model);
}

/// A quarter of a newton on the particles around the middle of the upper face, for 20 ms.
void poke(Scene& scene, double) {
  const Model& model = scene.model();
  Vec3 middle = Vec3::Zero();
  for (const Vec3& x : model.rest) middle = middle.cwiseMax(x);
  middle = Vec3(0.5 * middle.x(), 0.5 * middle.y(), middle.z());
  Load load;
  load.type = LoadType::force;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if ((model.rest[i] - middle).norm() <= 0.0126) load.particles.push_back(i);
  }
  load.direction = {0, 0, -1};
  const double each = 0.25 / static_cast<double>(load.particles.size());
  load.events = {{0.0, 0.0}, {0.01, each}, {0.02, 0.0}};
  scene.fix("z0").add(load);
}

void lie_there(Scene& scene, double) {
  scene.fix("held").gravity({0, 0, -9.81});
}

/// Pressed in by 8 mm at one end and out again, twice in 2 s.
ToolPose probe_at(double time) {
  const double depth = 0.004 * (1.0 - std::cos(2.0 * M_PI * time)) - 0.001;
  return {.position = {0.06, 0.0, 0.0316 + 0.006 - depth}};
}
void probe(Scene& scene, double) {
  scene.fix("held").add_tool("probe", {.shape = Sphere{0.010}, .pose = probe_at(0.0), .friction = 0.1});
}

Model beam(double share) {
  const int n = cells(share, 8);
  return with_material(make_tetrahedral_block({0.16, 0.04, 0.04}, 4 * n, n, n, 0.2, 7));
}

std::vector<Case> cases() {
  const auto poked = [](const char* name, auto body, double damping) {
    return Case{.name = name, .body = body, .load = poke, .drive = {}, .damping = damping};
  };
  return {
      poked("block poked", block, 20.0),
      poked("block poked, damped", block, 200.0),
      poked("tetrahedra poked, damped", tetrahedra, 200.0),
      {.name = "organ settled", .body = organ, .load = lie_there, .drive = {}, .steps = 20000, .settled = true},
      {.name = "organ at rest",
       .body = organ,
       .load = [](Scene& scene, double) { scene.fix("held"); },
       .drive = {},
       .steps = 20000},
      {.name = "organ probed",
       .body = organ,
       .load = probe,
       .drive = [](Scene& scene, double time) { scene.tool("probe").move_to(probe_at(time)); },
       .damping = 60.0,
       .steps = 10000,
       .call = 5},
      {.name = "cantilever",
       .body = beam,
       .load = [](Scene& scene, double) { scene.fix("x0").gravity(Vec3(0, 0, -9.81)); },
       .drive = {},
       .steps = 20000},
  };
}

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(argc, argv,
                          "sleep_table [part of the names of the cases to run [share of the steps [share of the "
                          "particles]]], default all, 1 and 1\n"
                          "Gain and error of SolverOptions::sleep_tolerance.")) {
    return 0;
  }
  const std::string filter = argc > 1 ? argv[1] : "";
  const double steps = argc > 2 ? std::atof(argv[2]) : 1.0, particles = argc > 3 ? std::atof(argv[3]) : 1.0;
  bool ran = false;
  for (const Case& test : cases()) {
    if (test.name.find(filter) == std::string::npos) continue;
    measure(test, steps, particles);
    ran = true;
  }
  if (std::string("all awake").find(filter) != std::string::npos) {
    ran = true;
    measure_awake("lattice", block(particles / 8));
    measure_awake("tetrahedra", tetrahedra(particles / 8));
    measure_awake("organ", organ(particles));
  }
  if (!ran) throw Error("no case has a name with \"" + filter + '"');
  return 0;
} catch (const phymul::Error& error) {
  return std::puts(error.what()), 1;
}
