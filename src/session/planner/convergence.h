// SPDX-License-Identifier: MIT
//
// The error of a spacing from solutions at several spacings: Richardson's extrapolation of displacements.
#pragma once

#include <phymul/types.h>

#include <span>

namespace phymul {

/// Displacements of the same material points in a body of spacing h, m.
struct FieldAt {
  double h = 0.0;
  std::span<const Vec3> u;
};

/// u(h) = limit + C h^order.
struct Convergence {
  double order = 0.0;
  bool converges = true;  ///< false: the differences do not fall as fast as they do for the least order
  VecList limit;          ///< m
  double scale = 0.0;     ///< m, root mean square of the limit
};

constexpr double least_order = 1.0, most_order = 2.5;

/// Root mean square of the distances between two fields of equal size, m.
double mean_distance(std::span<const Vec3> a, std::span<const Vec3> b);

/// Of three fields with falling h. The order follows from the distances between them and is kept in [least_order,
/// most_order].
Convergence fit_convergence(const FieldAt& coarse, const FieldAt& middle, const FieldAt& fine);

/// Error of a field as a share of the scale: its distance from the limit or, if larger, that from the finest field,
/// extrapolated. The latter only where that field is about twice as fine: between nearer ones, what differs by chance
/// between two meshes would be multiplied.
double estimated_error(const Convergence& fit, const FieldAt& field, const FieldAt& finest);

}  // namespace phymul
