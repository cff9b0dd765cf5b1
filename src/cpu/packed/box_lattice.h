// SPDX-License-Identifier: MIT
//
// Hexahedra that are boxes along the axes, cut anew: the simplices at their corners by the particle they meet in, so
// that the normals of two edges there, which up to four cells share, are computed once (simd/star_terms.h).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "hexahedra.h"

namespace phymul::cpu {

/// A particle with its neighbours along the axes: -x, +x, -y, +y, -z, +z, none where no octant of the star has it.
struct Star {
  Index centre = none;
  std::array<Index, 6> spoke{none, none, none, none, none, none};
  int octants = 0;  ///< bit x + 2 y + 4 z, x = 1 on the + side: a cell of the shape is there
  int shape = 0;
};

struct BoxLattice {
  std::vector<simd::BoxShape> shapes;
  std::vector<Star> stars;
  std::vector<Hexahedron> boxes;  ///< vertex x + 2 y + 4 z is the corner there
};

/// Takes the hexahedra that are boxes out of `hexahedra`; shapes keep their numbers there.
BoxLattice take_boxes(Hexahedra& hexahedra);

}  // namespace phymul::cpu
