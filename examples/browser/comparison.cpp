// SPDX-License-Identifier: MIT
#include "comparison.h"

#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>

namespace {

constexpr double finer = 1.5;  // so many times

}  // namespace

Comparison::Comparison(std::shared_ptr<const phymul::Surface> surface, double spacing)
    : surface_(std::move(surface)), spacing_(spacing) {}

Comparison::Body Comparison::body(const phymul::Surface& surface, double spacing) {
  phymul::Model model = organ_body(surface, spacing);
  phymul::Skin skin(model, surface.vertices);
  return {phymul::Simulation(std::move(model), {.backend = "cpu", .solver = {.threads = 1}}), std::move(skin)};
}

phymul::VecList Comparison::Body::rest_under(const Pull& pull) {
  phymul::Scene& scene = simulation.scene();
  const phymul::Model& model = simulation.model();
  scene.clear();
  scene.fix(organ_foot(model));
  const std::vector<phymul::Index> patch = organ_patch(model, pull.place, pull.reach);
  scene.add(organ_pull(patch, pull.displacement, pull.displacement, 0.0, 0.0));
  simulation.unrecorded_solver().reset();
  const phymul::StaticResult result = simulation.solve_static({.tolerance = 1e-4});
  if (!result.converged()) throw phymul::Error("no rest shape was found: " + result.message());
  return skin.deform(simulation.state().position);
}

PullError Comparison::error_of(const Pull& pull) {
  if (!coarse_) coarse_.emplace(body(*surface_, spacing_));
  if (!fine_) fine_.emplace(body(*surface_, spacing_ / finer));
  const phymul::VecList coarse = coarse_->rest_under(pull), fine = fine_->rest_under(pull);
  PullError error{.particles = fine_->simulation.model().particle_count(), .spacing = spacing_ / finer};
  double squares = 0.0;
  for (std::size_t i = 0; i < fine.size(); ++i) {
    const double distance = (coarse[i] - fine[i]).norm();
    squares += distance * distance;
    error.largest = std::max(error.largest, distance);
    error.moved = std::max(error.moved, (fine[i] - surface_->vertices[i]).norm());
  }
  error.mean = std::sqrt(squares / static_cast<double>(fine.size()));
  return error;
}
