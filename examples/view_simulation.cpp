// SPDX-License-Identifier: MIT
#include "view_simulation.h"

#include "surface_body.h"

#include <phymul/bodies.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <cstdio>

namespace {

constexpr double longest_frame = 1.0 / 40.0;  // s; a slower one takes fewer steps
constexpr double frame = 1.0 / 60.0;          // s

bool is_cuttable(const phymul::Model& model) {
  const auto is_tetrahedron = [](phymul::CellType type) { return type == phymul::CellType::tetrahedron; };
  const auto is_other_volume = [](phymul::CellType type) {
    return phymul::is_volume(type) && type != phymul::CellType::tetrahedron;
  };
  return !model.materials.empty() && std::ranges::any_of(model.cells, is_tetrahedron, &phymul::Cell::type) &&
         std::ranges::none_of(model.cells, is_other_volume, &phymul::Cell::type);
}

}  // namespace

ViewSimulation::ViewSimulation(const FileBody& body, const ViewOptions& options)
    : body_(body),
      options_(options),
      can_be_cut_(is_cuttable(body.model)),
      sim_(make(options.backend)),
      beginning_(snapshot()) {
  if (body.surface) skin_.emplace(sim_.model(), body.surface->vertices);
  show();
}

phymul::Simulation ViewSimulation::make(const std::string& backend) const {
  phymul::SimulationOptions options;
  options.backend = backend;
  options.damping.rate = options_.damping_rate;
  options.step = options_.step_share;
  options.solver.gl.context = phymul::GlContext::current;
  phymul::Simulation sim(can_be_cut_ ? with_room_for_cuts(model()) : model(), options);
  phymul::Scene& scene = sim.scene();
  std::vector<std::string> notes;
  if (!options_.loads.empty()) scene.add(phymul::read_lml(options_.loads, model(), &notes));
  for (std::string& done : phymul::add_body_types(scene)) notes.push_back(std::move(done));
  for (const std::string& note : notes) std::fprintf(stderr, "note: %s\n", note.c_str());
  for (const std::string& group : options_.fixed_groups) scene.fix(group);
  for (std::size_t k = 0; k < options_.fixed_balls.size(); k += 4) {
    scene.fix(particles_in_ball(model(), &options_.fixed_balls[k]));
  }
  hold_in_balls(scene, body_.surface ? &*body_.surface : nullptr, options_.spacing, options_.held_balls);
  sim.solver();  // made here, where its errors belong
  return sim;
}

/// Without what only the same backend knows.
phymul::Snapshot ViewSimulation::snapshot() const {
  phymul::Snapshot now = sim_.snapshot();
  now.displacement.clear();
  now.parts.clear();
  return now;
}

void ViewSimulation::go_back(const phymul::Snapshot& snapshot) {
  sim_.restore(snapshot);
  some_uncut_ = false;
  failure_.clear();
}

void ViewSimulation::show() {
  const phymul::GlOptions gl{.context = phymul::GlContext::current};
  pieces_ = is_cut() ? connected_bodies(sim_.model()).size() : 1;
  if (!shows_skin()) {
    display_ = phymul::make_display(sim_.solver(), gl);
  } else if (is_cut()) {
    const phymul::TissueSurface tissue = tissue_surface(sim_.model());
    display_ = phymul::make_display(sim_.solver(), phymul::Skin(sim_.model(), tissue), tissue.triangles, gl);
  } else {
    display_ = phymul::make_display(sim_.solver(), *skin_, body_.surface->triangles, gl);
  }
  shown_version_ = sim_.scene().body_version();
}

phymul::Display& ViewSimulation::display() {
  if (!display_ || shown_version_ != sim_.scene().body_version()) show();
  return *display_;
}

void ViewSimulation::change_skin() {
  shows_skin_ = !shows_skin_;
  show();
}

void ViewSimulation::next_backend() {
  const std::vector<std::string> names = phymul::backend_names();
  const auto now = std::find(names.begin(), names.end(), sim_.solver().name());
  auto next = static_cast<std::size_t>(now - names.begin());
  phymul::SolverOptions wish;
  wish.gl.context = phymul::GlContext::current;
  for (std::size_t k = 0; k < names.size(); ++k) {
    next = (next + 1) % names.size();
    const std::string reason = phymul::why_unavailable(names[next], wish);
    if (!reason.empty()) {
      std::fprintf(stderr, "phymul-view: no backend %s: %s\n", names[next].c_str(), reason.c_str());
      continue;
    }
    phymul::Simulation other = make(names[next]);
    other.restore(snapshot());
    display_ = nullptr;  // it looks at the solver that goes
    sim_ = std::move(other);
    show();
    steps_a_frame_ = 1;
    rate_ = 0.0;
    failure_.clear();
    return;
  }
}

void ViewSimulation::step(int n) {
  const phymul::StepReport report = sim_.step(n, sim_.step_limit());
  some_uncut_ = some_uncut_ || report.uncut > 0;
  failure_ = report.ok() ? std::string() : report.message();
}

void ViewSimulation::advance(double wall_time, bool keep_up) {
  const int most = std::max(1, static_cast<int>(frame / sim_.step_limit()));
  if (!keep_up) {
    steps_a_frame_ = most;
  } else if (wall_time > longest_frame) {
    steps_a_frame_ = std::max(1, steps_a_frame_ * 4 / 5);
  } else {
    steps_a_frame_ = std::min(steps_a_frame_ + 1 + steps_a_frame_ / 8, most);
  }
  step(steps_a_frame_);
  if (wall_time > 0.0) rate_ += 0.1 * (steps_a_frame_ / wall_time - rate_);
}

void ViewSimulation::reset() {
  before_cuts_.clear();
  go_back(beginning_);
}

void ViewSimulation::begin_cut() {
  before_cuts_.push_back(snapshot());
}

void ViewSimulation::undo_cut() {
  if (before_cuts_.empty()) return;
  go_back(before_cuts_.back());
  before_cuts_.pop_back();
}

std::string ViewSimulation::status() const {
  const phymul::Solver& solver = sim_.solver();
  char numbers[64];
  std::snprintf(numbers, sizeof numbers, "%.0f steps/s, %.2f x real time, t = %.2f s", rate_, rate_ * sim_.step_limit(),
                sim_.time());
  std::string text = std::string(solver.name()) + " (" + solver.device() + "), " +
                     std::to_string(model().particle_count()) + " particles, " + numbers;
  if (is_cut()) text += ", cut, " + std::to_string(pieces_) + (pieces_ == 1 ? " piece" : " pieces");
  if (some_uncut_) text += ", some cells could not be cut";
  return text;
}
