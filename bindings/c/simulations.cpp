// SPDX-License-Identifier: MIT
#include <algorithm>

#include "handles.h"

using namespace phymul;
using namespace phymul::c;

static_assert(static_cast<int>(LoadType::translation) == PHYMUL_TRANSLATION);
static_assert(static_cast<int>(LoadType::rotation) == PHYMUL_ROTATION);
static_assert(static_cast<int>(LoadType::force) == PHYMUL_FORCE);
static_assert(static_cast<int>(LoadType::pressure) == PHYMUL_PRESSURE);
static_assert(static_cast<int>(LoadType::acceleration) == PHYMUL_ACCELERATION);

namespace {

Simulation& of(phymul_simulation* handle) {
  return need(handle, "a simulation").simulation;
}

const Simulation& of(const phymul_simulation* handle) {
  return need(handle, "a simulation").simulation;
}

/// The same before what moves its particles.
Simulation& moving(phymul_simulation* handle) {
  need(handle, "a simulation").moved = true;
  return handle->simulation;
}

/// Threads of the program.
class Runner final : public TaskRunner {
 public:
  Runner(phymul_run_parts run_parts, void* user, int32_t width) : run_parts_(run_parts), user_(user), width_(width) {
    if (width < 1)
      throw Error("expected a run_parts_width of 1 (the calling thread alone) or more, got " + std::to_string(width));
  }

  int width() const override { return width_; }
  void run(int count, const std::function<void(int)>& task) override {
    const auto part = [](void* of, int32_t k) { (*static_cast<const std::function<void(int)>*>(of))(k); };
    run_parts_(user_, count, part, const_cast<std::function<void(int)>*>(&task));
  }

 private:
  phymul_run_parts run_parts_;
  void* user_;
  int width_;
};

SimulationOptions options_for(const phymul_options* given) {
  const phymul_options from = options_of(given, "options of a simulation");
  SimulationOptions options;
  if (from.material) options.material = material_of(from.material);
  if (from.material && options.material == Material{})  // which C++ takes for none
    throw Error("expected a material with a Young's modulus above 0, or NULL, got one of zeros");
  if (from.backend) options.backend = from.backend;
  options.damping.rate = from.damping_rate;
  if (from.step != 0.0) options.step = from.step;
  if (from.rest_tolerance != 0.0) options.solver.rest_tolerance = from.rest_tolerance;
  options.solver.threads = from.threads;
  options.tick_budget = from.tick_budget;
  if (from.sleeps != 0) options.solver.sleep_tolerance = from.sleep_tolerance;
  if (from.run_parts)
    options.runner = std::make_shared<Runner>(from.run_parts, from.run_parts_user, from.run_parts_width);
  return options;
}

Simulation simulation_of(std::span<const phymul_body* const> bodies, const char* const* names,
                         const phymul_options* given) {
  const SimulationOptions options = options_for(given);
  if (bodies.empty()) throw Error("expected at least one body, got none");
  if (!names) {
    if (bodies.size() > 1) throw Error("expected a name for each of several bodies, got NULL for the names");
    return Simulation(need(bodies.front(), "a body").model, options);
  }
  std::vector<SimulationBody> named;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    require_name(names[i], "a name of the body");
    named.push_back({.name = names[i], .model = need(bodies[i], "a body").model});
  }
  return Simulation(std::move(named), options);
}

std::vector<ValueEvent> events_of(const double* times, const double* values, int32_t count) {
  list(times, count, "times");
  list(values, count, "values");
  std::vector<ValueEvent> events(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < events.size(); ++i) events[i] = {.date = times[i], .value = values[i]};
  return events;
}

