// SPDX-License-Identifier: MIT
#include "view_drag.h"

#include <phymul/surface.h>

namespace {

constexpr double reach_in_pixels = 14.0;
constexpr double way_time = 0.05;  // s for the way to where the mouse is

/// From the eye through a pixel, as wide everywhere as the reach in pixels.
phymul::PickRay ray_under(const phymul::Camera& camera, double x, double y, int width, int height) {
  const auto at = [&](double right, double depth) { return from_pixel(camera, {x + right, y, depth}, width, height); };
  const phymul::Vec3 origin = at(0.0, 0.0), ahead = at(0.0, 1.0);
  const double reach = (at(reach_in_pixels, 0.0) - origin).norm(), farther = (at(reach_in_pixels, 1.0) - ahead).norm();
  return {.origin = origin,
          .direction = ahead - origin,
          .reach = reach,
          .widening = (farther - reach) / (ahead - origin).norm()};
}

}  // namespace

bool ParticleDrag::take(const phymul::Camera& camera, double x, double y, int width, int height) {
  release();
  const phymul::Model& model = sim_.model();
  const phymul::State state = sim_.solver().read();
  const phymul::Index picked = pick_particle(model, state.position, ray_under(camera, x, y, width, height));
  if (picked < 0) return false;
  particle_ = picked;
  const phymul::Vec3& place = state.position[static_cast<std::size_t>(picked)];
  depth_ = to_pixel(camera, place, width, height).z();
  offset_ = place - from_pixel(camera, {x, y, depth_}, width, height);
  const phymul::Vec3 displacement = place - model.rest[static_cast<std::size_t>(*particle_)];
  first_row_ = sim_.scene().loads().size();
  for (int axis = 0; axis < model.dimension; ++axis) {
    sim_.scene().add(along(axis, state.time, displacement[axis], displacement[axis]));
  }
  return true;
}

phymul::Load ParticleDrag::along(int axis, double time, double from, double to) const {
  phymul::Load load;
  load.type = phymul::LoadType::translation;
  load.particles = {*particle_};
  load.events = {{time, from}, {time + way_time, to}};
  load.axes = {phymul::Axis::free, phymul::Axis::free, phymul::Axis::free};
  load.axes[static_cast<std::size_t>(axis)] = phymul::Axis::driven;
  load.direction[axis] = 1.0;
  return load;
}

void ParticleDrag::move(const phymul::Camera& camera, double x, double y, int width, int height) {
  if (!particle_) return;
  phymul::Scene& scene = sim_.scene();
  const double time = sim_.time();
  const phymul::Vec3 wanted = from_pixel(camera, {x, y, depth_}, width, height) + offset_ -
                              scene.model().rest[static_cast<std::size_t>(*particle_)];
  for (int axis = 0; axis < scene.model().dimension; ++axis) {
    const std::size_t row = first_row_ + static_cast<std::size_t>(axis);
    const std::vector<phymul::ValueEvent>& events = scene.loads()[row].events;
    if (events.back().value == wanted[axis]) continue;  // on its way there already
    scene.replace(row, along(axis, time, value_at(events, time), wanted[axis]));
  }
}

void ParticleDrag::release() {
  if (!particle_) return;
  for (int axis = sim_.model().dimension; axis-- > 0;) sim_.scene().remove(first_row_ + static_cast<std::size_t>(axis));
  particle_.reset();
}
