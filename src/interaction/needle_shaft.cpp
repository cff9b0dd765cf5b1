// SPDX-License-Identifier: MIT
#include "needle_shaft.h"

#include <phymul/error.h>

#include <algorithm>
#include <numbers>

#include "base/decimal.h"

namespace phymul {

double tube_bending_stiffness(double outer_radius, double inner_radius, double young) {
  const bool sound = outer_radius > 0.0 && inner_radius >= 0.0 && inner_radius < outer_radius && young > 0.0 &&
                     std::isfinite(outer_radius) && std::isfinite(young);
  if (!sound) {
    throw Error(
        "tube_bending_stiffness: expected an outer radius above an inner one, which is 0 m or more, and a modulus " +
        std::string("above 0 Pa, all finite; got ") + to_decimal(outer_radius) + " m, " + to_decimal(inner_radius) +
        " m and " + to_decimal(young) + " Pa");
  }
  return young * std::numbers::pi / 4.0 * (std::pow(outer_radius, 4) - std::pow(inner_radius, 4));
}

ShaftLine::ShaftLine(const Needle& needle, const ToolPose& pose)
    : tip_(pose.position),
      axis_(pose.orientation * Vec3::UnitZ()),
      turn_(pose.orientation),
      arc_radius_(needle.arc_radius) {
  if (arc_radius_ == 0.0) return;
  round_ = 2.0 * std::numbers::pi * arc_radius_;
  ahead_ = 0.5 * (round_ - needle.length);
}

double ShaftLine::along(const Vec3& x) const {
  if (arc_radius_ == 0.0) return axis_.dot(x - tip_);
  const Vec3 q = turn_.conjugate() * (x - tip_);
  const double along = arc_radius_ * std::atan2(q.z(), arc_radius_ - q.x());
  return along < -ahead_ ? along + round_ : along;
}

Vec3 ShaftLine::place(double along) const {
  if (arc_radius_ == 0.0) return tip_ + along * axis_;
  const double half = std::sin(0.5 * along / arc_radius_);
  return tip_ + turn_ * Vec3(2.0 * arc_radius_ * half * half, 0.0, arc_radius_ * std::sin(along / arc_radius_));
}

Vec3 ShaftLine::axis(double along) const {
  if (arc_radius_ == 0.0) return axis_;
  return turn_ * Vec3(std::sin(along / arc_radius_), 0.0, std::cos(along / arc_radius_));
}

Vec3 ShaftLine::aside(const Vec3& x) const {
  if (arc_radius_ == 0.0) return x - tip_ - along(x) * axis_;
  return x - place(along(x));
}

Vec3 shaft_place(const Needle& needle, double along) {
  return ShaftLine(needle, {}).place(along);
}

double shaft_compliance(const Needle& needle, double at, double from) {
  if (needle.bending_stiffness == 0.0) return 0.0;
  const double a = std::clamp(needle.length - at, 0.0, needle.length);
  const double b = std::clamp(needle.length - from, 0.0, needle.length);
  const double nearer = std::min(a, b), farther = std::max(a, b);
  return nearer * nearer * (3.0 * farther - nearer) / (6.0 * needle.bending_stiffness);
}

bool is_ahead_of_tip(const Needle& needle, double along) {
  return along < -0.1 * needle.radius;
}

Vec3 shaft_deflection(const Needle& needle, std::span<const ShaftLoad> loads, double along) {
  Vec3 u = Vec3::Zero();
  for (const ShaftLoad& load : loads) u += shaft_compliance(needle, along, load.along) * Vec3(load.x, load.y, 0.0);
  return u;
}

VecList shaft_points(const Needle& needle, std::span<const ShaftLoad> loads, int count) {
  if (count < 2) throw Error("shaft_points: expected 2 places or more, got " + std::to_string(count));
  VecList points;
  for (int k = 0; k < count; ++k) {
    const double along = needle.length * k / (count - 1);
    points.push_back(shaft_place(needle, along) + shaft_deflection(needle, loads, along));
  }
  return points;
}

}  // namespace phymul