template <class Step>
phymul_status step_by(phymul_simulation* sim, phymul_step_report* report, Step&& step) {
  return guarded([&] {
    const auto place = place_if_wanted(report, "a report");
    const StepReport done = step(moving(sim));
    sim->message = done.message();
    if (place)
      place->fill({.size = 0,
                   .steps = done.steps,
                   .at_rest = done.at_rest,
                   .force_clamped = done.force_clamped,
                   .particle = done.particle,
                   .time = done.time,
                   .dt = done.dt,
                   .stable_step = done.stable_step,
                   .residual = done.residual,
                   .max_speed = done.max_speed,
                   .springs_broken = done.springs_broken,
                   .tissue_gave_way = done.tissue_gave_way,
                   .uncut = done.uncut,
                   .torn = done.torn,
                   .cut_later = done.cut_later,
                   .unused = 0});
    if (!done.ok()) throw Failure{PHYMUL_STEP_FAILED, sim->message};
  });
}

/// Copies values into a buffer that keeps its place.
template <class Read>
phymul_status copy_out(VecList phymul_simulation::*buffer, phymul_simulation* sim, const double** out, int32_t* count,
                       Read&& read) {
  return guarded([&] {
    need(out, "a place for the list");
    need(count, "a place for the number");
    const VecList values = read(of(sim));
    VecList& kept = sim->*buffer;
    if (kept.empty()) kept.resize(values.size());
    std::ranges::copy(values, kept.begin());
    hand_out(doubles(kept), kept.size(), out, count, "a place for the list");
  });
}

template <class Result, class Place>
void report_rest(phymul_simulation* sim, const Result& rest, const Place& place, phymul_rest_report report) {
  sim->message = rest.message();
  if (rest.status == RestStatus::failed) throw Failure{PHYMUL_STEP_FAILED, sim->message};
  report.converged = rest.converged();
  report.folded = rest.folded;
  if (place) place->fill(report);
}

/// Zeros of `options` are the defaults.
phymul_status solve_static(phymul_simulation* sim, StaticOptions options, phymul_rest_report* report) {
  return guarded([&] {
    const auto place = place_if_wanted(report, "a report");
    const StaticOptions usual;
    if (options.tolerance == 0.0) options.tolerance = usual.tolerance;
    if (options.most_evaluations == 0) options.most_evaluations = usual.most_evaluations;
    const StaticResult rest = moving(sim).solve_static(options);
    report_rest(sim, rest, place, {0, 0, 0, rest.evaluations, -1, of(sim).time(), rest.residual});
  });
}

}  // namespace

phymul_status phymul_simulation_create(const phymul_body* const* bodies, const char* const* names, int32_t count,
                                       const phymul_options* options, phymul_simulation** made) {
  return guarded([&] {
    need(made, "a place for the simulation");
    *made = new phymul_simulation{simulation_of(list(bodies, count, "bodies"), names, options)};
  });
}

void phymul_simulation_free(phymul_simulation* sim) {
  delete sim;
}

phymul_status phymul_simulation_body(const phymul_simulation* sim, phymul_body** made) {
  return guarded([&] {
    need(made, "a place for the body");
    *made = new phymul_body{of(sim).model()};
  });
}

phymul_status phymul_fix(phymul_simulation* sim, const char* group) {
  return guarded([&] { of(sim).scene().fix(&need(group, "a name of the group")); });
}

phymul_status phymul_fix_particles(phymul_simulation* sim, const int32_t* particles, int32_t count) {
  return guarded([&] { of(sim).scene().fix(list(particles, count, "particles")); });
}

phymul_status phymul_remove_cells(phymul_simulation* sim, const int32_t* cells, int32_t count) {
  return guarded([&] { of(sim).remove_cells(list(cells, count, "cells")); });
}

phymul_status phymul_cut(phymul_simulation* sim, const double point[3], const double normal[3],
                         const double* front_point, const double* front_normal, int32_t* whether) {
  return guarded([&] {
    const bool parted = of(sim).cut(cut_behind(point, normal, front_point, front_normal));
    if (whether) *whether = parted ? 1 : 0;
  });
}

phymul_status phymul_cuts(const phymul_simulation* sim, int32_t* count) {
  return guarded([&] { need(count, "a place for the number") = static_cast<int32_t>(of(sim).cuts().size()); });
}

