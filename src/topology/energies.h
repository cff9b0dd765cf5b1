// SPDX-License-Identifier: MIT
//
// The energies of Law::particle_averaged, a row each. What else belongs to one: its constants (energies.cpp), its formula
// in double precision (elastic/energy_density.h), and its text for all other backends, glsl/kernels/energy_<name>.glsl,
// which cpu/simd/kernel_text.h and tests/mirror/kernels.h include.
#pragma once

#include <phymul/topology_textures.h>

#include <array>

namespace phymul {

struct EnergyKind {
  StrainEnergy energy;
  const char* name;
  std::size_t constants;    ///< of DomainTexel::energy
  double least_stabiliser;  ///< below it rough motions would cost next to nothing
};

inline constexpr std::array energy_kinds{EnergyKind{StrainEnergy::shape_memory, "shape_memory", 2, 0.1},
                                         EnergyKind{StrainEnergy::neo_hookean, "neo_hookean", 2, 0.25}};

constexpr const EnergyKind& kind_of(StrainEnergy energy) {
  return energy_kinds[static_cast<std::size_t>(energy)];
}

/// DomainTexel::energy.
std::array<double, most_energy_constants> energy_constants(StrainEnergy energy, const Material& material);

}  // namespace phymul
