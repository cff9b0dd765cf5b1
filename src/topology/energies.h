// SPDX-License-Identifier: MIT
//
// The energies of Law::particle_averaged, a row each, and their constants. What else belongs to one: its formula in
// double precision (elastic/energy_density.h), and its text for all other backends, glsl/kernels/energy_<name>.glsl,
// which cpu/simd/kernel_text.h and tests/mirror/kernels.h include.
#pragma once

#include <phymul/topology_textures.h>

#include <array>
#include <cstdint>

namespace phymul {

struct EnergyKind {
  StrainEnergy energy;
  const char* name;
  std::int32_t number;      ///< in files; never changes
  std::size_t constants;    ///< of EnergyConstants that it has
  std::size_t moduli;       ///< the first of them, Pa, to which the energy is proportional
  double least_stabiliser;  ///< below it rough motions would cost next to nothing
};

/// In the order of the enumerators.
inline constexpr std::array energy_kinds{EnergyKind{StrainEnergy::shape_memory, "shape_memory", 0, 2, 2, 0.1},
                                         EnergyKind{StrainEnergy::neo_hookean, "neo_hookean", 1, 2, 2, 0.25},
                                         EnergyKind{StrainEnergy::fibres, "fibres", 2, 6, 3, 0.1}};

constexpr const EnergyKind& kind_of(StrainEnergy energy) {
  return energy_kinds[static_cast<std::size_t>(energy)];
}

/// `fibre`: the unit vector along the domain's fibres, or zero.
inline EnergyConstants energy_constants(StrainEnergy energy, const Material& material, const Vec3& fibre) {
  const Calibration of_directions = calibrate(material);
  switch (energy) {
    case StrainEnergy::shape_memory:
      return {of_directions.c, of_directions.kappa};
    case StrainEnergy::fibres:
      return {of_directions.c, of_directions.kappa, (material.fibre_ratio - 1.0) * material.young,
              fibre.x(),       fibre.y(),           fibre.z()};
    case StrainEnergy::neo_hookean:
      break;
  }
  return {material.young / (2.0 * (1.0 + material.poisson)), material.young / (3.0 * (1.0 - 2.0 * material.poisson))};
}

}  // namespace phymul
