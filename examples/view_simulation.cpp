// SPDX-License-Identifier: MIT
#include "view_simulation.h"

#include "surface_body.h"

#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cstdio>

namespace {

constexpr double longest_frame = 1.0 / 40.0;  // s; a slower one takes fewer steps
constexpr double frame = 1.0 / 60.0;          // s

}  // namespace

Simulation::Simulation(const ViewBody& body, const ViewOptions& options)
    : body_(body),
      model_(body.model),
      options_(options),
      scene_(model_),
      topology_(std::make_shared<const phymul::TopologyTextures>(build_topology(model_))) {
  if (body.surface) skin_.emplace(model_, body.surface->vertices);
  if (!options.loads.empty()) scene_.add(phymul::read_lml(options.loads, model_));
  for (const std::string& done : phymul::add_body_types(scene_)) std::fprintf(stderr, "note: %s\n", done.c_str());
  for (const std::string& group : options.fixed_groups) scene_.fix(group);
  for (std::size_t k = 0; k < options.fixed_balls.size(); k += 4) {
    scene_.fix(particles_in_ball(model_, &options.fixed_balls[k]));
  }
  hold_in_balls(scene_, body.surface ? &*body.surface : nullptr, options.spacing, options.held_balls);
  spectrum_ = estimate_spectrum(*topology_, topology_->rest);
  use(options.backend);
}

void Simulation::use(const std::string& backend) {
  std::optional<phymul::State> state;
  if (solver_) state = solver_->read();
  phymul::SolverOptions solver_options;
  solver_options.damping.rate = options_.damping_rate;
  solver_options.spectrum = spectrum_;
  solver_options.gl.context = phymul::GlContext::current;
  auto solver = phymul::make_solver(backend, topology_, scene_, solver_options);
  if (state) solver->reset(*state);
  display_ = nullptr;  // it looks at the solver that goes
  solver_ = std::move(solver);
  show();
  dt_ = options_.step_share * std::min(solver_->stable_step(), 1.0);
  steps_a_frame_ = 1;
  rate_ = 0.0;
}

void Simulation::show() {
  const phymul::GlOptions gl{.context = phymul::GlContext::current};
  display_ = shows_skin() ? phymul::make_display(*solver_, *skin_, body_.surface->triangles, gl)
                          : phymul::make_display(*solver_, gl);
}

void Simulation::change_skin() {
  shows_skin_ = !shows_skin_;
  show();
}

void Simulation::next_backend() {
  const std::vector<std::string> names = phymul::backend_names();
  const auto now = std::find(names.begin(), names.end(), solver_->name());
  auto next = static_cast<std::size_t>(now - names.begin());
  phymul::SolverOptions wish;
  wish.gl.context = phymul::GlContext::current;
  for (std::size_t k = 0; k < names.size(); ++k) {
    next = (next + 1) % names.size();
    const std::string reason = phymul::why_unavailable(names[next], wish);
    if (reason.empty()) return use(names[next]);
    std::fprintf(stderr, "phymul-view: no backend %s: %s\n", names[next].c_str(), reason.c_str());
  }
}

void Simulation::step(int n) {
  const phymul::StepReport report = solver_->step(n, dt_);
  time_ = report.time;
  failure_ = report.ok() ? std::string() : report.message();
}

void Simulation::advance(double wall_time, bool keep_up) {
  if (!keep_up) {
    steps_a_frame_ = std::max(1, static_cast<int>(frame / dt_));
  } else if (wall_time > longest_frame) {
    steps_a_frame_ = std::max(1, steps_a_frame_ * 4 / 5);
  } else {
    steps_a_frame_ = std::min(steps_a_frame_ + 1 + steps_a_frame_ / 8, std::max(1, static_cast<int>(frame / dt_)));
  }
  step(steps_a_frame_);
  if (wall_time > 0.0) rate_ += 0.1 * (steps_a_frame_ / wall_time - rate_);
}

void Simulation::reset() {
  solver_->reset();
  time_ = 0.0;
  failure_.clear();
}

std::string Simulation::status() const {
  char text[64];
  std::snprintf(text, sizeof text, "%.0f steps/s, %.2f x real time, t = %.2f s", rate_, rate_ * dt_, time_);
  return std::string(solver_->name()) + " (" + solver_->device() + "), " + std::to_string(model_.particle_count()) +
         " particles, " + text;
}
