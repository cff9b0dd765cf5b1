// SPDX-License-Identifier: MIT
//
// FloatVolumes: the volumes that a scene keeps (Scene::constrain_volume), for backends that compute in float. Packed
// once from the scene; what a GPU is given, bit for bit, and what its mirror on the CPU reads.
//
// What a surface encloses is a difference from rest: the sum over facets a, b, c of what the tetrahedron o, a, b, c has
// gained, o a particle of the surface, with edges at rest that were differenced in double precision. So it is 0 to the
// last bit at rest and wherever the body went as it is. Lengths are over a unit, a power of 2 near the edge of a cube
// of the volume: the terms are of no unit, and floats of a body of any size hold them.
//
// Sums are trees, sixteen terms to one: their rounding grows with the logarithm of the facets, and every device adds in
// the same order.
#pragma once

#include <phymul/scene.h>

#include <vector>

#include "table_rows.h"

namespace phymul {

struct FloatVolumes {
  static constexpr Index terms_a_sum = 16;
  static constexpr std::size_t law_rows = 2, edge_rows = 3;

  /// [volumes][law_rows] unit (m), 1 / unit, mean mass of its particles / 6 (kg), 0; over unit^3: wanted volume less
  /// that at rest, how much may be missing where nothing can be done, 0, 0.
  std::vector<Float4> laws;
  std::vector<Int4> facets;   ///< a, b, c, o
  std::vector<Float4> edges;  ///< [facets][edge_rows] over the unit: X_a - X_o, X_b - X_a, X_c - X_a
  std::vector<Int4> ranges;   ///< [particles] first and end row of `around`, volume (-1: of none), 0
  std::vector<Int4> around;   ///< per particle and facet at it: a, b, c, row of the facet
  /// Sums: first and end of what they add, volume, 0. Those of the first level add facets, those of others nodes of the
  /// level before; the last level has one for each volume.
  std::vector<Int4> nodes;
  std::vector<Int4> levels;  ///< first and end node, 0, 0

  bool empty() const { return laws.empty(); }
  int count() const { return static_cast<int>(laws.size() / law_rows); }
};

/// Empty where the scene keeps none.
FloatVolumes pack_volumes(const Scene& scene);

}  // namespace phymul
