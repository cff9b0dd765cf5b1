// SPDX-License-Identifier: MIT
//
// Volume terms (glsl/kernels/volume.glsl).
#pragma once

#include "job.h"
#include "kernel_text.h"
#include "pack_rows.h"

namespace phymul::cpu::PHYMUL_ISA {

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

}  // namespace phymul::cpu::PHYMUL_ISA
