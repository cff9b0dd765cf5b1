// SPDX-License-Identifier: MIT
//
// Stars and boxes of a lattice whose nodes stand in the order of the lattice: lanes are nodes side by side on a line,
// and neighbours are one, a line or a layer further, so that each node is gathered and scattered once. Forces on
// neighbours one node further have fields of their own, where they stand at the node they come from: added in one
// place, a load of some lanes would wait for the store of others.
#pragma once

#include "star_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

/// A vector per node, component after component.
struct NodeField {
  float* first;
  std::int64_t pitch;

  PHYMUL_INLINE Pack3 at(std::int64_t node) const {
    return {load(first + node), load(first + pitch + node), load(first + 2 * pitch + node)};
  }
  PHYMUL_INLINE void put(std::int64_t node, Pack3 v) const {
    store(first + node, v.x);
    store(first + pitch + node, v.y);
    store(first + 2 * pitch + node, v.z);
  }
  PHYMUL_INLINE void add(std::int64_t node, Pack3 v) const { put(node, at(node) + v); }
};

struct NodeFields {
  NodeField u, own, low, high;    // low, high: forces on the neighbours one node back, one further
  NodeField to[3][2];             // where forces on a neighbour go, [axis][side]
  std::int64_t stride[3], by[3];  // by: between a node and the place in `to`
  NodeField corner[8];            // where forces on the corners of a box go, of its node

  explicit NodeFields(const simd::Job& job) {
    const std::int64_t pitch = job.grid.pitch;
    float* const begin = job.grid_memory + job.grid.margin;
    u = {begin, pitch};
    own = {begin + 3 * pitch, pitch};
    low = {begin + 6 * pitch, pitch};
    high = {begin + 9 * pitch, pitch};
    for (int axis = 0; axis < 3; ++axis) {
      stride[axis] = job.grid.stride[axis];
      const bool next = stride[axis] == 1;
      by[axis] = next ? 0 : stride[axis];
      to[axis][0] = next ? low : own;
      to[axis][1] = next ? high : own;
    }
    for (int k = 0; k < 8; ++k) {
      corner[k] = own;
      std::int64_t shift = 0;
      for (int axis = 0; axis < 3; ++axis) {
        if ((k >> axis & 1) == 0) continue;
        shift += by[axis];
        if (stride[axis] == 1) corner[k] = high;
      }
      corner[k].first += shift;
    }
  }
};

template <bool whole>
PHYMUL_INLINE Pack3 kept(Ints mask, Pack3 v) {
  if constexpr (whole) return v;
  return {select(mask, v.x, Pack{}), select(mask, v.y, Pack{}), select(mask, v.z, Pack{})};
}

/// Octants of a star that have its spoke (axis, side).
constexpr std::int32_t octants_at(int axis, int side) {
  constexpr std::int32_t high[3] = {0xaa, 0xcc, 0xf0};
  return side != 0 ? high[axis] : 0xff ^ high[axis];
}

template <bool whole, bool bounded>
PHYMUL_INLINE void grid_star(const NodeFields& at, std::int64_t node, const simd::BoxShape& box, Ints octants) {
  StarWork star;
  const Pack3 u = at.u.at(node);
  Pack longest{};
#pragma GCC unroll 3
  for (int axis = 0; axis < 3; ++axis) {
#pragma GCC unroll 3
    for (int s = 0; s < 2; ++s) {
      const Pack3 v = at.u.at(s != 0 ? node + at.stride[axis] : node - at.stride[axis]);
      const Pack3 out = kept<whole>((octants & octants_at(axis, s)) != 0, s != 0 ? v - u : u - v);
      star.a[axis][s] = {{out.x, out.y, out.z}};
      star.edge[axis][s] = all(box.h[axis]) + star.a[axis][s].at[axis];
      longest += dot(out, out);
    }
  }
  star_forces<whole, bounded>(star, box, octants, longest);
  Pack3 sum{};
#pragma GCC unroll 3
  for (int axis = 0; axis < 3; ++axis) {
    const ByAxis &l = star.f[axis][0], &h = star.f[axis][1];
    const Pack3 low{-l.at[0], -l.at[1], -l.at[2]}, high{h.at[0], h.at[1], h.at[2]};
    sum += low + high;
    at.to[axis][0].add(node - at.by[axis], low);
    at.to[axis][1].add(node + at.by[axis], high);
  }
  at.own.add(node, -sum);
}

/// The boxes in the octant of the nodes' high sides.
template <bool whole, bool bounded>
PHYMUL_INLINE void grid_boxes(const NodeFields& at, std::int64_t node, const simd::BoxShape& box, Ints octants) {
  Pack3 u[8];
#pragma GCC unroll 8
  for (int k = 0; k < 8; ++k) {
    u[k] = at.u.at(node + (k & 1) * at.stride[0] + (k >> 1 & 1) * at.stride[1] + (k >> 2) * at.stride[2]);
  }
  const BoxForces found = box_forces<bounded>(((u[1] - u[0]) + (u[3] - u[2])) + ((u[5] - u[4]) + (u[7] - u[6])),
                                              ((u[2] - u[0]) + (u[3] - u[1])) + ((u[6] - u[4]) + (u[7] - u[5])),
                                              ((u[4] - u[0]) + (u[5] - u[1])) + ((u[6] - u[2]) + (u[7] - u[3])), box);
  const Ints here = (octants & 0x80) != 0;
  const Pack3 x = kept<whole>(here, found.x), y = kept<whole>(here, found.y), z = kept<whole>(here, found.z);
  const Pack3 both = x + y, turned = y - x;
  const Pack3 f0 = both + z, f1 = turned + z, f4 = both - z, f5 = turned - z;
  const Pack3 f[8] = {f0, f1, -f5, -f4, f4, f5, -f1, -f0};
#pragma GCC unroll 8
  for (int k = 0; k < 8; ++k) at.corner[k].add(node, f[k]);
}

template <bool whole, bool bounded>
[[gnu::noinline]] void grid_rows_of(const simd::Job& job, int first, int last) {
  const NodeFields at(job);
  for (int r = first; r < last; ++r) {
    const simd::GridRow& row = job.grid.rows[r];
    Ints octants;
    __builtin_memcpy(&octants, job.grid.octants + static_cast<std::int64_t>(r) * lanes, sizeof octants);
    grid_star<whole, bounded>(at, row.node, job.box_shapes[row.shape], octants);
  }
  for (int r = first; r < last; ++r) {
    const simd::GridRow& row = job.grid.rows[r];
    if (!row.boxes) continue;
    Ints octants;
    __builtin_memcpy(&octants, job.grid.octants + static_cast<std::int64_t>(r) * lanes, sizeof octants);
    grid_boxes<whole, bounded>(at, row.node, job.box_shapes[row.shape], octants);
  }
}

template <bool bounded>
void grid_rows(const simd::Job& job) {
  const NodeFields at(job);
  const simd::Grid& grid = job.grid;
  for (std::int64_t k = 0; k < 9 * grid.pitch; k += lanes) store(at.own.first - grid.margin + k, Pack{});
  for (std::int64_t node = 0; node < grid.nodes; node += lanes) at.u.put(node, gather(job.u, grid.slot + node));
  grid_rows_of<true, bounded>(job, 0, grid.whole);
  grid_rows_of<false, bounded>(job, grid.whole, grid.count);
  for (std::int64_t node = 0; node < grid.nodes; node += lanes) {
    scatter_add(job.force, grid.slot + node, at.own.at(node) + at.high.at(node - 1) + at.low.at(node + 1));
  }
}

}  // namespace phymul::cpu::PHYMUL_ISA
