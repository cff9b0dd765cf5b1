// SPDX-License-Identifier: MIT
//
// The models that are compared: springs, shape memory with each reaction, the material. Each takes its
// stiffness from E and nu by a rule of its own, never from the error that is charted.
#pragma once

#include <phymul/phymul.h>

#include <string>
#include <vector>

#include "problem.h"

namespace phymul::bench {

enum class StiffnessRule {
  material,  ///< set_material's calibration
  lattice,   ///< springs: the k whose energy in a uniform uniaxial stress state is that of E (see spring_stiffness)
  stretched  ///< the k with which this very body, stretched by 1 % between its ends, pulls with the force E asks for
};

struct Method {
  std::string name;   ///< in CSV files
  std::string label;  ///< in charts
  StiffnessRule rule = StiffnessRule::material;
  int neighbours = 6;          ///< 6: along cell edges; 18: and face diagonals; 26: all pairs of a cell
  bool volume_energy = false;  ///< springs with a volume energy that brings nu from 1/4 to the wanted one
  TopologyOptions options;
};

const std::vector<Method>& all_methods();
std::vector<std::string> method_names();

/// The problem's body as the method wants it: neighbours, stiffness 1 N/m where it is not calibrated, options.
struct MethodBody {
  Model model;
  TopologyOptions options;
};
MethodBody body_for(const Method& method, const Problem& problem);

/// Sets the stiffness of every particle, N/m.
void set_stiffness(MethodBody& body, double stiffness);

/// The lattice rule: half the sum of spring energies under strain diag(1, -nu, -nu), averaged over the three axes, and
/// the volume energy, equal E/2 times the volume. On a cubic lattice with 18 neighbours and nu = 1/4 it is the known
/// k = 2/5 E h, up to the surface.
double spring_stiffness(const MethodBody& body, const Material& material);

}  // namespace phymul::bench
