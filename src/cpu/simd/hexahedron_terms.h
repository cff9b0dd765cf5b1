// SPDX-License-Identifier: MIT
//
// Hexahedra of one shape: their eight corner simplices and their mean deformation together, with one gather and one
// scatter of eight particles. All lanes share their constants, so that a lattice streams nothing but offsets.
#pragma once

#include "simplex_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

struct SharedConstants {
  const float* value;
  PHYMUL_INLINE Pack at(int k) const { return all(value[k]); }
  PHYMUL_INLINE Pack3 vector(int k) const { return {all(value[k]), all(value[k + 1]), all(value[k + 2])}; }
};

PHYMUL_INLINE Pack3 scaled_sum(const Columns& P, Pack3 g) {
  return g.x * P.c0 + g.y * P.c1 + g.z * P.c2;
}

template <bool bounded>
void hexahedron_rows(const simd::Job& job) {
  for (int r = 0; r < job.hexahedra.count; ++r) {
    std::int32_t offset[8 * lanes];
    __builtin_memcpy(offset, job.hexahedra.rows + static_cast<std::int64_t>(r) * 8 * lanes, sizeof offset);
    const float* shape =
        job.hexahedron_shapes + static_cast<std::int64_t>(job.hexahedron_shape[r]) * simd::hexahedron_constants;
    Pack3 u[8], f[8];
    for (int k = 0; k < 8; ++k) {
      u[k] = gather(job.u, offset + k * lanes);
      f[k] = Pack3{};
    }
    for (int corner = 0; corner < 8; ++corner) {
      const int a = simd::hexahedron_edges[corner][0], b = simd::hexahedron_edges[corner][1],
                c = simd::hexahedron_edges[corner][2];
      const Pack3 d1 = u[a] - u[corner], d2 = u[b] - u[corner], d3 = u[c] - u[corner];
      const SharedConstants constants{shape + simd::simplex_constants * corner};
      Pack most = all(-1.0f);
      SimplexForces on = simplex_forces<bounded, false, true>(d1, d2, d3, constants, most);
      if (any_below(all(most_near), most)) [[unlikely]]
        on = far_simplex_forces<bounded, false>(d1, d2, d3, constants);
      f[a] += on.f1;
      f[b] += on.f2;
      f[c] += on.f3;
      f[corner] -= on.f1 + on.f2 + on.f3;
    }
    const SharedConstants cell{shape + 8 * simd::simplex_constants};  // gradients of corners 1 to 7, two stiffnesses
    Columns H{};
#pragma GCC unroll 8
    for (int k = 1; k < 8; ++k) {
      const Pack3 d = u[k] - u[0], g = cell.vector(3 * (k - 1));
      H.c0 += g.x * d;
      H.c1 += g.y * d;
      H.c2 += g.z * d;
    }
    const Columns P = cell_stress<bounded>(H, cell.at(21), cell.at(22));
#pragma GCC unroll 8
    for (int k = 1; k < 8; ++k) {
      const Pack3 on = scaled_sum(P, cell.vector(3 * (k - 1)));
      f[0] += on;
      scatter_add(job.force, offset + k * lanes, f[k] - on);
    }
    scatter_add(job.force, offset, f[0]);
  }
}

}  // namespace phymul::cpu::PHYMUL_ISA
