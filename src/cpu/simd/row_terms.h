// SPDX-License-Identifier: MIT
//
// Terms of the energy that are rows of their own: springs, volumes, triangles of walls.
#pragma once

#include "base_terms.h"
#include "job.h"
#include "kernel_text.h"
#include "pack_rows.h"

namespace phymul::cpu::PHYMUL_ISA {

/// Springs (glsl/kernels/spring.glsl) of a slice, in rows [first, last).
PHYMUL_INLINE Pack3 spring_forces(const simd::Job& job, int first, int last, Pack3 ui) {
  Pack3 sum{};
  for (int i = first; i < last; ++i) {
    const float* row = job.springs.rows + static_cast<std::int64_t>(i) * simd::spring_columns * lanes;
    if (job.rows_far) prefetch_rows<simd::spring_columns>(row);
    std::int32_t offset[lanes];
    PHYMUL_COPY(offset, row, sizeof offset);
    const Pack3 d = gather(job.u, offset) - ui, R = load3(row + lanes), r = R + d;
    const Pack rest = load(row + 4 * lanes), k = load(row + 5 * lanes);
    const Pack a = dot(r, r) * rest, y = dot(d, R + r) * rest;
    sum -= (k * select(a > 0.0f, inverse_root_change(a, y), all(-1.0f))) * r;
  }
  return sum;
}

/// The force is k (1 - |R| / |r|) r = -k c r, c = |R| / |r| - 1.
inline void spring_slices(const simd::Job& job) {
  for (int slice = 0; slice < job.springs.count; ++slice) {
    const int first = job.springs.first[slice], last = job.springs.first[slice + 1];
    const Pack3 ui = gather_row(job.u + 16 * lanes * slice);
    const Pack3 sum = spring_forces(job, first, last, ui);
    add_row(job.force + 16 * lanes * slice, sum);
  }
}

/// Volume terms (glsl/kernels/volume.glsl).
template <bool plane, bool bounded>
void volume_rows(const simd::Job& job) {
  for (int r = 0; r < job.volumes.count; ++r) {
    const float* row = job.volumes.rows + static_cast<std::int64_t>(r) * simd::volume_columns * lanes;
    if (job.rows_far) prefetch_rows<simd::volume_columns>(row);
    std::int32_t offset[4 * lanes];
    PHYMUL_COPY(offset, row, sizeof offset);
    const Pack3 u0 = gather(job.u, offset);
    const Pack3 d1 = gather(job.u, offset + lanes) - u0, d2 = gather(job.u, offset + 2 * lanes) - u0;
    const Pack3 E1 = load3(row + 4 * lanes), E2 = load3(row + 7 * lanes);
    const Pack inverse = load(row + 13 * lanes), stiffness = load(row + 14 * lanes);
    Pack3 a, b, c;
    if constexpr (plane) {
      VolumeKernels<bounded>::triangle_area_forces(E1, E2, d1, d2, inverse, stiffness, a, b, c);
    } else {
      const Pack3 d3 = gather(job.u, offset + 3 * lanes) - u0, E3 = load3(row + 10 * lanes);
      Pack3 d;
      VolumeKernels<bounded>::tetrahedron_volume_forces(E1, E2, E3, d1, d2, d3, inverse, stiffness, a, b, c, d);
      scatter_add(job.force, offset + 3 * lanes, d);
    }
    scatter_add(job.force, offset, a);
    scatter_add(job.force, offset + lanes, b);
    scatter_add(job.force, offset + 2 * lanes, c);
  }
}

/// A row of triangles of walls (glsl/kernels/wall.glsl) on its way.
struct WallRow {
  const float* row;
  std::int32_t offset[6 * lanes];
  Pack3 d[5], T1, T2, H1, H2;
  Wall::WallFrame now;
  Wall::WallStress stress;