phymul_status phymul_scale_stiffness(phymul_simulation* sim, const phymul_material* material, double factor) {
  return guarded([&] {
    Scene& scene = of(sim).scene();
    material ? scene.scale_stiffness(material_of(material), factor) : scene.scale_stiffness(factor);
  });
}

phymul_status phymul_gravity(phymul_simulation* sim, const double acceleration[3]) {
  return guarded([&] { of(sim).scene().gravity(vector(acceleration, "an acceleration")); });
}

phymul_status phymul_add_load(phymul_simulation* sim, int32_t type, const int32_t* particles, int32_t count,
                              const double direction[3], const double* times, const double* values, int32_t value_count,
                              int32_t* row) {
  return guarded([&] {
    need(row, "a place for the row");
    require_kind(type, PHYMUL_TRANSLATION, 5, "a type of loads");
    const auto rows = list(particles, count, "particles");
    Scene& scene = of(sim).scene();
    Load load;
    load.type = static_cast<LoadType>(type);
    load.particles.assign(rows.begin(), rows.end());
    load.direction = vector(direction, "a direction");
    load.events = events_of(times, values, value_count);
    scene.add(std::move(load));
    *row = static_cast<int32_t>(scene.loads().size()) - 1;
  });
}

phymul_status phymul_set_load(phymul_simulation* sim, int32_t row, const double* times, const double* values,
                              int32_t value_count) {
  return guarded([&] {
    Scene& scene = of(sim).scene();
    if (row < 0 || row >= std::ssize(scene.loads()))
      throw Error("expected a row of the scene's " + std::to_string(scene.loads().size()) + " loads, got " +
                  std::to_string(row));
    scene.set_events(static_cast<std::size_t>(row), events_of(times, values, value_count));
  });
}

phymul_status phymul_contacts(phymul_simulation* sim, double friction, double margin, int32_t self) {
  return guarded([&] { of(sim).scene().contacts({.friction = friction, .margin = margin, .self = self != 0}); });
}

phymul_status phymul_constrain_volume(phymul_simulation* sim, const char* group) {
  return guarded([&] {
    Scene& scene = of(sim).scene();
    group ? scene.constrain_volume(group) : scene.constrain_volume();
  });
}

phymul_status phymul_advance(phymul_simulation* sim, double seconds, phymul_step_report* report) {
  return step_by(sim, report, [&](Simulation& simulation) { return simulation.advance(seconds); });
}

phymul_status phymul_step(phymul_simulation* sim, int32_t steps, double dt, phymul_step_report* report) {
  return step_by(sim, report, [&](Simulation& simulation) { return simulation.step(steps, dt); });
}

phymul_status phymul_run_to_rest(phymul_simulation* sim, int32_t most_steps, phymul_rest_report* report) {
  return guarded([&] {
    const auto place = place_if_wanted(report, "a report");
    const RestResult rest = moving(sim).run_to_rest(most_steps);
    report_rest(sim, rest, place, {0, 0, 0, rest.report.steps, rest.collapsed, rest.report.time, rest.report.residual});
  });
}

phymul_status phymul_solve_static(phymul_simulation* sim, double tolerance, int32_t most_evaluations,
                                  phymul_rest_report* report) {
  return solve_static(sim, {tolerance, most_evaluations, false}, report);
}

phymul_status phymul_follow_static(phymul_simulation* sim, double tolerance, int32_t most_evaluations,
                                   phymul_rest_report* report) {
  return solve_static(sim, {tolerance, most_evaluations, true}, report);
}

phymul_status phymul_message(phymul_simulation* sim, const char** sentence) {
  return guarded([&] { need(sentence, "a place for the sentence") = need(sim, "a simulation").message.c_str(); });
}

phymul_status phymul_warnings(phymul_simulation* sim, const char** sentences) {
  return guarded([&] {
    need(sentences, "a place for the sentences");
    need(sim, "a simulation").warnings = lines(of(sim).warnings());
    *sentences = sim->warnings.c_str();
  });
}

