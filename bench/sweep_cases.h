// SPDX-License-Identifier: MIT
//
// What the sweep runs: models, and bodies of every size for each.
#pragma once

#include <phymul/phymul.h>

#include <string>
#include <vector>

namespace phymul::bench {

struct SweepVariant {
  std::string name;   ///< of the CSV file
  std::string bases;  ///< base set, for people
  int valence = 6;    ///< of the lattice; 0: unstructured tetrahedra
  bool material = false;
  TopologyOptions options;
};

const std::vector<SweepVariant>& sweep_variants();

/// 4 (a tetrahedron), 275 (the 2007 thesis' cylinder), then cubes of 8^3 to 256^3.
const std::vector<int>& sweep_sizes();

/// Has the variant a body of that size? A tetrahedron is no lattice, so what needs one begins at 275. The cylinder has
/// no 14 neighbours, and with a material it is run as material_lattice only.
bool has_body(const SweepVariant& variant, int size);
Model sweep_body(const SweepVariant& variant, int size);

/// The rest shape with every particle a little off its place: a body at rest would have nothing to compute but zeros.
State sweep_start(const Model& model);

}  // namespace phymul::bench
