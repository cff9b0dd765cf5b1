// SPDX-License-Identifier: MIT
//
// Volume terms. The formula is that of delta_volume.h.
#pragma once

#include "base_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

template <bool bounded>
PHYMUL_INLINE Pack volume_pressure(Pack change) {
  if constexpr (!bounded) return change;
  const Pack x = change * 2.5f;
  return change * inverse_root(1.0f + x * x);
}

template <bool plane, bool bounded>
void volume_rows(const simd::Job& job) {
  for (int r = 0; r < job.volumes.count; ++r) {
    const float* row = job.volumes.rows + static_cast<std::int64_t>(r) * simd::volume_columns * lanes;
    if (job.rows_far) prefetch_rows<simd::volume_columns>(row);
    std::int32_t offset[4 * lanes];
    __builtin_memcpy(offset, row, sizeof offset);
    const Pack3 u0 = gather(job.u, offset);
    const Pack3 d1 = gather(job.u, offset + lanes) - u0, d2 = gather(job.u, offset + 2 * lanes) - u0;
    const Pack3 E1 = load3(row + 4 * lanes), E2 = load3(row + 7 * lanes);
    const Pack3 e1 = E1 + d1, e2 = E2 + d2;
    const Pack inverse = load(row + 13 * lanes), stiffness = load(row + 14 * lanes);
    if constexpr (plane) {
      const Pack change = ((d1.x * e2.y - d1.y * e2.x) + (E1.x * d2.y - E1.y * d2.x)) * inverse;
      const Pack q = -(stiffness * volume_pressure<bounded>(change) * inverse);
      const Pack3 f1 = q * Pack3{e2.y, -e2.x, Pack{}}, f2 = q * Pack3{-e1.y, e1.x, Pack{}};
      scatter_add(job.force, offset, -(f1 + f2));
      scatter_add(job.force, offset + lanes, f1);
      scatter_add(job.force, offset + 2 * lanes, f2);
    } else {
      const Pack3 d3 = gather(job.u, offset + 3 * lanes) - u0, E3 = load3(row + 10 * lanes), e3 = E3 + d3;
      const Pack3 dw = cross(d1, e2) + cross(E1, d2);
      const Pack change = (dot(dw, e3) + dot(cross(E1, E2), d3)) * inverse;
      const Pack q = -(stiffness * volume_pressure<bounded>(change) * inverse);
      const Pack3 f1 = q * cross(e2, e3), f2 = q * cross(e3, e1), f3 = q * cross(e1, e2);
      scatter_add(job.force, offset, -(f1 + f2 + f3));
      scatter_add(job.force, offset + lanes, f1);
      scatter_add(job.force, offset + 2 * lanes, f2);
      scatter_add(job.force, offset + 3 * lanes, f3);
    }
  }
}

}  // namespace phymul::cpu::PHYMUL_ISA
