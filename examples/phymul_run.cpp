// SPDX-License-Identifier: MIT
//
// phymul-run BODY [LOADS]: pulls a body as its loads say, lets it go, runs until it rests, and reports.
#include <phymul/error.h>
#include <phymul/pml.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "run_body.h"
#include "run_loop.h"
#include "run_options.h"
#include "run_plan.h"
#include "run_report.h"
#include "run_schedule.h"

namespace {

void print_notes(const std::vector<std::string>& notes) {
  constexpr std::size_t most = 8;
  for (std::size_t k = 0; k < std::min(most, notes.size()); ++k) std::fprintf(stderr, "note: %s\n", notes[k].c_str());
  if (notes.size() > most) std::fprintf(stderr, "note: ... and %zu more\n", notes.size() - most);
}

phymul::SolverOptions telling(Progress& progress) {
  phymul::SolverOptions options;
  options.progress = [&progress](const phymul::StepProgress& step) {
    progress.show(step);
    return true;
  };
  return options;
}

/// For a body that is filled at a spacing.
phymul::Simulation make_simulation(RunOptions options, const phymul::PlanCandidate& candidate, Progress& progress) {
  options.spacing = candidate.spacing;
  phymul::Simulation sim(read_body(options), candidate.options({.damping = {.rate = options.damping_rate},
                                                                .topology = options.topology,
                                                                .solver = telling(progress)}));
  progress.show_trial(candidate.spacing, sim.model().particle_count());
  fill_scene(options, sim.model(), sim.scene(), nullptr);
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
  std::vector<std::string> notes;
  fill_scene(options, model, scene, &notes);
  print_notes(notes);
  Progress progress(options.quiet);
  phymul::SolverOptions solver_options = telling(progress);
  solver_options.damping.rate = options.damping_rate;
  solver_options.profile = options.profile;
  solver_options.threads = options.threads;
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
  Progress progress(options->quiet);
  return print_plan(*options, std::vector<std::string>(argv, argv + argc), [&](const phymul::PlanCandidate& candidate) {
    return make_simulation(*options, candidate, progress);
  });
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "phymul-run: %s\n", error.what());
  return 1;
} catch (const std::filesystem::filesystem_error& error) {
  std::fprintf(stderr, "phymul-run: %s\n", error.what());
  return 1;
}
