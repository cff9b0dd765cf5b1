// SPDX-License-Identifier: MIT
//
// Error against time: every reference case, by every model, at every resolution, step and backend, taken to rest by
// real stepping; bodies with a material also by Simulation::solve_static. Writes one CSV row each; what fails is a row
// with the failure's name. bench/charts.sh draws it.
#include <cstdio>
#include <limits>
#include <map>
#include <optional>

#include "arguments.h"
#include "csv_row.h"
#include "direct_rest.h"
#include "measures.h"
#include "methods.h"
#include "reference_case.h"
#include "stretch_calibration.h"

namespace {

using namespace phymul;
using namespace phymul::bench;

const std::vector<std::string> columns{
    "case",         "title",   "level",      "method",      "label",        "backend",    "rest",
    "device",       "n",       "particles",  "spacing",     "step_share",   "dt",         "stable_step",
    "damping_rate", "status",  "steps",      "wall_step",   "wall_to_rest", "wall_per_s", "error",
    "p95",          "max",     "median_ren", "force_error", "null_error",   "floor",      "force_floor",
    "stiffness",    "message", "cpu_per_s"};

const std::vector<std::string> sample_columns{"case",   "level", "method", "backend", "n",  "spacing", "step_share",
                                              "sample", "ux",    "uy",     "uz",      "rx", "ry",      "rz"};

struct Choice {
  std::vector<std::string> methods, backends, ways_to_rest;
  std::vector<double> step_shares;
  double stabiliser_share = 1.0;
  int threads = 0;
  double most_particles = 0.0, wall_cap = 0.0, rest_accuracy = 0.0;
  std::size_t most_resolutions = 0;
  ToolContact contact = ToolContact::particles;
  double most_particles_in_reference = 0.0;  // where the build has another backend, too
};

bool wanted(const std::vector<std::string>& list, const std::string& name) {
  return list.empty() || std::find(list.begin(), list.end(), name) != list.end();
}

void scale_stabiliser(MethodBody& body, double share) {
  const std::optional<double> calibrated = build_topology(body.model, body.options).options.stabiliser;
  if (calibrated) body.options.stabiliser = share * *calibrated;
}

/// One method on one problem: tables built and stiffness found once for all steps and backends.
struct Prepared {
  const Method* method = nullptr;
  MethodBody body;
  std::shared_ptr<const TopologyTextures> topology;
  double stiffness = std::numeric_limits<double>::quiet_NaN();  // N/m; not for materials
};

/// The slowest motion is a body's, not a mesh's: what a body of fewer particles told is good for finer ones.
struct Known {
  Excited excited;
  Index particles = 0;
};
constexpr Index most_to_find_excited = 600;
constexpr const char *by_steps = "steps", *solved = "solve_static";

class Run {
 public:
  Run(CsvFile& file, CsvFile* samples, Choice choice) : file_(file), samples_(samples), choice_(std::move(choice)) {}

  void level(const ReferenceCase& reference_case, const std::string& level) {
    std::size_t done = 0;
    for (const int n : reference_case.resolutions) {
      if (done++ == choice_.most_resolutions) break;
      Problem problem = make_problem(reference_case, level, n);
      for (Problem::NamedTool& named : problem.tools) named.tool.contact = choice_.contact;
      if (problem.model.particle_count() > choice_.most_particles) break;
      begin(reference_case, level, n, problem);
      for (const Method& method : all_methods()) {
        if (wanted(choice_.methods, method.name)) one_method(method, problem);
      }
    }
  }

 private:
  void begin(const ReferenceCase& reference_case, const std::string& level, int n, const Problem& problem) {
    const std::optional<PositionError> null = null_error(problem);
    common_ = {{"case", reference_case.name},
               {"title", reference_case.title},
               {"level", level},
               {"n", std::to_string(n)},
               {"particles", std::to_string(problem.model.particle_count())},
               {"spacing", field(mean_spacing(problem.model))},
               {"floor", field(problem.floor)},
               {"force_floor", field(problem.force_floor)},
               {"null_error", null ? field(null->global_ratio) : std::string()}};
  }

