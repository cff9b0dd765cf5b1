// SPDX-License-Identifier: MIT
//
// Springs (glsl/kernels/spring.glsl).
#pragma once

#include "base_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

/// Of the springs of a slice, in rows [first, last).
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

}  // namespace phymul::cpu::PHYMUL_ISA
