// SPDX-License-Identifier: MIT
//
// Hexahedral cells with the simplices at their corners, sorted by shape.
#pragma once

#include <vector>

#include "cpu/simd/job.h"
#include "simplices.h"

namespace phymul::cpu {

struct Hexahedron {
  std::array<Index, 8> vertex{};
  int shape = 0;
};

/// Hexahedra of few shapes, in most of which every corner has its simplex: bodies cut from a lattice. Takes them and
/// their simplices out of the rest; empty where shapes are too many to be worth it.
struct Hexahedra {
  std::vector<Hexahedron> all;
  std::vector<std::vector<double>> shapes;      ///< constants of each, [simd::hexahedron_constants]
  std::vector<bool> simplex_taken, cell_taken;  ///< by row
};

Hexahedra find_hexahedra(const TopologyTextures& topology, const Simplices& simplices);

}  // namespace phymul::cpu
