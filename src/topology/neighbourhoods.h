// SPDX-License-Identifier: MIT
//
// The neighbours of a particle as triples, and which bases it takes, before stiffness and packing.
#pragma once

#include <phymul/model.h>
#include <phymul/topology.h>
#include <phymul/topology_textures.h>
#include <phymul/types.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <vector>

namespace phymul {

// Rest geometry of a base: lambda, beta and normal in the notation of topology.h. Every test is relative to the base's
// own size, so that a body of micrometres and one of metres take the same path.

/// A base of some particle, seen at rest.
struct RestBase {
  std::array<Index, 3> vertex{-1, -1, -1};  ///< a, b, c; c is -1 in 2-D
  std::array<double, 3> lambda{0, 0, 0};    ///< sum 1; third 0 in 2-D
  double beta = 0.0;                        ///< m
  double area = 0.0;                        ///< |w|: twice the triangle's area, m^2 (2-D: the pair's length, m)
  double quality = 0.0;                     ///< |w| / L^2, L the longest edge (2-D: 1, or 0 where a and b coincide)
  Vec3 normal{0, 0, 0};
};

/// Below this quality three vertices lie on a line for all a double can tell.
inline constexpr double collinear_quality = 1e-9;

inline bool has_plane(const RestBase& base) {
  return base.quality > collinear_quality;
}

/// Triangle (a, b, c) seen from x. Quality 0, and nothing else, when it has no area at all.
inline RestBase rest_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ax = x - a;
  const Vec3 w = ab.cross(ac);
  RestBase base;
  base.area = w.norm();
  if (!(base.area > 0.0)) return base;
  base.quality = base.area / std::max({ab.squaredNorm(), ac.squaredNorm(), (c - b).squaredNorm()});
  base.normal = w / base.area;
  base.beta = ax.dot(base.normal);
  base.lambda[1] = ax.cross(ac).dot(base.normal) / base.area;
  base.lambda[2] = ab.cross(ax).dot(base.normal) / base.area;
  base.lambda[0] = 1.0 - base.lambda[1] - base.lambda[2];
  return base;
}

/// Pair (a, b) in the plane z = 0, seen from x.
inline RestBase rest_pair(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const Vec3 ax = x - a;
  RestBase base;
  base.area = ab.norm();
  const double reach = std::max({ax.norm(), (x - b).norm(), base.area});
  if (!(base.area > collinear_quality * reach)) return base;
  base.quality = 1.0;
  base.normal = Vec3(-ab.y(), ab.x(), 0.0) / base.area;
  base.beta = ax.dot(base.normal);
  base.lambda[1] = ax.dot(ab) / ab.squaredNorm();
  base.lambda[0] = 1.0 - base.lambda[1];
  return base;
}

/// The base with vertices `vertex` as particle `owner` sees it; shape of `rest` [N].
inline RestBase rest_base(const VecList& rest, Index owner, const std::array<Index, 3>& vertex) {
  const Vec3& x = rest[owner];
  RestBase base = vertex[2] < 0 ? rest_pair(x, rest[vertex[0]], rest[vertex[1]])
                                : rest_triangle(x, rest[vertex[0]], rest[vertex[1]], rest[vertex[2]]);
  base.vertex = vertex;
  return base;
}

/// Bases of all particles in rows: those of particle i are offset[i] ... offset[i + 1] - 1.
struct BaseTable {
  std::vector<std::size_t> offset{0};  ///< [N + 1]
  std::vector<RestBase> base;          ///< [rows]
  std::vector<double> weight;          ///< [rows] w_t, sum 1 over a particle's bases
  std::vector<double> stiffness;       ///< [N] k_i, N/m

  std::size_t size(Index particle) const { return offset[particle + 1] - offset[particle]; }
};

/// Triples (pairs in 2-D) of the neighbours of `owner` that have a plane, and pass the thresholds unless the options
/// ask for all; in lexicographic order of their places in the neighbour row.
std::vector<RestBase> neighbour_bases(const Model& model, Index owner, const TopologyOptions& options);

/// The bases of a model whose stiffness is in N/m: k_i as the model has it, weights 1 / Bc_i. Throws Error as soon as
/// there are more than 32-bit numbers count three entries each of.
BaseTable select_bases(const Model& model, const TopologyOptions& options);

/// A particle's bases as triples j < k < l of its neighbours.
struct Triples {
  std::vector<Index> neighbour;  ///< in the order of its rows
  std::vector<double> alpha;     ///< of each
  std::vector<Index> base;       ///< row of each triple in that order, or none
};
/// Place of j < k < l among the triples of n neighbours.
Index triple_row(Index n, Index j, Index k, Index l);
Triples triples_of(const TopologyTextures& t, Index i);

/// True where nearly all triples of neighbours are bases, none has more than `most` neighbours and no base has other
/// vertices: the body's attractors can be enumerated.
bool is_enumerable(const TopologyTextures& topology, Index most);

}  // namespace phymul
