// SPDX-License-Identifier: MIT
//
// Stars and boxes wherever their particles stand: gathered and scattered one by one.
#pragma once

#include "star_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

template <bool whole, bool bounded>
PHYMUL_INLINE void star_row(const simd::Job& job, const float* row, const simd::BoxShape& box) {
  std::int32_t offset[8 * lanes];
  __builtin_memcpy(offset, row, sizeof offset);
  Ints octants;
  __builtin_memcpy(&octants, offset + 7 * lanes, sizeof octants);
  StarWork star;
  const Pack3 u = gather(job.u, offset);
  Pack longest{};
#pragma GCC unroll 3
  for (int axis = 0; axis < 3; ++axis) {
#pragma GCC unroll 3
    for (int s = 0; s < 2; ++s) {
      const Pack3 v = gather(job.u, offset + (1 + 2 * axis + s) * lanes);
      const Pack3 out = s != 0 ? v - u : u - v;
      star.a[axis][s] = {{out.x, out.y, out.z}};
      star.edge[axis][s] = all(box.h[axis]) + star.a[axis][s].at[axis];
      longest += dot(out, out);
    }
  }
  star_forces<whole, bounded>(star, box, octants, longest);
  Pack3 sum{};
#pragma GCC unroll 3
  for (int axis = 0; axis < 3; ++axis) {
#pragma GCC unroll 3
    for (int s = 0; s < 2; ++s) {
      const Pack3 out{star.f[axis][s].at[0], star.f[axis][s].at[1], star.f[axis][s].at[2]};
      const Pack3 f = s != 0 ? out : -out;
      sum += f;
      scatter_add(job.force, offset + (1 + 2 * axis + s) * lanes, f);
    }
  }
  scatter_add(job.force, offset, -sum);
}

template <bool whole, bool bounded>
[[gnu::noinline]] void star_rows(const simd::Job& job, int first, int last) {
  for (int r = first; r < last; ++r) {
    star_row<whole, bounded>(job, job.stars.rows + static_cast<std::int64_t>(r) * simd::star_columns * lanes,
                             job.box_shapes[job.star_shape[r] & ~simd::cut_star]);
  }
}

template <bool bounded>
void star_runs(const simd::Job& job) {
  for (int r = 0; r < job.stars.count;) {
    const int cut = job.star_shape[r] & simd::cut_star;
    int last = r + 1;
    while (last < job.stars.count && (job.star_shape[last] & simd::cut_star) == cut) ++last;
    cut != 0 ? star_rows<false, bounded>(job, r, last) : star_rows<true, bounded>(job, r, last);
    r = last;
  }
}

/// Mean deformations of boxes: differences along the edges.
template <bool bounded>
void box_rows(const simd::Job& job) {
  for (int r = 0; r < job.boxes.count; ++r) {
    std::int32_t offset[8 * lanes];
    __builtin_memcpy(offset, job.boxes.rows + static_cast<std::int64_t>(r) * 8 * lanes, sizeof offset);
    Pack3 u[8];
    for (int k = 0; k < 8; ++k) u[k] = gather(job.u, offset + k * lanes);
    const BoxForces on = box_forces<bounded>(((u[1] - u[0]) + (u[3] - u[2])) + ((u[5] - u[4]) + (u[7] - u[6])),
                                             ((u[2] - u[0]) + (u[3] - u[1])) + ((u[6] - u[4]) + (u[7] - u[5])),
                                             ((u[4] - u[0]) + (u[5] - u[1])) + ((u[6] - u[2]) + (u[7] - u[3])),
                                             job.box_shapes[job.box_shape[r]]);
    const Pack3 both = on.x + on.y, turned = on.y - on.x;
    const Pack3 f0 = both + on.z, f1 = turned + on.z, f4 = both - on.z, f5 = turned - on.z;
    scatter_add(job.force, offset, f0);
    scatter_add(job.force, offset + lanes, f1);
    scatter_add(job.force, offset + 2 * lanes, -f5);
    scatter_add(job.force, offset + 3 * lanes, -f4);
    scatter_add(job.force, offset + 4 * lanes, f4);
    scatter_add(job.force, offset + 5 * lanes, f5);
    scatter_add(job.force, offset + 6 * lanes, -f1);
    scatter_add(job.force, offset + 7 * lanes, -f0);
  }
}

}  // namespace phymul::cpu::PHYMUL_ISA
