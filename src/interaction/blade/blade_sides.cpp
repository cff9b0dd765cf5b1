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
constexpr double most_side_points = 300.0;  // along each side, so that sides of any size have room

}  // namespace

void BladeEdge::lay_out_sides() {
  const auto points = [&](double length) {
    return static_cast<int>(std::clamp(std::ceil(side_points_in_spacing * length / spacing_), 1.0, most_side_points));
  };
  const int columns = points(curve_.length()), rows = points(blade_.height);
  side_rows_ = static_cast<std::size_t>(rows);
  for (int column = 0; column < columns; ++column) {
    const double along = curve_.length() * ((column + 0.5) / columns - 0.5);
    for (int row = 0; row < rows; ++row) {
      const Vec3 behind(0.0, 0.0, blade_.height * (row + 0.5) / rows);
      sides_.push_back({.place = curve_.at(along) + behind, .normal = curve_.normal(along)});
    }
  }
}

/// At the first step of a call: where points come into tissue. They do so from the edge on, or beside others.
void BladeEdge::find_sides(const TouchedParticles& touched, const ToolFrame& end) {
  const auto enter = [&](Side& side, Index from) {
    if (side.next.site >= 0 || from < 0 || sites_[from].thickness > 0.0) return;
    side.next.site = walk(touched, from, end.outside(side.place), Vec3::Zero(), side.next.at);
  };
  const std::size_t rows = side_rows_, count = sides_.size();
  for (const Point& point : next_) {
    const double column = (point.place + 0.5) / count_ * static_cast<double>(count / rows);
    enter(sides_[static_cast<std::size_t>(column) * rows], point.site);
  }
  if (blade_.toughness == 0.0 && std::ranges::all_of(sides_, [](const Side& side) { return side.next.site < 0; })) {
    look_for_sides(touched, end);
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (k % rows > 0) enter(sides_[k], sides_[k - 1].next.site);
    if (k >= rows) enter(sides_[k], sides_[k - rows].next.site);
  }
  for (std::size_t k = count; k-- > 0;) {
    if (k % rows + 1 < rows) enter(sides_[k], sides_[k + 1].next.site);
    if (k + rows < count) enter(sides_[k], sides_[k + rows].next.site);
  }
}

void BladeEdge::look_for_sides(const TouchedParticles& touched, const ToolFrame& end) {
  Vec3 low = Vec3::Constant(HUGE_VAL), high = -low;
  for (const Side& side : sides_) {
    low = low.cwiseMin(end.outside(side.place));
    high = high.cwiseMax(end.outside(side.place));
  }
  look_around(touched, low, high, spacing_);
  for (Side& side : sides_) {
    const Vec3 x = end.outside(side.place);
    for (const Near& near : near_) {
      if ((x.array() < near.low.array()).any() || (x.array() > near.high.array()).any()) continue;
      const Site& site = sites_[near.site];
      if (site.thickness == 0.0 && weights_in(site, near.corners, x, Vec3::Zero()).minCoeff() >= in_site)
        side.next.site = near.site;
      if (side.next.site >= 0) break;
    }
  }
}

void BladeEdge::add_sides(std::vector<BladePoint>& state) const {
  for (std::size_t k = 0; k < sides_.size(); ++k) {
    const auto& [site, at] = sides_[k].now;
    if (site < 0) continue;
    const double behind = blade_.height * (static_cast<double>(k % side_rows_) + 0.5) / static_cast<double>(side_rows_);
    state.push_back({.place = count_ + static_cast<Index>(k),
                     .cell = sites_[site].row,
                     .weights = {at[0], at[1], at[2], at[3]},
                     .along = curve_.unrolled(sides_[k].place).x(),
                     .ahead = -behind});
  }
}

void BladeEdge::rub(TouchedParticles& touched, const ToolFrame& start, const ToolFrame& end, ToolForce& force) {
  const double dt = touched.dt();
  for (Side& side : sides_) side.next = side.now;
  if (looks_) find_sides(touched, end);
  for (Side& side : sides_) {
    auto& [site, at] = side.next;
    if (site >= 0) site = walk(touched, site, end.outside(side.place), Vec3::Zero(), at);
    side.impulse.setZero();
    if (site >= 0 && !take_corners(touched, sites_[site], at, side.acting)) site = -1;
    if (site < 0) continue;
    side.acting.inverse_mass = 0.0;
    for (const auto& [slot, weight] : side.acting.corners) {
      if (!touched[slot].held) side.acting.inverse_mass += weight * weight * touched[slot].inverse_mass;
    }
  }
  const double limit = blade_.friction * curve_.length() * blade_.height / static_cast<double>(sides_.size()) * dt;
  for (int sweep = 0; sweep < side_sweeps; ++sweep) {
    for (Side& side : sides_) {
      if (side.next.site < 0 || !(side.acting.inverse_mass > 0.0)) continue;
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
  for (const Side& side : sides_) {
    if (side.impulse == Vec3::Zero()) continue;
    for (const auto& [slot, weight] : side.acting.corners) {
      if (!touched[slot].held) pushed_.push_back(touched[slot].particle);
    }
  }
}

}  // namespace phymul
