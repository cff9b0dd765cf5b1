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
#include "surface_body.h"

namespace {

void print_notes(const std::vector<std::string>& notes) {
  constexpr std::size_t most = 8;
  for (std::size_t k = 0; k < std::min(most, notes.size()); ++k) std::fprintf(stderr, "note: %s\n", notes[k].c_str());
  if (notes.size() > most) std::fprintf(stderr, "note: ... and %zu more\n", notes.size() - most);
}

/// The body with what acts on it. `notes`: null, or what reading the loads found.
phymul::Simulation make_simulation(const RunOptions& options, const phymul::Model& model,
                                   phymul::SimulationOptions made, Progress& progress,
                                   std::vector<std::string>* notes) {
  made.damping.rate = options.damping_rate;
  made.topology = options.topology;
  made.solver.profile = options.profile;
  made.solver.progress = [&progress](const phymul::StepProgress& step) {
    progress.show(step);
    return true;
  };
  phymul::Simulation sim(options.tearing ? with_room_for_cuts(model) : model, std::move(made));
  const phymul::Index spare = sim.model().particle_count() - model.particle_count();
  if (notes && spare > 0) notes->push_back(std::to_string(spare) + " spare particles for what tears");
  fill_scene(options, model, sim.scene(), notes);
  return sim;
}

/// For a body that is filled at a spacing.
phymul::Simulation make_candidate(RunOptions options, const phymul::PlanCandidate& candidate, Progress& progress) {
  options.spacing = candidate.spacing;
  const phymul::Model model = read_body(options);
  progress.show_trial(candidate.spacing, model.particle_count());
  return make_simulation(options, model, candidate.options({}), progress, nullptr);
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
  std::vector<std::string> notes;
  Progress progress(options.quiet);
  phymul::SimulationOptions made;
  made.backend = options.backend;
  made.solver.threads = options.threads;
  phymul::Simulation sim = make_simulation(options, model, std::move(made), progress, &notes);
  print_notes(notes);
  const phymul::Solver& solver = sim.solver();
  print_notes(solver.topology().notes);

  // A step that the solver refuses is wrong input, told before anything is computed or written.
  if (options.dt) {
    const phymul::StepReport probe = sim.step(0, *options.dt);
    if (!probe.ok()) throw phymul::Error("--dt: " + probe.message());
  }
  make_folder(options.out);
  const RunSchedule schedule = schedule_of(sim.scene().loads());
  RunLoop loop(options, schedule, sim, progress);
  const int exit_code = loop.run();
  phymul::write_csv(sim.model(), loop.state(), options.out + "/rest.csv");
  phymul::Model rest = phymul::deformed_model(sim.model(), loop.state());
  // Tears make copies of particles that have cells and no neighbours.
  if (options.tearing) rest.neighbours = phymul::neighbours_from_cells(rest.cells, rest.particle_count());
  phymul::write_pml(rest, options.out + "/rest.pml",
                    {.length_unit = length_unit("rest.pml", is_pml(options.body) ? options.length_unit : 0.0)});
  print_table(solver, loop.summary());
  if (options.profile) print_profile(solver.profile(), loop.summary());
  print_story(sim.scene(), schedule, loop.summary());
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
    return make_candidate(*options, candidate, progress);
  });
} catch (const std::exception& error) {
  std::fprintf(stderr, "phymul-run: %s\n", error.what());
  return 1;
}