  void one_method(const Method& method, const Problem& problem) {
    const std::vector<std::string> backends = choice_.backends.empty() ? backend_names() : choice_.backends;
    RelaxationPlan plan;
    plan.backend = wanted(backends, "cpu") ? "cpu" : backends.front();  // for the stretching test
    plan.wall_cap = choice_.wall_cap;
    plan.threads = choice_.threads;
    plan.rest_accuracy = choice_.rest_accuracy;
    Prepared prepared;
    prepared.method = &method;
    try {
      prepared.body = body_for(method, problem);
      if (choice_.stabiliser_share != 1.0) scale_stabiliser(prepared.body, choice_.stabiliser_share);
      prepared.stiffness = stiffness(method, problem, prepared.body, plan);
      if (method.rule != StiffnessRule::material) set_stiffness(prepared.body, prepared.stiffness);
      prepared.topology =
          std::make_shared<const TopologyTextures>(build_topology(prepared.body.model, prepared.body.options));
    } catch (const Error& error) {
      write(method, plan, refused(error), nullptr, problem);
      return;
    }
    if (wanted(choice_.ways_to_rest, by_steps)) {
      for (const std::string& backend : backends) {
        const bool slow = backend == "reference" && backends.size() > 1;
        if (slow && problem.model.particle_count() > choice_.most_particles_in_reference) continue;
        for (const double share : choice_.step_shares) {
          plan.backend = backend;
          plan.step_share = share;
          relax_and_write(prepared, plan, problem);
        }
      }
    }
    if (method.rule == StiffnessRule::material && wanted(choice_.ways_to_rest, solved)) {
      plan.backend = "cpu";  // the search uses its kernels, whatever the backend of the solver
      plan.step_share = 0.0;
      measure_and_write(prepared, plan, solve_directly(problem, prepared.body, start_of(problem), plan), problem);
    }
  }

  static VecList start_of(const Problem& problem) {
    VecList start = problem.model.rest;
    for (std::size_t i = 0; i < start.size(); ++i) start[i] += problem.displacement[i];
    return start;
  }

  double stiffness(const Method& method, const Problem& problem, const MethodBody& body, RelaxationPlan plan) const {
    const Material& material = problem.model.materials.front();
    switch (method.rule) {
      case StiffnessRule::material:
        return std::numeric_limits<double>::quiet_NaN();
      case StiffnessRule::lattice:
        return spring_stiffness(body, material);
      case StiffnessRule::stretched:
        break;
    }
    plan.step_share = 0.5;
    return stretched_stiffness(body, material, plan);
  }

  void relax_and_write(const Prepared& prepared, const RelaxationPlan& plan, const Problem& problem) {
    RelaxationPlan informed = plan;
    Known& known = known_[{common_.at("case"), common_.at("level"), prepared.method->name}];
    const Index particles = problem.model.particle_count();
    if (known.particles == particles || particles > most_to_find_excited) informed.excited = known.excited;
    const Relaxation relaxation =
        relax(prepared.topology, problem.scene(prepared.body.model), start_of(problem), informed);
    if (relaxation.status == "ok") known = {relaxation.excited, particles};
    measure_and_write(prepared, plan, relaxation, problem);
  }

  void measure_and_write(const Prepared& prepared, const RelaxationPlan& plan, const Relaxation& relaxation,
                         const Problem& problem) {
    const Scene scene = problem.scene(prepared.body.model);
    stiffness_ = prepared.stiffness;
    if (relaxation.state.position.empty()) {
      write(*prepared.method, plan, relaxation, nullptr, problem);
      return;
    }
    const Measures measures =
        measure(problem, *prepared.topology, scene, relaxation.state.position, relaxation.tool_force);
    write(*prepared.method, plan, relaxation, &measures, problem);
    if (relaxation.status == "ok" && samples_) write_samples(*prepared.method, plan, relaxation.state, problem);
  }

  void write_samples(const Method& method, const RelaxationPlan& plan, const State& state, const Problem& problem) {
    if (!problem.samples) return;
    const VecList found = problem.samples->deform(state.position);
    for (std::size_t s = 0; s < found.size(); ++s) {
      const Vec3 u = found[s] - problem.sample_point[s];
      const Vec3& r = problem.reference[s];
      samples_->row({common_["case"], common_["level"], method.name, plan.backend, common_["n"], common_["spacing"],
                     field(plan.step_share), std::to_string(s), field(u.x()), field(u.y()), field(u.z()), field(r.x()),
                     field(r.y()), field(r.z())});
    }
  }

