// SPDX-License-Identifier: MIT
#include "needle_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/cell_geometry.h"
#include "model/point_cells.h"

namespace phymul {
namespace {

/// So that bodies of up to 10.9 mm spacing carry the default spread of an 18 gauge needle.
constexpr double spread_in_radii = 34.0;

/// Pa. On lattices of 1.3 to 6 spacings in the spread s, cells under a tip turn inside out from a push of F on, for
/// which F / s^2 is 0.25 to 0.4 of Young's modulus (nu 0.3), 0.4 (0.4), 0.7 to 0.9 (0.45) or 0.82 to 1.4 (0.49): tissue
/// that is easily compressed is crushed sooner. This is below all of them.
double limit_of(const Material& material) {
  const double gives = 1.0 - 2.0 * material.poisson;
  return material.young / (1.25 + (6.0 + 8.5 * gives) * gives);
}

}  // namespace

double needle_spacing(const Model& model) {
  const double spacing = mean_spacing(model);
  return spacing > 0.0 ? spacing : body_size(model) / std::cbrt(static_cast<double>(model.particle_count()));
}

double needle_spread(const Needle& needle, const Model& model) {
  return needle.spread > 0.0 ? needle.spread : std::max(spread_in_radii * needle.radius, 2.0 * needle_spacing(model));
}

/// A force on a particle is one on its cell already, spread evenly over the spacing h, which has the variance h^2 / 12
/// along each axis. The weights, whose own over a surface is reach^2 / 8, add what is missing; below 1.5 spacings they
/// would find too few particles.
double needle_support_radius(double spread, const Model& model) {
  const double spacing = needle_spacing(model);
  const double left = spread * spread - 8.0 / 12.0 * spacing * spacing;
  return std::max(std::sqrt(std::max(left, 0.0)), std::min(spread, 1.5 * spacing));
}

void needle_bearing(const Model& model, std::span<const double> factors, std::vector<double>& bearing) {
  const auto limit = [&](Index material) {
    return limit_of(model.materials[material]) * (factors.empty() ? 1.0 : factors[material]);
  };
  const std::size_t count = model.rest.size();
  bearing.assign(count, std::numeric_limits<double>::infinity());
  std::vector<int> cells(count, 0);
  const bool in_space = is_made_of_cells(model);  // then a capsule says nothing of the tissue below it
  for (const Cell& cell : model.cells) {
    if (cell.material < 0 || cell.share == 0.0 || (in_space && !is_solid(model.dimension, cell))) continue;
    for (const Index i : cell.particles) bearing[i] = (cells[i]++ == 0 ? 0.0 : bearing[i]) + limit(cell.material);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (cells[i] > 0) bearing[i] /= cells[i];
  }
  // A body of points has one material.
  if (is_body_of_points(model) && !model.materials.empty()) bearing.assign(count, limit(0));
}

double needle_turn(const ToolPose& start, const ToolPose& end) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(end.orientation * start.orientation.conjugate()));
  const Vec3 axis = end.orientation * Vec3::UnitZ();
  const double angle = turn.angle() * turn.axis().dot(axis);
  return std::abs(angle) > 1e-9 ? angle : 0.0;
}

}  // namespace phymul
