// SPDX-License-Identifier: MIT
//
// How well motion in time is computed: error of a trajectory against dt (which shows the order of the integrator), and
// distance of each backend from the double-precision reference over the steps of one run.
#include <cmath>
#include <cstdio>

#include "arguments.h"
#include "csv_row.h"
#include "methods.h"
#include "soft_cube.h"

namespace {

using namespace phymul;
using namespace phymul::bench;

/// A cantilever under a tenth of the weight of tissue of 10 kPa, let go at rest.
struct SwingingBeam {
  explicit SwingingBeam(const Method& method) {
    Problem problem;
    problem.model = make_block({0.2, 0.05, 0.05}, 8, 2, 2);
    set_material(problem.model, {10e3, 0.3, 1000});
    body = body_for(method, problem);
    if (method.rule == StiffnessRule::lattice) {
      set_stiffness(body, spring_stiffness(body, problem.model.materials.front()));
    }
    topology = std::make_shared<const TopologyTextures>(build_topology(body.model, body.options));
    scene = std::make_unique<Scene>(body.model);
    scene->fix("x0").gravity(weight);
  }

  std::unique_ptr<Solver> solver(const std::string& backend) const {
    SolverOptions options;
    options.on_unstable = UnstableStep::allow;
    return make_solver(backend, topology, *scene, options);
  }

  /// At rest at time 0; the velocity a state holds is that of half a step before.
  State start(double dt) const {
    State state = rest_state(body.model);
    for (Vec3& v : state.velocity) v = -0.5 * dt * weight;
    for (const Index i : body.model.group("x0")) state.velocity[i].setZero();
    return state;
  }

  static inline const Vec3 weight{0, 0, -0.981};  // m/s^2
  MethodBody body;
  std::shared_ptr<const TopologyTextures> topology;
  std::unique_ptr<Scene> scene;
};

VecList position_after(const SwingingBeam& beam, const std::string& backend, double time, int steps) {
  const auto solver = beam.solver(backend);
  solver->reset(beam.start(time / steps));
  const StepReport report = solver->step(steps, time / steps);
  if (!report.ok()) throw Error(report.message());
  return solver->read().position;
}

void order_in_time(CsvFile& file, const std::vector<std::string>& backends, const std::vector<std::string>& methods,
                   int finest) {
  for (const Method& method : all_methods()) {
    if (std::find(methods.begin(), methods.end(), method.name) == methods.end()) continue;
    const SwingingBeam beam(method);
    const double limit = beam.solver("reference")->stable_step();
    const double time = 200 * limit;
    const VecList truth = position_after(beam, "reference", time, 250 * finest);
    for (const std::string& backend : backends) {
      for (int fine = 1; fine <= finest / 4; fine *= 2) {
        const int steps = 250 * fine;
        const double error = relative_error(beam.body.model, position_after(beam, backend, time, steps), truth);
        file.row({backend, method.name, method.label, field(time / steps), field(time / steps / limit),
                  std::to_string(steps), field(error)});
        std::printf("%-10s %-16s dt %.3f of the limit: error %.3g\n", backend.c_str(), method.name.c_str(),
                    time / steps / limit, error);
        std::fflush(stdout);
      }
    }
  }
}

void equivalence(CsvFile& file, const std::vector<std::string>& backends, const std::vector<std::string>& methods,
                 int most_steps) {
  for (const Method& method : all_methods()) {
    if (std::find(methods.begin(), methods.end(), method.name) == methods.end()) continue;
    const SwingingBeam beam(method);
    const auto truth = beam.solver("reference");
    const double dt = 0.5 * truth->stable_step(), spacing = mean_spacing(beam.body.model);
    std::vector<std::unique_ptr<Solver>> others;
    for (const std::string& backend : backends) {
      if (backend != "reference") others.push_back(beam.solver(backend));
    }
    truth->reset(beam.start(dt));
    for (auto& other : others) other->reset(beam.start(dt));
    int done = 0;
    for (int steps = 1; steps <= most_steps; steps *= 2) {
      truth->step(steps - done, dt);
      const VecList expected = truth->read().position;
      for (auto& other : others) {
        const StepReport report = other->step(steps - done, dt);
        const VecList found = other->read().position;
        double largest = 0.0, square = 0.0;
        for (std::size_t i = 0; i < found.size(); ++i) {
          largest = std::max(largest, (found[i] - expected[i]).norm());
          square += (found[i] - expected[i]).squaredNorm();
        }
        file.row({std::string(other->name()), other->device(), method.name, method.label, std::to_string(steps),
                  field(largest / spacing), field(std::sqrt(square / double(found.size())) / spacing),
                  report.ok() ? "ok" : report.message()});
      }
      done = steps;
    }
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const KnownArguments known{{"order", "order_in_time.csv"},
                             {"equivalence", "equivalence.csv"},
                             {"methods", "springs_18,particle_averaged"},
                             {"backends", ""},
                             {"finest", "64"},
                             {"most-steps", "16384"}};
  if (prints_usage(argc, argv, "trajectory_error",
                   "Error of a trajectory against the step, and how far backends go apart. Lists are separated by\n"
                   "commas. finest: the smallest step is the stable one over so much; most-steps: of the comparison\n"
                   "of backends.",
                   known)) {
    return 0;
  }
  const Arguments arguments(argc, argv, known);
  std::vector<std::string> backends = arguments.list("backends");
  if (backends.empty()) {
    for (const std::string& name : backend_names()) {
      const std::string reason = why_unavailable(name);
      if (reason.empty()) {
        backends.push_back(name);
      } else {
        std::printf("backend %s is left out: %s\n", name.c_str(), reason.c_str());
      }
    }
  }
  const std::vector<std::string> methods = arguments.chosen("methods", method_names());
  CsvFile order(arguments.text("order"), {"backend", "method", "label", "dt", "share_of_limit", "steps", "error"});
  order_in_time(order, backends, methods, static_cast<int>(arguments.number("finest")));
  CsvFile distance(arguments.text("equivalence"),
                   {"backend", "device", "method", "label", "steps", "max_over_spacing", "rms_over_spacing", "status"});
  equivalence(distance, backends, methods, static_cast<int>(arguments.number("most-steps")));
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
