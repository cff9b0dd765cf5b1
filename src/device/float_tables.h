// SPDX-License-Identifier: MIT
//
// FloatTables: the constants of a body for backends that compute in float. Packed once from TopologyTextures, which
// stays the truth; what a GPU is given, bit for bit, and what its mirror on the CPU reads.
//
// Float backends store displacements u_i = x_i - X_i and velocities, and write every force as a difference from the
// rest shape: with e = E + d, E an edge at rest (here, from double), d = u_b - u_a, nothing is lost to cancellation. A
// body at rest has no force to the last bit, and one far from the origin loses no digits.
//
// Rows that a device gathers:
//   base t     force on its vertices a, b, c and on its owner, at 0, 1, 2, 3 of "terms": entry t * 4 + corner
//   volume v   force on its vertices: entry v * 4 + corner
//   wall w     force on the vertices of its patch: entry w * 8 + vertex; FloatWalls
//   domain d   first Piola stress and a force; float_domains.h
#pragma once

#include <phymul/gl.h>
#include <phymul/topology_textures.h>

#include <vector>

#include "float_domains.h"
#include "table_rows.h"

namespace phymul {

/// The triangles of walls (WallTexel) in single precision, without those that are removed. Vectors are empty where the
/// body has no walls. A vertex that is `none` has the number of the first one of its triangle: its weights are 0, and
/// its difference from the first is 0.
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

enum class FloatLayout { table, enumerated };

/// The most turns that a shader's loops take for one particle: over its own neighbours, bases and links, and over the
/// forces it gathers.
struct LoopTurns {
  std::int64_t own = 0, gathered = 0;
};

/// Vectors are unpadded and empty where the body has nothing of the kind.
struct FloatTables {
  TopologyOptions options;
  FloatLayout layout = FloatLayout::table;
  int dimension = 3;
  Index particle_count = 0;
  Index base_count = 0, volume_count = 0;
  LoopTurns turns;

  // Per particle.
  std::vector<Float4> particle;  ///< 1/m (1/kg), k_i (N/m), m (kg), 0
  std::vector<Int4> index;       ///< Nc, X, Bc, X': as TopologyTextures::index
  /// [N + 1] row i and i + 1 bound particle i's entries in `reaction`, `volume_entry`, `spring` and those of `walls`.
  std::vector<Int4> lists;

  // Attractor of the reactions full, shared, barycentric and averaged. Rows as TopologyTextures::neighbours.
  std::vector<std::int32_t> neighbour;
  std::vector<float> alpha;
  /// Enumerated layout only, where `alpha` and the tables per base are empty: per neighbour row the rest edge X_j - X_i
  /// and alpha; per particle its first texel of `height`; beta times w of its triples (j < k < l in the order of its
  /// neighbour rows), four a texel. 0 where the triple is no base: it may have no plane, and must be passed over.
  std::vector<Float4> edge_alpha;
  std::vector<std::int32_t> first_height;
  std::vector<Float4> height;

  // Per base. The third vertex is `none` in 2-D.
  std::vector<Int4> base;        ///< a, b, c, bits of beta
  std::vector<Float4> base_e1;   ///< X_b - X_a, lambda_b
  std::vector<Float4> base_e2;   ///< X_c - X_a (2-D: 0), lambda_c (2-D: 0)
  std::vector<Int2> base_share;  ///< owner; bits of k_i w_t (conservative) or of w_t (the others)

  // Gathered forces.
  std::vector<Int2> share;  ///< full, shared, barycentric: owner of the row, bits of the share of -F it gives
  std::vector<std::int32_t> reaction;  ///< averaged, conservative: base entries t * 4 + corner; own bases (corner 3)
                                       ///< are not listed, their rows are X' ... X' + Bc - 1
  std::vector<Int4> volume;            ///< a, b, c, d (2-D: d none)
  std::vector<Float4> volume_e1;       ///< X_b - X_a, 1 / (6 V) (2-D: 1 / (2 A))
  std::vector<Float4> volume_e2;       ///< X_c - X_a, stiffness, J
  std::vector<Float4> volume_e3;       ///< X_d - X_a (2-D: 0), 0
  std::vector<std::int32_t> volume_entry;
  std::vector<std::int32_t> spring_other;  ///< per end: the other particle
  std::vector<Float4> spring;              ///< per end: X_other - X_self, stiffness, N/m
  FloatDomains domains;
  FloatWalls walls;

  bool has_attractors() const { return !neighbour.empty() && options.reaction != Reaction::conservative; }

  /// Calls visit(name, table) for the tables under their names in tables.glsl, but those of FloatEntries.
  template <class Visit>
  void for_each(const Visit& visit) const {
    visit("particle", particle);
    visit("index", index);
    visit("lists", lists);
    visit("neighbours", neighbour);
    visit("alpha", alpha);
    visit("edge_alpha", edge_alpha);
    visit("first_height", first_height);
    visit("height", height);
    visit("bases", base);
    visit("base_e1", base_e1);
    visit("base_e2", base_e2);
    visit("base_share", base_share);
    visit("share", share);
    visit("volume", volume);
    visit("volume_e1", volume_e1);
    visit("volume_e2", volume_e2);
    visit("volume_e3", volume_e3);
    visit("spring", spring);
    visit("domain_range", domains.range);
    visit("domain_law", domains.law);
    visit("domain_owner", domains.owner);
    visit("link_domain", domains.neighbour);
    visit("link", domains.link);
    visit("wall", walls.vertex);
    visit("wall_law", walls.law);
  }
};

/// `reaction`, `volume_entry`, `spring_other` and those of walls one after another, because a pass reads no more than
/// sixteen tables.
struct FloatEntries {
  /// Throws Error where shaders cannot count to their number.
  explicit FloatEntries(const FloatTables& tables);

  std::vector<std::int32_t> rows;
  int volume_start = 0, spring_start = 0, wall_start = 0;
};

/// Whether the options allow the enumerated layout.
bool can_enumerate(const TopologyTextures& topology);

/// Rows of `share` (thesis' reactions) or `reaction` are bounded by lists[i][0]. Throws Error where an entry would not
/// fit 32 bits or a constant not a float, and for `enumerated` where the options do not allow it.
FloatTables pack_floats(const TopologyTextures& topology, FloatLayout layout = FloatLayout::table);

/// Of a GL backend: enumerated where it is allowed, and asked for or smaller. What is asked for and not allowed is
/// returned as it is; pack_floats refuses it.
FloatLayout choose_layout(BaseLayout wish, const TopologyTextures& topology);

}  // namespace phymul