phymul_status phymul_time(const phymul_simulation* sim, double* time) {
  return guarded([&] { need(time, "a place for the time") = of(sim).time(); });
}

phymul_status phymul_step_limits(const phymul_simulation* sim, double* stable, double* taken) {
  return guarded([&] {
    need(taken, "a place for the step");
    need(stable, "a place for the stable step") = of(sim).solver().stable_step();
    *taken = of(sim).step_limit();
  });
}

phymul_status phymul_backend(phymul_simulation* sim, const char** name) {
  return guarded([&] {
    need(name, "a place for the name");
    need(sim, "a simulation").backend = of(sim).solver().name();
    *name = sim->backend.c_str();
  });
}

phymul_status phymul_energy(const phymul_simulation* sim, double energy[3]) {
  return guarded([&] {
    need(energy, "a place for the energies");
    const Energy now = of(sim).energy();
    energy[0] = now.elastic;
    energy[1] = now.kinetic;
    energy[2] = now.gravity;
  });
}

phymul_status phymul_positions(phymul_simulation* sim, const double** positions, int32_t* particle_count) {
  return copy_out(&phymul_simulation::positions, sim, positions, particle_count,
                  [](Simulation& simulation) { return simulation.solver().read().position; });
}

phymul_status phymul_velocities(phymul_simulation* sim, const double** velocities, int32_t* particle_count) {
  return copy_out(&phymul_simulation::velocities, sim, velocities, particle_count,
                  [](Simulation& simulation) { return simulation.state().velocity; });
}

phymul_status phymul_forces(phymul_simulation* sim, const double** forces, int32_t* particle_count) {
  return copy_out(&phymul_simulation::forces, sim, forces, particle_count, [](Simulation& simulation) {
    const VecList position = simulation.solver().read().position;
    VecList force(position.size());
    elastic_forces(simulation.solver().topology(), position, force, simulation.scene().stiffness_factors());
    return force;
  });
}

phymul_status phymul_set_state(phymul_simulation* sim, double time, const double* positions, const double* velocities) {
  return guarded([&] {
    const Model& model = of(sim).model();
    State state = rest_state(model);
    state.time = time;
    if (positions) state.position = vectors(positions, model.particle_count(), "positions");
    if (velocities) state.velocity = vectors(velocities, model.particle_count(), "velocities");
    moving(sim).set_state(state);
  });
}

phymul_status phymul_snapshot_take(const phymul_simulation* sim, phymul_snapshot** made) {
  return guarded([&] {
    need(made, "a place for the snapshot");
    *made = new phymul_snapshot{of(sim).snapshot()};
  });
}

phymul_status phymul_snapshot_restore(const phymul_snapshot* snapshot, phymul_simulation* sim) {
  return guarded([&] { moving(sim).restore(need(snapshot, "a snapshot").snapshot); });
}

void phymul_snapshot_free(phymul_snapshot* snapshot) {
  delete snapshot;
}

phymul_status phymul_save(const phymul_simulation* sim, const char* path) {
  return guarded([&] { of(sim).save(&need(path, "a path")); });
}

phymul_status phymul_load(phymul_simulation* sim, const char* path) {
  return guarded([&] {
    of(sim).load(&need(path, "a path"));
    moving(sim);
  });
}

phymul_status phymul_record(phymul_simulation* sim) {
  return guarded([&] { of(sim).record(); });
}

phymul_status phymul_save_recording(const phymul_simulation* sim, const char* path) {
  return guarded([&] { save_recording(of(sim).recording(), &need(path, "a path")); });
}

phymul_status phymul_replay(phymul_simulation* sim, const char* path) {
  return guarded([&] {
    Recording recording = read_recording(&need(path, "a path"));
    moving(sim).replay(std::move(recording));
  });
}

phymul_status phymul_write_vtu(const phymul_simulation* sim, const char* path) {
  return guarded([&] { write_vtu(of(sim).model(), of(sim).state(), &need(path, "a path")); });
}
