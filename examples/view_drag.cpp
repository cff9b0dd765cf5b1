// SPDX-License-Identifier: MIT
#include "view_drag.h"

#include <cmath>

namespace {

constexpr double reach = 14.0;     // pixels
constexpr double way_time = 0.05;  // s for the way to where the mouse is

}  // namespace

bool ParticleDrag::take(const phymul::Solver& solver, const phymul::Camera& camera, double x, double y, int width,
                        int height) {
  release();
  const phymul::State state = solver.read();
  for (std::size_t i = 0; i < state.position.size(); ++i) {
    const phymul::Vec3 seen = to_pixel(camera, state.position[i], width, height);
    if (std::hypot(seen.x() - x, seen.y() - y) > reach || (particle_ && seen.z() >= depth_)) continue;
    particle_ = static_cast<phymul::Index>(i);
    depth_ = seen.z();
  }
  if (!particle_) return false;
  const phymul::Vec3& place = state.position[static_cast<std::size_t>(*particle_)];
  offset_ = place - from_pixel(camera, {x, y, depth_}, width, height);
  const phymul::Vec3 displacement = place - solver.model().rest[static_cast<std::size_t>(*particle_)];
  first_row_ = scene_.loads().size();
  for (int axis = 0; axis < solver.model().dimension; ++axis) {
    scene_.add(along(axis, state.time, displacement[axis], displacement[axis]));
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

void ParticleDrag::move(const phymul::Camera& camera, double x, double y, int width, int height, double time) {
  if (!particle_) return;
  const phymul::Vec3 wanted = from_pixel(camera, {x, y, depth_}, width, height) + offset_ -
                              scene_.model().rest[static_cast<std::size_t>(*particle_)];
  for (int axis = 0; axis < scene_.model().dimension; ++axis) {
    const std::size_t row = first_row_ + static_cast<std::size_t>(axis);
    const std::vector<phymul::ValueEvent>& events = scene_.loads()[row].events;
    if (events.back().value == wanted[axis]) continue;  // on its way there already
    scene_.replace(row, along(axis, time, value_at(events, time), wanted[axis]));
  }
}

void ParticleDrag::release() {
  if (!particle_) return;
  for (int axis = scene_.model().dimension; axis-- > 0;) scene_.remove(first_row_ + static_cast<std::size_t>(axis));
  particle_.reset();
}
