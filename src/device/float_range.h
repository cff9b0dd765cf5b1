// SPDX-License-Identifier: MIT
//
// What single precision holds of a body and its state, and what it can tell from rest.
#pragma once

#include <phymul/state.h>
#include <phymul/topology_textures.h>

#include <algorithm>

#include "solver/step_order.h"
#include "table_rows.h"

namespace phymul {

/// What a float backend can tell from rest. A displacement u is rounded by up to 2^-24 |u|, which pushes its particle
/// with accelerations of up to a few times omega_max^2 2^-24 |u|: a body's noise at rest was measured at 2 to 3.6 of
/// these units, in speed times omega_max too. Below `rest_noise` of them the rest test would wait for ever.
inline constexpr double rest_noise = 8.0 * 0x1p-24;

/// The thresholds asked for, or the noise where that is more; `largest` is the largest displacement of the body, m, and
/// `omega_max`, rad/s, is that of the body and what is joined to it.
inline RestThresholds rest_thresholds(RestThresholds asked, double largest, double omega_max) {
  const double speed = rest_noise * largest * omega_max;
  return {std::max(asked.speed, speed), std::max(asked.acceleration, speed * omega_max)};
}
/// Of a body alone, by whose omega_max the thresholds were made.
inline RestThresholds rest_thresholds(RestThresholds asked, double largest) {
  return asked.speed > 0.0 ? rest_thresholds(asked, largest, asked.acceleration / asked.speed) : asked;
}

/// A constant of a body in single precision. Throws Error if it is beyond its range.
float narrow(double value);
inline Float4 texel(const Vec3& v, double w) {
  return {narrow(v.x()), narrow(v.y()), narrow(v.z()), narrow(w)};
}

/// Throws Error where a displacement or velocity is beyond single precision. Returns the largest displacement as it is
/// stored, m. `displacement`: [N] m, instead of the state's; empty: there are none.
double require_state_in_range(const VecList& rest, const State& state, const VecList& displacement = {});

/// Throws Error where a base's squared area (2-D: length), m^4 (m^2), would leave what single precision can hold.
void require_base_in_range(double square, Index owner);
void require_bases_in_range(const TopologyTextures& topology);

}  // namespace phymul