  PHYMUL_INLINE Pack column(int k) const { return load(row + k * lanes); }
  PHYMUL_INLINE Pack gradient(int k, int a) const { return column(21 + 2 * k + a); }
  PHYMUL_INLINE Pack hessian(int k, int ab) const { return column(31 + 3 * k + ab); }
};

PHYMUL_INLINE void take_wall_row(const simd::Job& job, int r, WallRow& w) {
  w.row = job.walls.rows + static_cast<std::int64_t>(r) * simd::wall_columns * lanes;
  if (job.rows_far) prefetch_rows<simd::wall_columns>(w.row);
  PHYMUL_COPY(w.offset, w.row, sizeof w.offset);
  const Pack3 u0 = gather(job.u, w.offset);
  Pack3 H1{}, H2{};
  for (int k = 0; k < 5; ++k) {
    w.d[k] = gather(job.u, w.offset + (k + 1) * lanes) - u0;
    H1 += w.gradient(k, 0) * w.d[k];
    H2 += w.gradient(k, 1) * w.d[k];
  }
  w.H1 = H1;
  w.H2 = H2;
  w.T1 = load3(w.row + 6 * lanes);
  w.T2 = load3(w.row + 9 * lanes);
  w.now = Wall::wall_frame(w.T1, w.T2, H1, H2);
}

PHYMUL_INLINE void add_wall_row(const simd::Job& job, const WallRow& w) {
  const Pack3 X[3] = {load3(w.row + 12 * lanes), load3(w.row + 15 * lanes), load3(w.row + 18 * lanes)};
  Pack change[3];
  for (int ab = 0; ab < 3; ++ab) change[ab] = dot(w.now.turn, X[ab]);
  for (int k = 0; k < 5; ++k) {
    const Pack out = dot(w.now.normal, w.d[k]);
    for (int ab = 0; ab < 3; ++ab) change[ab] += w.hessian(k, ab) * out;
  }
  const Pack moment[3] = {w.column(46) * change[0] + w.column(51) * change[1] + w.column(50) * change[2],
                          w.column(51) * change[0] + w.column(47) * change[1] + w.column(49) * change[2],
                          w.column(50) * change[0] + w.column(49) * change[1] + w.column(48) * change[2]};
  Pack3 by_normal = moment[0] * X[0] + moment[1] * X[1] + moment[2] * X[2];
  Pack share[5];
  for (int k = 0; k < 5; ++k) {
    share[k] = w.hessian(k, 0) * moment[0] + w.hessian(k, 1) * moment[1] + w.hessian(k, 2) * moment[2];
    by_normal += share[k] * w.d[k];
  }
  Pack3 P1, P2, sum{};
  Wall::wall_pulls(w.now, w.stress, by_normal, P1, P2);
  for (int k = 0; k < 5; ++k) {
    const Pack3 pull = w.gradient(k, 0) * P1 + w.gradient(k, 1) * P2 + share[k] * w.now.normal;
    scatter_add(job.force, w.offset + (k + 1) * lanes, -pull);
    sum = sum + pull;
  }
  scatter_add(job.force, w.offset, sum);
}

/// The stresses of several rows are found together: each is a long chain of divisions, and a processor looks ahead over
/// several chains but not over a whole row.
inline void wall_rows(const simd::Job& job) {
  constexpr int most = 4;
  WallRow rows[most];
  Pack stiffest = 0.0f;
  for (int first = 0; first < job.walls.count; first += most) {
    const int count = job.walls.count - first < most ? job.walls.count - first : most;
    for (int k = 0; k < count; ++k) take_wall_row(job, first + k, rows[k]);
    for (int k = 0; k < count; ++k) {
      WallRow& w = rows[k];
      w.stress = Wall::wall_stress(w.now, w.T1, w.T2, w.H1, w.H2, w.column(52), w.column(53));
    }
    for (int k = 0; job.wall_stiffening != nullptr && k < count; ++k) {
      stiffest = larger(Wall::wall_stiffening(rows[k].now, rows[k].stress), stiffest);
    }
    for (int k = 0; k < count; ++k) add_wall_row(job, rows[k]);
  }
  if (job.wall_stiffening != nullptr) PHYMUL_COPY(job.wall_stiffening, &stiffest.v, sizeof stiffest.v);
}

}  // namespace phymul::cpu::PHYMUL_ISA
