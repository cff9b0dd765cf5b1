// SPDX-License-Identifier: MIT
//
// The energies of Law::particle_averaged, a row each, and their constants. What else belongs to one: its formula in
// double precision (elastic/energy_density.h), and its text for all other backends, glsl/kernels/energy_<name>.glsl,
// which cpu/simd/kernel_text.h and tests/mirror/kernels.h include.
#pragma once

#include <phymul/topology_textures.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace phymul {

struct EnergyKind {
  StrainEnergy energy;
  const char* name;
  std::int32_t number;    ///< in files; never changes; 0 to 2 were energies that are gone
  std::size_t constants;  ///< of EnergyConstants that it has
  std::size_t moduli;     ///< the first of them, Pa, to which the energy is proportional
};

/// In the order of the enumerators.
inline constexpr std::array energy_kinds{EnergyKind{StrainEnergy::neo_hookean, "neo_hookean", 3, 2, 2},
                                         EnergyKind{StrainEnergy::fibres, "fibres", 4, 6, 3},
                                         EnergyKind{StrainEnergy::stiffening, "stiffening", 5, 6, 2}};

/// Below it rough motions would cost next to nothing. A part without a particle inside, as a single layer of cells, has
/// few of them, and calibration finds 0.1 to 0.25 there: with 0.25 plates of tetrahedra are an eighth too stiff.
inline constexpr double least_stabiliser = 0.25, least_stabiliser_of_layers = 0.1;

constexpr const EnergyKind& kind_of(StrainEnergy energy) {
  return energy_kinds[static_cast<std::size_t>(energy)];
}

/// Along the fibres of a cell, which may have any length.
inline Vec3 unit_fibre(const Cell& cell) {
  const bool squares = std::isnormal(cell.fibre.squaredNorm());
  return squares ? cell.fibre.normalized() : cell.fibre.stableNormalized();
}

/// `fibre`: the unit vector along the domain's fibres, or zero.
inline EnergyConstants energy_constants(StrainEnergy energy, const Material& material, const Vec3& fibre) {
  const double mu = material.young / (2.0 * (1.0 + material.poisson));
  const double bulk = material.young / (3.0 * (1.0 - 2.0 * material.poisson));
  if (energy == StrainEnergy::neo_hookean) return {mu, bulk};
  if (energy == StrainEnergy::stiffening) {
    const Stiffening& of = material.stiffening;
    return {mu, bulk, of.exponential, of.exponent, of.second, of.second_fades};
  }
  return {mu, bulk, (material.fibre_ratio - 1.0) * material.young, fibre.x(), fibre.y(), fibre.z()};
}

}  // namespace phymul
