// SPDX-License-Identifier: MIT
//
// phymul-run BODY [LOADS]: pulls a body as its loads say, lets it go, runs until it rests, and reports.
#include <phymul/error.h>
#include <phymul/lml.h>
#include <phymul/mesh.h>
#include <phymul/pml.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "run_loop.h"
#include "run_options.h"
#include "run_plan.h"
#include "run_report.h"
#include "run_schedule.h"
#include "surface_body.h"

namespace {

void print_notes(const std::vector<std::string>& notes) {
  constexpr std::size_t most = 8;
  for (std::size_t k = 0; k < std::min(most, notes.size()); ++k) std::fprintf(stderr, "note: %s\n", notes[k].c_str());
  if (notes.size() > most) std::fprintf(stderr, "note: ... and %zu more\n", notes.size() - most);
}

bool is_pml(const std::string& path) {
  return std::filesystem::path(path).extension() == ".pml";
}

/// A mesh file is in metres unless told otherwise, a PML file in millimetres, as the readers have it.
double length_unit(const RunOptions& options) {
  if (options.length_unit > 0.0) return options.length_unit;
  return is_pml(options.body) ? phymul::PmlOptions{}.length_unit : phymul::MeshOptions{}.length_unit;
}

phymul::Model read_file(const RunOptions& options) {
  if (is_surface(options.body)) {
    return fill_surface(options.body, length_unit(options), options.spacing, options.fine_balls).model;
  }
  if (is_label_image(options.body)) {
    if (options.length_unit > 0.0) throw phymul::Error("--unit: " + options.body + " says its unit itself");
    return fill_labels(options.body, options.spacing, options.fine_balls);
  }
  if (!options.fine_balls.empty()) {
    throw phymul::Error("--fine-near: expected a surface or a labelled image to be filled, got " + options.body);
  }
  if (options.spacing != 0.0) {
    throw phymul::Error("--spacing: " + options.body + " is neither a surface nor a labelled image to be filled");
  }
  const double unit = length_unit(options);
  return is_pml(options.body) ? phymul::read_pml(options.body, {.length_unit = unit})
                              : phymul::read_mesh(options.body, {.length_unit = unit});
}

phymul::Model read_body(const RunOptions& options) {
  phymul::Model model = read_file(options);
  if (options.from_file) return model;
  if (std::none_of(model.cells.begin(), model.cells.end(),
                   [](const phymul::Cell& cell) { return phymul::is_volume(cell.type); })) {
    throw phymul::Error(options.body +
                        ": expected volume cells, which a material needs, got none; give --from-file to "
                        "run it with the file's own masses and stiffnesses");
  }
  phymul::set_material(model, options.material);
  for (auto [group, material] : options.materials) {
    material.density = options.material.density;
    phymul::set_material(model, material, group);
  }
  return model;
}

void fill_scene(const RunOptions& options, const phymul::Model& model, phymul::Scene& scene) {
  if (!options.loads.empty()) {
    std::vector<std::string> notes;
    scene.add(phymul::read_lml(options.loads, model, &notes));
    if (!options.plan) print_notes(notes);
  }
  for (const std::string& group : options.fixed_groups) scene.fix(group);
  for (std::size_t k = 0; k < options.fixed_balls.size(); k += 4) {
    scene.fix(particles_in_ball(model, &options.fixed_balls[k]));
  }
  const std::vector<double> gravity = options.gravity.empty() ? std::vector<double>(3, 0.0) : options.gravity;
  scene.gravity({gravity[0], gravity[1], gravity[2]});
}

/// For a body that is filled at a spacing.
phymul::Simulation make_simulation(RunOptions options, const phymul::PlanCandidate& candidate) {
  options.spacing = candidate.spacing;
  phymul::Simulation sim(read_body(options),
                         candidate.options({.damping = {.rate = options.damping_rate}, .topology = options.topology}));
  fill_scene(options, sim.model(), sim.scene());
  return sim;
}

void make_folder(const std::string& path) {
  std::error_code problem;
  std::filesystem::create_directories(path, problem);
  if (problem)
    throw phymul::Error(path + ": this folder cannot be made (" + problem.message() + "); give another --out");
}

int run(const RunOptions& options) {
  const phymul::Model model = read_body(options);
  print_notes(model.notes);
  phymul::Scene scene(model);
  fill_scene(options, model, scene);
  phymul::SolverOptions solver_options;
  solver_options.damping.rate = options.damping_rate;
  solver_options.profile = options.profile;
  solver_options.threads = options.threads;
  Progress progress(options.quiet);
  solver_options.progress = [&progress](const phymul::StepProgress& step) {
    progress.show(step);
    return true;
  };
  const auto solver = phymul::make_solver(options.backend, model, scene, options.topology, solver_options);
  print_notes(solver->topology().notes);

  // A step that the solver refuses is wrong input, told before anything is computed or written.
  if (options.dt) {
    const phymul::StepReport probe = solver->step(0, *options.dt);
    if (!probe.ok()) throw phymul::Error("--dt: " + probe.message());
  }
  make_folder(options.out);
  const RunSchedule schedule = schedule_of(scene.loads());
  RunLoop loop(options, schedule, scene, *solver, progress);
  const int exit_code = loop.run();
  phymul::write_csv(model, loop.state(), options.out + "/rest.csv");
  phymul::write_pml(phymul::deformed_model(model, loop.state()), options.out + "/rest.pml",
                    {.length_unit = length_unit(options)});
  print_table(*solver, loop.summary());
  if (options.profile) print_profile(solver->profile(), loop.summary());
  print_story(scene, schedule, loop.summary());
  if (exit_code == 2) std::fprintf(stderr, "phymul-run: %s\n", loop.summary().failure.c_str());
  std::printf("\nresults in %s\n", options.out.c_str());
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) try {
  int exit_code = 0;
  const std::optional<RunOptions> options = read_run_options(argc, argv, exit_code);
  if (!options) return exit_code;
  if (!options->plan) return run(*options);
  return print_plan(*options, std::vector<std::string>(argv, argv + argc),
                    [&](const phymul::PlanCandidate& candidate) { return make_simulation(*options, candidate); });
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "phymul-run: %s\n", error.what());
  return 1;
} catch (const std::filesystem::filesystem_error& error) {
  std::fprintf(stderr, "phymul-run: %s\n", error.what());
  return 1;
}
