// SPDX-License-Identifier: MIT
#include "surface_press.h"

#include <algorithm>
#include <cmath>

namespace phymul::cpu {
namespace {

/// Of a triangle, in its longest edge at rest. No point of a triangle is farther from the nearest corner than its
/// longest edge over the root of 3, so that triangles stretched to 2.6 times their longest edge are still found;
/// about 1.5 times where a tool passes through them in one step.
constexpr double reach_in_edges = 1.5;

Vec3 mean(const ContactPoints::Shares& share, const Vec3& a, const Vec3& b, const Vec3& c) {
  return share[0] * a + share[1] * b + share[2] * c;
}

}  // namespace

SurfacePress::SurfacePress(const Model& model, const Tool& tool)
    : points_(make_contact_points(model, tool)),
      reach_of_(model.rest.size(), 0.0),
      corner_of_(model.rest.size(), -1),
      is_near_(points_.patches.size(), 0) {
  corners_.reserve(model.rest.size());
  near_.reserve(points_.patches.size());
  pressed_.reserve(points_.most_points);
  for (const ContactPoints::Patch& patch : points_.patches) {
    for (int c = 0; c < 3; ++c) {
      const Vec3 edge = model.rest[patch.corner[(c + 1) % 3]] - model.rest[patch.corner[c]];
      for (const Index row : patch.corner) reach_of_[row] = std::max(reach_of_[row], reach_in_edges * edge.norm());
    }
  }
  reach_ = std::ranges::max(reach_of_);
}

std::size_t SurfacePress::corner(Index row, const ToolFrame& start, const ToolFrame& end, TouchedParticles& touched) {
  if (corner_of_[row] < 0) {
    corner_of_[row] = static_cast<Index>(corners_.size());
    Corner& made = corners_.emplace_back();
    made.slot = touched.slot(row);
    const TouchedParticles::Touched& particle = touched[made.slot];
    made.from = start.inside(particle.position);
    made.to = end.inside(particle.end(touched.dt()) + particle.shift);
    made.inverse_mass = particle.held || particle.fixed == 7 ? 0.0 : particle.inverse_mass;
  }
  return static_cast<std::size_t>(corner_of_[row]);
}

void SurfacePress::gather(const ShapeIn<double>& shape, const ToolFrame& start, const ToolFrame& end,
                          const std::vector<Index>& near, TouchedParticles& touched) {
  near_.clear();
  corners_.clear();
  pressed_.clear();
  for (const Index row : near) {
    if (points_.patch_first[row] == points_.patch_first[row + 1]) continue;
    const Vec3 from = start.inside(touched.step().position(row)), to = end.inside(touched.end(row));
    if (distance_to(shape, unpacked(to)).phi > reach_of_[row] + (to - from).norm()) continue;
    for (std::size_t k = points_.patch_first[row]; k < points_.patch_first[row + 1]; ++k) {
      const Index patch = points_.patch_of[k];
      if (is_near_[patch] == 0) near_.push_back({patch, {}});
      is_near_[patch] = 1;
    }
  }
  // Not in the backend's order, so that all backends add up alike.
  std::ranges::sort(near_, {}, &Near::patch);
  for (Near& own : near_) {
    is_near_[own.patch] = 0;
    const auto& row = points_.patches[own.patch].corner;
    for (int c = 0; c < 3; ++c) own.corner[c] = corner(row[c], start, end, touched);
  }
}

/// Whether a point of the triangle may be in the tool at the step's end, or have gone through it.
bool SurfacePress::may_touch(const ShapeIn<double>& shape, const Near& near) const {
  const Corner &a = corners_[near.corner[0]], &b = corners_[near.corner[1]], &c = corners_[near.corner[2]];
  const Vec3 middle = (a.to + b.to + c.to) / 3.0;
  double far = 0.0, way = 0.0;  // squared
  for (const Corner* own : {&a, &b, &c}) {
    far = std::max(far, (own->to - middle).squaredNorm());
    way = std::max(way, (own->to - own->from).squaredNorm());
  }
  return distance_to(shape, unpacked(middle)).phi <= std::sqrt(far) + std::sqrt(way);
}

SurfacePress::Way SurfacePress::way_of(Index row, std::int32_t point) const {
  const Near& near = near_[row];
  const ContactPoints::Shares& share = (*points_.patches[near.patch].points)[point];
  const Corner &a = corners_[near.corner[0]], &b = corners_[near.corner[1]], &c = corners_[near.corner[2]];
  return {unpacked(mean(share, a.from, b.from, c.from)), unpacked(mean(share, a.to, b.to, c.to))};
}

/// Finds the points that are in the tool at the step's end, their load on each particle, and what that makes of them.
void SurfacePress::find_pressed(const ShapeIn<double>& shape) {
  for (Index k = 0; k < static_cast<Index>(near_.size()); ++k) {
    if (!may_touch(shape, near_[k])) continue;
    const ContactPoints::Patch& patch = points_.patches[near_[k].patch];
    for (std::int32_t p = 0; p < static_cast<std::int32_t>(patch.points->size()); ++p) {
      const Way way = way_of(k, p);
      const double depth = depth_after(shape, way.from, way.to, way.to - way.from).depth;
      if (!(depth > 0.0)) continue;
      const double load = patch.area * depth;
      pressed_.push_back({k, p, load});
      for (int c = 0; c < 3; ++c) corners_[near_[k].corner[c]].load += (*patch.points)[p][c] * load;
    }
  }
  for (Pressed& point : pressed_) {
    const Near& near = near_[point.near];
    const ContactPoints::Shares& share = (*points_.patches[near.patch].points)[point.point];
    for (int c = 0; c < 3; ++c) {
      const Corner& corner = corners_[near.corner[c]];
      point.inverse_mass += share[c] * corner.load / point.load * corner.inverse_mass;
      point.crowd += share[c] * corner.load / point.load;
    }
  }
}

/// Particles take nothing before hand_over().
void SurfacePress::press(const ShapeIn<double>& shape, const ContactLaw<double>& law, const Pressed& point, double dt) {
  const Near& near = near_[point.near];
  const ContactPoints::Shares& share = (*points_.patches[near.patch].points)[point.point];
  const std::array<Corner*, 3> corner{&corners_[near.corner[0]], &corners_[near.corner[1]], &corners_[near.corner[2]]};
  if (!(point.inverse_mass > 0.0)) return;
  ContactLaw<double> own_law = law;
  own_law.compliance *= point.crowd;  // so that a patch that moves as one is as compliant as its particles
  const Way way = way_of(point.near, point.point);
  const Touch<double> touch =
      touch_in_step(shape, own_law, way.from, way.to, way.to - way.from, point.inverse_mass, dt);
  if (!touch.touches) return;
  for (int c = 0; c < 3; ++c) {
    corner[c]->impulse += share[c] * packed(touch.impulse);
    corner[c]->shift += share[c] / point.inverse_mass * packed(touch.shift);
  }
}

/// What a round gave to particles that can take it.
void SurfacePress::hand_over(const ToolFrame& end, TouchedParticles& touched) {
  for (Corner& corner : corners_) {
    if (corner.impulse == Vec3::Zero() && corner.shift == Vec3::Zero()) continue;
    if (corner.inverse_mass > 0.0) {
      TouchedParticles::Touched& particle = touched[corner.slot];
      const Vec3 given = TouchedParticles::push(particle, end.turn * corner.impulse);
      const Vec3 by = particle.free_part(end.turn * (corner.inverse_mass * corner.shift));
      particle.shift += by;
      corner.given += given;
      corner.to += end.turn.transpose() * (touched.dt() * corner.inverse_mass * given + by);
    }
    corner.impulse = corner.shift = Vec3::Zero();
  }
}

void SurfacePress::act(const ShapeIn<double>& shape, const ContactLaw<double>& law, const ToolFrame& start,
                       const ToolFrame& end, const std::vector<Index>& near, TouchedParticles& touched,
                       ToolForce& force) {
  const double dt = touched.dt();
  gather(shape, start, end, near, touched);
  find_pressed(shape);
  const int rounds = pressed_.empty() ? 0 : rounds_of_surface(law.placed);
  for (int round = 0; round < rounds; ++round) {
    for (const Pressed& point : pressed_) press(shape, law, point, dt);
    hand_over(end, touched);
  }
  for (const Corner& corner : corners_) {
    TouchedParticles::Touched& particle = touched[corner.slot];
    corner_of_[particle.particle] = -1;
    if (corner.given == Vec3::Zero()) continue;
    react(force, end, particle.position, corner.given + dt * TouchedParticles::borne(particle, corner.given), dt);
  }
}

}  // namespace phymul::cpu
