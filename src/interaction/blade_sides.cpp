// SPDX-License-Identifier: MIT
//
// The sides of a blade: points on them resist the motion of the tissue that they are in, up to a force per area, in the
// surface that the edge has cut. What is at a point is the mean of what cuts have left of its cell.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "blade_edge.h"

namespace phymul {
namespace {

constexpr int side_sweeps = 4;
constexpr double side_points_in_spacing = 2.0;

}  // namespace

void BladeEdge::lay_out_sides() {
  const auto points = [&](double length) {
    return std::max(1, static_cast<int>(std::ceil(side_points_in_spacing * length / spacing_)));
  };
  const int columns = points(curve_.length()), rows = points(blade_.height);
  for (int column = 0; column < columns; ++column) {
    const double along = curve_.length() * ((column + 0.5) / columns - 0.5);
    for (int row = 0; row < rows; ++row) {
      const Vec3 behind(0.0, 0.0, blade_.height * (row + 0.5) / rows);
      sides_.push_back({.place = curve_.at(along) + behind, .normal = curve_.normal(along)});
    }
  }
}

/// At the first step of a call: where the points are in the tissue. It depends on the state alone.
void BladeEdge::find_sides(const TouchedParticles& touched, const ToolFrame& end) {
  Vec3 low = Vec3::Constant(HUGE_VAL), high = -low;
  for (const Side& side : sides_) {
    low = low.cwiseMin(end.outside(side.place));
    high = high.cwiseMax(end.outside(side.place));
  }
  look_around(touched, low, high);
  for (Side& side : sides_) {
    const Vec3 x = end.outside(side.place);
    side.site = -1;
    for (const Near& near : near_) {
      if ((x.array() < near.low.array()).any() || (x.array() > near.high.array()).any()) continue;
      const Weights weights = weights_in(near.corners, x);
      if (!(weights.minCoeff() >= in_site)) continue;
      side.site = near.site;
      break;
    }
  }
}

void BladeEdge::rub(TouchedParticles& touched, const ToolFrame& start, const ToolFrame& end, ToolForce& force) {
  const double dt = touched.dt();
  if (looks_) find_sides(touched, end);
  for (Side& side : sides_) {
    if (side.site >= 0) side.site = walk(touched, side.site, end.outside(side.place), side.at);
    side.impulse.setZero();
    if (side.site >= 0 && !take_corners(touched, sites_[side.site], side.at, side.acting)) side.site = -1;
    if (side.site < 0) continue;
    side.acting.inverse_mass = 0.0;
    for (const auto& [slot, weight] : side.acting.corners) {
      if (!touched[slot].held) side.acting.inverse_mass += weight * weight * touched[slot].inverse_mass;
    }
  }
  const double limit = blade_.friction * curve_.length() * blade_.height / static_cast<double>(sides_.size()) * dt;
  for (int sweep = 0; sweep < side_sweeps; ++sweep) {
    for (Side& side : sides_) {
      if (side.site < 0 || !(side.acting.inverse_mass > 0.0)) continue;
      Vec3 slip = (end.outside(side.place) - start.outside(side.place)) / dt;
      for (const auto& [slot, weight] : side.acting.corners) slip -= weight * touched[slot].velocity;
      const Vec3 normal = end.turn * side.normal;
      Vec3 to = side.impulse + (slip - normal.dot(slip) * normal) / side.acting.inverse_mass;
      if (const double size = to.norm(); size > limit) to *= limit / size;
      for (const auto& [slot, weight] : side.acting.corners) {
        TouchedParticles::Touched& particle = touched[slot];
        if (particle.held) continue;
        const Vec3 given = TouchedParticles::push(particle, weight * (to - side.impulse));
        force.force -= given / dt;
        force.torque -= (particle.position - end.position).cross(given) / dt;
      }
      side.impulse = to;
    }
  }
}

}  // namespace phymul
