// SPDX-License-Identifier: MIT
//
// Displacements and velocities of particles where the vector kernels keep them: u [places + 1][4] by quad, m, and
// v [slices][3][lanes], m/s.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "packed_body.h"

namespace phymul::cpu {

/// [particles] the place of each in PackedBody::order.
inline std::vector<std::size_t> places_of(const PackedBody& body) {
  std::vector<std::size_t> place_of(body.order.size());
  for (std::size_t place = 0; place < place_of.size(); ++place) place_of[body.order[place]] = place;
  return place_of;
}

inline std::size_t velocity_at(const PackedBody& body, std::size_t place, int axis) {
  const auto lanes = static_cast<std::size_t>(body.lanes);
  return (3 * (place / lanes) + static_cast<std::size_t>(axis)) * lanes + place % lanes;
}

inline Vec3 displacement(const PackedBody& body, const Floats& u, std::size_t place) {
  const float* at = &u[4 * body.quad_of(place)];
  return {at[0], at[1], at[2]};
}

inline Vec3 velocity(const PackedBody& body, const Floats& v, std::size_t place) {
  return {v[velocity_at(body, place, 0)], v[velocity_at(body, place, 1)], v[velocity_at(body, place, 2)]};
}

/// The kernel knows that there is one; it is sought here, in the model's order.
inline Index first_runaway(const PackedBody& body, const Floats& u, const Floats& v, double speed) {
  Index first = std::numeric_limits<Index>::max();
  const double greatest = std::min(speed, std::sqrt(static_cast<double>(std::numeric_limits<float>::max())));
  for (std::size_t place = 0; place < body.order.size(); ++place) {
    const Vec3 at = displacement(body, u, place);
    const bool reached = at.allFinite() && at.squaredNorm() <= std::numeric_limits<float>::max();
    // A little less than the bound: the kernel rounds its squares.
    if (!reached || !(velocity(body, v, place).norm() <= greatest * (1.0 - 1e-6))) {
      first = std::min(first, body.order[place]);
    }
  }
  return first;
}

}  // namespace phymul::cpu
