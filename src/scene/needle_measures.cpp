// SPDX-License-Identifier: MIT
#include "needle_measures.h"

#include <algorithm>
#include <cmath>

namespace phymul {

double needle_spacing(const Model& model) {
  const double spacing = mean_spacing(model);
  return spacing > 0.0 ? spacing : body_size(model) / std::cbrt(static_cast<double>(model.particle_count()));
}

double needle_spread(const Needle& needle, const Model& model) {
  return needle.spread > 0.0 ? needle.spread : 2.0 * needle_spacing(model);
}

/// A force on a particle is one on its cell already, spread evenly over the spacing h, which has the variance h^2 / 12
/// along each axis. The weights, whose own over a surface is reach^2 / 8, add what is missing; below 1.5 spacings they
/// would find too few particles.
double needle_support_radius(double spread, const Model& model) {
  const double spacing = needle_spacing(model);
  const double left = spread * spread - 8.0 / 12.0 * spacing * spacing;
  return std::max(std::sqrt(std::max(left, 0.0)), std::min(spread, 1.5 * spacing));
}

double needle_turn(const ToolPose& start, const ToolPose& end) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(end.orientation * start.orientation.conjugate()));
  const Vec3 axis = end.orientation * Vec3::UnitZ();
  const double angle = turn.angle() * turn.axis().dot(axis);
  return std::abs(angle) > 1e-9 ? angle : 0.0;
}

}  // namespace phymul
