// SPDX-License-Identifier: MIT
#include "renumbering.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "transpose.h"

namespace phymul::cpu {
namespace {

/// The low 21 bits of v, two zero bits between each.
std::uint64_t spread(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x001f00000000ffff;
  v = (v | v << 16) & 0x001f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  v = (v | v << 2) & 0x1249249249249249;
  return v;
}

std::vector<std::uint64_t> morton_codes(const VecList& rest) {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  if (!rest.empty()) low = high = rest.front();
  for (const Vec3& x : rest) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const double extent = (high - low).maxCoeff();
  const double scale = extent > 0.0 ? 2097151.0 / extent : 0.0;
  std::vector<std::uint64_t> codes;
  codes.reserve(rest.size());
  for (const Vec3& x : rest) {
    const Vec3 cell = (x - low) * scale;
    codes.push_back(spread(static_cast<std::uint64_t>(cell.x())) | spread(static_cast<std::uint64_t>(cell.y())) << 1 |
                    spread(static_cast<std::uint64_t>(cell.z())) << 2);
  }
  return codes;
}

/// Terms with their vertices renamed, in the order of their least vertex.
template <class Term, class Vertices>
std::vector<Term> renamed(std::vector<Term> terms, const std::vector<Index>& to, Vertices vertices) {
  for (Term& term : terms) {
    for (Index& v : vertices(term)) {
      if (v != none) v = to[v];
    }
  }
  const auto least = [&](const Term& term) {
    Index smallest = std::numeric_limits<Index>::max();
    for (const Index v : vertices(const_cast<Term&>(term))) {
      if (v != none) smallest = std::min(smallest, v);
    }
    return smallest;
  };
  std::stable_sort(terms.begin(), terms.end(), [&](const Term& a, const Term& b) { return least(a) < least(b); });
  return terms;
}

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
      if (!from.rest_area.empty()) result.rest_area.push_back(from.rest_area[t]);
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
  result.cell_of = of(result.cells, 8, [&](Index r, Index c) { return result.cells[r].vertex[c]; });
}

}  // namespace

std::vector<Index> locality_order(const VecList& rest, const std::vector<Index>& work, Index window) {
  const std::vector<std::uint64_t> codes = morton_codes(rest);
  std::vector<Index> order(rest.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return codes[a] < codes[b]; });
  for (auto first = order.begin(); first != order.end();) {
    const auto last = first + std::min<std::ptrdiff_t>(window, order.end() - first);
    std::stable_sort(first, last, [&](Index a, Index b) { return work[a] > work[b]; });
    first = last;
  }
  return order;
}

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
  result.springs = renamed(
      topology.springs, to, [](SpringTexel & s) -> auto& { return s.end; });
  result.volumes = renamed(
      topology.volumes, to, [](VolumeTexel & v) -> auto& { return v.vertex; });
  result.cells = renamed(
      topology.cells, to, [](CellTexel & c) -> auto& { return c.vertex; });
  transpose_lists(topology, result);
  return result;
}

}  // namespace phymul::cpu
