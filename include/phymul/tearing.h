// SPDX-License-Identifier: MIT
//
// Tearing: where tissue parts by itself.
#pragma once

namespace phymul {

/// Tissue tears at the end of a cut, and near what tools grasp, where the largest principal value of the stress tensor,
/// averaged over `radius`, is 0.55 sqrt(G E / ((1 - nu^2) R)): what it is at a crack whose release of energy is G (A.
/// A. Griffith, The phenomena of rupture and flow in solids, Phil. Trans. R. Soc. A 221 (1921) 163-198; the factor is
/// measured, docs/decisions/2026-11-28-tearing.md). E and nu are the material's at rest.
struct Tearing {
  double toughness = 0.0;  ///< G, J/m^2, >= 0; 0: it does not tear
  double radius = 0.0;     ///< R, m, >= 0; 0: two spacings. Less than 1.1 spacings counts as 1.1
  bool operator==(const Tearing&) const = default;
};

}  // namespace phymul
