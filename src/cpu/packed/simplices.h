// SPDX-License-Identifier: MIT
//
// Terms that share four particles, found so that a backend can take them together.
#pragma once

#include <phymul/topology_textures.h>

#include <array>
#include <vector>

namespace phymul::cpu {

struct Simplex {
  std::array<Index, 4> vertex{};
  std::array<Index, 4> base{none, none, none,
                            none};   ///< row of the base that vertex k owns, over the face of the others
  Index volume = none, cell = none;  ///< rows
};

/// Four particles with at least two terms among them, and which terms those are. Empty, and nothing taken, in 2-D, for
/// reactions other than conservative and with an area exponent; four particles of which three are nearly in line keep
/// their terms to themselves.
struct Simplices {
  std::vector<Simplex> all;
  std::vector<bool> base_taken, volume_taken, cell_taken;  ///< by row
};

Simplices find_simplices(const TopologyTextures& topology);

/// What simd/simplex_terms.h computes with, in the order of its columns: E1, E2, E3; of the bases of vertices 1, 2, 3,
/// 0 the share k w, beta / |w0| for a normal turned as there, 1 / |w0|^2 and lambda of the other vertices but 0; of the
/// volume 1 / (6 V), with the sign of the vertices' order, and stiffness; of the cell stiffness of shape and of volume.
inline constexpr int simplex_constant_count = 34;
std::array<double, simplex_constant_count> simplex_constants(const TopologyTextures& topology, const Simplex& simplex);

}  // namespace phymul::cpu
