// SPDX-License-Identifier: MIT
#include "energies.h"

namespace phymul {

std::array<double, most_energy_constants> energy_constants(StrainEnergy energy, const Material& material) {
  switch (energy) {
    case StrainEnergy::shape_memory: {
      const Calibration of_directions = calibrate(material);
      return {of_directions.c, of_directions.kappa};
    }
    case StrainEnergy::neo_hookean:
      break;
  }
  return {material.young / (2.0 * (1.0 + material.poisson)), material.young / (3.0 * (1.0 - 2.0 * material.poisson))};
}

}  // namespace phymul