  void write(const Method& method, const RelaxationPlan& plan, const Relaxation& it, const Measures* measures,
             const Problem& problem) {
    std::map<std::string, std::string> row = common_;
    const double size = body_size(problem.model);
    row["method"] = method.name;
    row["label"] = method.label;
    const bool steps = plan.step_share > 0.0;
    row["backend"] = plan.backend;
    row["rest"] = steps ? by_steps : solved;
    row["device"] = it.device;
    if (steps) {
      row["step_share"] = field(plan.step_share);
      row["dt"] = field(it.dt);
      row["stable_step"] = field(it.stable_step);
      row["damping_rate"] = field(it.rate);
    }
    row["status"] = it.status;
    row["message"] = it.message;
    row["steps"] = std::to_string(it.steps);
    row["stiffness"] = field(stiffness_);
    if (it.wall_per_step > 0.0) {
      row["wall_to_rest"] = field(it.wall_to_rest());
      if (steps) row["wall_step"] = field(it.wall_per_step);
      if (steps) row["wall_per_s"] = field(it.wall_per_step / it.dt);
      if (steps) row["cpu_per_s"] = field(it.cpu_per_step / it.dt);
    }
    if (measures && measures->displacement) {
      row["error"] = field(measures->displacement->global_ratio);
      row["p95"] = field(measures->displacement->p95 / size);
      row["max"] = field(measures->displacement->max / size);
      row["median_ren"] = field(measures->displacement->median_ren);
    }
    if (measures && measures->force_error) row["force_error"] = field(*measures->force_error);
    std::vector<std::string> fields;
    for (const std::string& column : columns) fields.push_back(row[column]);
    file_.row(fields);
    std::printf("%-20s %-14s %-18s %-10s n %2s %5s particles  step %.2f  %-12s error %-10s force %-10s %6d %s %s s\n",
                row["case"].c_str(), row["level"].c_str(), method.name.c_str(), plan.backend.c_str(), row["n"].c_str(),
                row["particles"].c_str(), plan.step_share, it.status.c_str(), row["error"].c_str(),
                row["force_error"].c_str(), it.steps, steps ? "steps" : "evaluations", row["wall_to_rest"].c_str());
    std::fflush(stdout);
  }

  CsvFile& file_;
  CsvFile* samples_;
  Choice choice_;
  std::map<std::string, std::string> common_;
  std::map<std::array<std::string, 3>, Known> known_;  // by case, level, method
  double stiffness_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace

int main(int argc, char** argv) try {
  const KnownArguments known{{"cases", "bench/reference"},
                             {"levels", "main"},
                             {"methods", ""},
                             {"backends", ""},
                             {"steps", "0.9,0.5"},
                             {"rest", "steps,solve_static"},
                             {"most-particles", "4913"},
                             {"most-particles-in-reference", "4913"},
                             {"most-resolutions", "99"},
                             {"wall-cap", "20"},
                             {"threads", "0"},
                             {"rest-accuracy", "1e-4"},
                             {"stabiliser", "1"},
                             {"contact", "particles"},
                             {"samples", ""},
                             {"out", "work_precision.csv"}};
  if (prints_usage(argc, argv, "work_precision",
                   "Error against time of every reference case, model, resolution and backend. Lists are separated\n"
                   "by commas. cases: files or folders; levels: main, all, or names; steps: in shares of the stable\n"
                   "one; rest: by steps, by solve_static; wall-cap: seconds for a run; stabiliser: in shares of the\n"
                   "calibrated one; contact: what tools touch, particles or surface; samples: a CSV file for\n"
                   "displacements; threads: of the backend cpu, 0: as it chooses.",
                   known)) {
    return 0;
  }
  const Arguments arguments(argc, argv, known);
  Choice choice;
  choice.methods = arguments.chosen("methods", method_names());
  choice.backends = arguments.list("backends");
  choice.step_shares = arguments.numbers("steps");
  choice.ways_to_rest = arguments.chosen("rest", {by_steps, solved});
  choice.stabiliser_share = arguments.number("stabiliser");
  choice.most_particles = arguments.number("most-particles");
  choice.most_particles_in_reference = arguments.number("most-particles-in-reference");
  choice.most_resolutions = static_cast<std::size_t>(arguments.number("most-resolutions"));
  const std::string& contact = arguments.text("contact");
  if (contact != "particles" && contact != "surface") {
    throw Error("--contact: expected particles or surface, got \"" + contact + "\"");
  }
  choice.contact = contact == "surface" ? ToolContact::surface : ToolContact::particles;
  choice.wall_cap = arguments.number("wall-cap");
  choice.threads = static_cast<int>(arguments.number("threads"));
  choice.rest_accuracy = arguments.number("rest-accuracy");
  CsvFile file(arguments.text("out"), columns);
  std::unique_ptr<CsvFile> samples;
  if (!arguments.text("samples").empty()) {
    samples = std::make_unique<CsvFile>(arguments.text("samples"), sample_columns);
  }
  Run run(file, samples.get(), choice);
  bool ran = false;
  for (const std::string& path : arguments.list("cases")) {
    for (const ReferenceCase& reference_case : read_cases(path)) {
      const bool main_only = arguments.text("levels") == "main";
      for (const ReferenceCase::Level& level : reference_case.levels) {
        if (main_only ? wanted(reference_case.levels_to_draw(), level.name)
                      : arguments.text("levels") == "all" || wanted(arguments.list("levels"), level.name)) {
          run.level(reference_case, level.name);
          ran = true;
        }
      }
    }
  }
  if (!ran) throw Error("--levels: none of the cases has a level of \"" + arguments.text("levels") + '"');
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
