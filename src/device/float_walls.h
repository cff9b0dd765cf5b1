// SPDX-License-Identifier: MIT
//
// FloatWalls: the triangles of walls (WallTexel) in single precision, without those that are removed.
#pragma once

#include <phymul/topology_textures.h>

#include <vector>

#include "table_rows.h"

namespace phymul {

/// Vectors are empty where the body has no walls. A vertex that is `none` has the number of the first one of its
/// triangle: its weights are 0, and its difference from the first is 0.
struct FloatWalls {
  static constexpr Index law_texels = 12;

  std::vector<Int4> vertex;  ///< two rows per triangle: vertices 0 to 3; 4, 5, none, none
  /// `law_texels` rows per triangle; g gradient, h hessian, by vertex:
  ///   0, 1      tangents (1); shear (J), compliance (1)
  ///   2, 3, 4   second derivatives 11, 22, twice 12 (1/m); bending of 11 11, 22 22, 12 12 (N m^3)
  ///   5 ... 9   of vertex 1 ... 5: g_1, g_2 (1/m), h_11, h_22 (1/m^2)
  ///   10, 11    h_12 of vertices 1 ... 5, bending of 22 12, 11 12, 11 22
  std::vector<Float4> law;
  /// [N + 1] offset of a particle's entries, row * 8 + number of the vertex, in order.
  RaggedList entries;

  Index count() const { return static_cast<Index>(vertex.size() / 2); }
};

/// Throws Error where an entry would not fit 32 bits, or a constant is beyond single precision.
FloatWalls pack_walls(const TopologyTextures& topology);

}  // namespace phymul
