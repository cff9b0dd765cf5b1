// SPDX-License-Identifier: MIT
//
// Monitors: functions of a model and a state. All throw Error if the sizes differ. Energies: solver.h and elasticity.h.
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

/// 1/2 sum m v^2, J, with State::velocity unchanged (that of half a step before State::time).
double kinetic_energy(const Model& model, const State& state);

/// Volume of all volume cells, m^3; of quads and triangles (area, m^2) in 2-D. Cells of negative volume count negative.
double volume(const Model& model, std::span<const Vec3> position);

/// The first cell measured by volume() that is turned inside out or squashed to less than a thousandth of its rest
/// measure, as a whole or (3-D) in a corner. Row of Model::cells; -1: none. No tissue is in such a state.
Index first_folded_cell(const Model& model, std::span<const Vec3> position);

struct DisplacementNorms {
  double rms = 0.0;  ///< m
  double max = 0.0;  ///< m
  Index max_particle = -1;
};
/// Over all particles but spare ones (with_spare_particles).
DisplacementNorms displacement_norms(const Model& model, const State& state);

/// Error of positions against reference positions. A particle does not move if its reference is within 1e-12 body sizes
/// of its rest place. Percentiles by nearest rank. A position that is NaN has an infinite error. `skip` [N] or empty:
/// not 0 = leave the particle out (prescribed ones). Particles without mass are left out.
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

/// REN of each particle (relative error of its displacement). NaN where the reference does not move.
std::vector<double> relative_errors(const Model& model, std::span<const Vec3> position,
                                    std::span<const Vec3> reference);

}  // namespace phymul
