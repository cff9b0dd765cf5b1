// SPDX-License-Identifier: MIT
#include "packed_body.h"

#include <algorithm>

#include "topology/locality_order.h"
#include "topology/transpose.h"

namespace phymul::cpu {
namespace {

/// Terms with their vertices renamed, in the order of their least vertex, without those that are removed.
template <class Term, class Vertices, class IsRemoved>
std::vector<Term> renamed(const std::vector<Term>& terms, const std::vector<Index>& to, Vertices vertices,
                          IsRemoved is_removed) {
  std::vector<Term> result;
  if (terms.empty()) return result;
  const auto corners = static_cast<Index>(vertices(terms.front()).size());
  const auto order = order_by_least_vertex(static_cast<Index>(terms.size()), corners, [&](Index row, Index corner) {
    const Index v = vertices(terms[row])[corner];
    return v == none ? none : to[v];
  });
  result.reserve(terms.size());
  for (const Index row : order) {
    if (is_removed(terms[row])) continue;
    result.push_back(terms[row]);
    for (Index& v : vertices(result.back())) {
      if (v != none) v = to[v];
    }
  }
  return result;
}

constexpr auto none_removed = [](const auto&) { return false; };

void copy_rows(const TopologyTextures& from, const std::vector<Index>& order, const std::vector<Index>& to,
               TopologyTextures& result) {
  for (const Index old : order) {
    const IndexTexel& at = from.index[old];
    IndexTexel texel = at;
    texel.first_neighbour = static_cast<Index>(result.neighbours.size());
    texel.first_base = static_cast<Index>(result.bases.size());
    result.index.push_back(texel);
    for (Index r = at.first_neighbour; r < at.first_neighbour + at.neighbour_count; ++r) {
      result.neighbours.push_back(to[from.neighbours[r]]);
      result.alpha.push_back(from.alpha[r]);
    }
    for (Index t = at.first_base; t < at.first_base + at.base_count; ++t) {
      BaseTexel base = from.bases[t];
      for (Index& v : base.vertex) {
        if (v != none) v = to[v];
      }
      result.bases.push_back(base);
      result.lambda.push_back(from.lambda[t]);
      result.weight.push_back(from.weight[t]);
    }
    result.rest.push_back(from.rest[old]);
    result.mass.push_back(from.mass[old]);
    result.stiffness.push_back(from.stiffness[old]);
  }
}

void transpose_lists(const TopologyTextures& from, TopologyTextures& result) {
  const Index n = result.particle_count;
  if (!from.base_owner.empty()) {
    result.base_of = transpose(n, result.base_count, 3, [&](Index r, Index c) { return result.bases[r].vertex[c]; });
    result.base_owner.resize(from.base_owner.size());
  }
  if (!from.neighbour_owner.empty()) {
    result.neighbour_of = transpose(n, result.neighbour_count, 1, [&](Index r, Index) { return result.neighbours[r]; });
    result.neighbour_owner.resize(from.neighbour_owner.size());
  }
  for (Index i = 0; i < n; ++i) {
    const IndexTexel& at = result.index[i];
    if (!from.base_owner.empty()) std::fill_n(result.base_owner.begin() + at.first_base, at.base_count, i);
    if (!from.neighbour_owner.empty()) {
      std::fill_n(result.neighbour_owner.begin() + at.first_neighbour, at.neighbour_count, i);
    }
  }
  const auto of = [n](const auto& terms, Index corners, const auto& vertex) {
    return terms.empty() ? RaggedList{} : transpose(n, static_cast<Index>(terms.size()), corners, vertex);
  };
  result.spring_of = of(result.springs, 2, [&](Index r, Index c) { return result.springs[r].end[c]; });
  result.volume_of = of(result.volumes, 4, [&](Index r, Index c) { return result.volumes[r].vertex[c]; });
}

}  // namespace

TopologyTextures renumbered(const TopologyTextures& topology, const std::vector<Index>& order) {
  std::vector<Index> to(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) to[order[i]] = static_cast<Index>(i);
  TopologyTextures result;
  result.options = topology.options;
  result.dimension = topology.dimension;
  result.particle_count = topology.particle_count;
  result.neighbour_count = topology.neighbour_count;
  result.base_count = topology.base_count;
  copy_rows(topology, order, to, result);
  const auto removed = [](const WallTexel& wall) { return wall.shear == 0.0; };
  result.springs = renamed(
      topology.springs, to, [](auto& s) -> auto& { return s.end; }, none_removed);
  result.volumes = renamed(
      topology.volumes, to, [](auto& v) -> auto& { return v.vertex; }, none_removed);
  result.walls = renamed(
      topology.walls, to, [](auto& w) -> auto& { return w.vertex; }, removed);
  transpose_lists(topology, result);
  return result;
}

}  // namespace phymul::cpu
