// SPDX-License-Identifier: MIT
//
// Monitors: figures of a state. Functions of (model, state); energies are the solver's (solver.h) and elasticity.h's.
#pragma once

#include <phymul/model.h>
#include <phymul/state.h>

#include <cstdint>
#include <span>

namespace phymul {

Vec3 linear_momentum(const Model& model, const State& state);  ///< kg m/s
/// About a point (default: the origin), kg m^2/s.
Vec3 angular_momentum(const Model& model, const State& state, const Vec3& about = Vec3::Zero());
Vec3 centre_of_mass(const Model& model, const State& state);  ///< m

/// 1/2 sum m v^2 with State::velocity as it stands (half a step before State::time), J.
double kinetic_energy(const Model& model, const State& state);

/// Volume of all volume cells, m^3; of quads and triangles (area, m^2) in 2-D.
double volume(const Model& model, std::span<const Vec3> position);

/// The first cell measured by volume() that is turned inside out or squashed to less than a thousandth of its rest
/// measure, as a whole or in one of its corners; row of Model::cells; -1: none. No tissue is in such a state.
Index first_folded_cell(const Model& model, std::span<const Vec3> position);

struct DisplacementNorms {
  double rms = 0.0;  ///< m
  double max = 0.0;  ///< m
  Index max_particle = -1;
};
DisplacementNorms displacement_norms(const Model& model, const State& state);

/// Error of positions against reference positions. A particle whose reference is within 1e-12 body sizes of its rest
/// place does not move. Percentiles by nearest rank. Throws Error when the sizes do not agree. `skip` [N] or empty: not
/// 0 = leave the particle out (prescribed ones).
struct PositionError {
  double global_ratio = 0.0;  ///< sqrt(sum |u - u_ref|^2 / sum |u_ref|^2), u the displacement from rest
  double max = 0.0;           ///< largest |x - x_ref|, m
  double p95 = 0.0;           ///< 95th percentile of |x - x_ref|, m
  double median_ren =
      0.0;  ///< median over particles of REN = |x - x_ref| / |x_ref - X|; particles that do not move left out
  double max_ren = 0.0;
  Index max_particle = -1;
};
PositionError position_error(const Model& model, std::span<const Vec3> position, std::span<const Vec3> reference,
                             std::span<const std::uint8_t> skip = {});

/// REN of each particle; NaN where the reference does not move. Relative error of the displacement, per particle.
std::vector<double> relative_errors(const Model& model, std::span<const Vec3> position,
                                    std::span<const Vec3> reference);

}  // namespace phymul
