// SPDX-License-Identifier: MIT
#include "float_range.h"

#include <phymul/error.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "base/decimal.h"

namespace phymul {
namespace {

/// |w0|^2 of a base must be a normal float with room for what multiplies it: edges of a nanometre to a thousand
/// kilometres or so.
constexpr double least_square = 1e-32, greatest_square = 1e26;

}  // namespace

float narrow(double value) {
  const auto result = static_cast<float>(value);
  if (std::isfinite(result)) return result;
  throw Error(ErrorCode::not_supported,
              "a constant of the body, " + to_decimal(value) +
                  " in SI units, is beyond the range of single precision; expected masses in kg, lengths in m and "
                  "stiffnesses in N/m of a real body. The backend \"reference\" computes in double precision");
}

void require_base_in_range(double square, Index owner) {
  if (square >= least_square && square <= greatest_square) return;
  throw Error(ErrorCode::not_supported,
              "a base of particle " + std::to_string(owner) + " spans " + to_decimal(std::sqrt(square)) +
                  " in m^2 (m in 2-D); single precision holds " + to_decimal(std::sqrt(least_square)) + " to " +
                  to_decimal(std::sqrt(greatest_square)) +
                  ". Expected a model in metres; the backend \"reference\" computes in double precision");
}

void require_bases_in_range(const TopologyTextures& topology) {
  for (Index i = 0; i < topology.particle_count; ++i) {
    const IndexTexel& at = topology.index[i];
    for (Index t = at.first_base; t < at.first_base + at.base_count; ++t) {
      const auto& v = topology.bases[t].vertex;
      const Vec3 E1 = topology.rest[v[1]] - topology.rest[v[0]];
      require_base_in_range(topology.dimension == 2
                                ? E1.squaredNorm()
                                : E1.cross(Vec3(topology.rest[v[2]] - topology.rest[v[0]])).squaredNorm(),
                            i);
    }
  }
}

double require_state_in_range(const VecList& rest, const State& state, const VecList& displacement) {
  double largest = 0.0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const Vec3 moved = displacement.empty() ? Vec3(state.position[i] - rest[i]) : displacement[i];
    const Eigen::Vector3f u = moved.cast<float>(), v = state.velocity[i].cast<float>();
    largest = std::max(largest, u.cast<double>().norm());
    if (u.allFinite() && v.allFinite()) continue;
    throw Error(ErrorCode::not_supported,
                "Solver::reset: particle " + std::to_string(i) +
                    " has a displacement or velocity beyond single precision; the backend \"reference\" computes in "
                    "double precision");
  }
  return largest;
}

}  // namespace phymul
