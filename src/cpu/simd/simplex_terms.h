// SPDX-License-Identifier: MIT
//
// All terms of four particles at once: up to four bases (each particle over the face of the others), a volume and the
// mean deformation of a tetrahedral cell, with one gather and one scatter. From the first particle, with e = E + d:
//   c1 = e2 x e3, c2 = e3 x e1, c3 = e1 x e2: normals of the faces opposite 1, 2, 3; c1 + c2 + c3 of that opposite 0
// An energy with derivatives A_k by c_k pushes the first corner with -(A2 x e3 + e2 x A3), the others in turn.
#pragma once

#include "cell_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

/// Constants of a simplex, each lane its own; columns as in job.h, after the offsets.
struct LaneConstants {
  const float* row;
  PHYMUL_INLINE Pack at(int k) const { return load(row + k * lanes); }
  PHYMUL_INLINE Pack3 vector(int k) const { return load3(row + k * lanes); }
};

struct SimplexForces {
  Pack3 f1, f2, f3;
};

struct FacePull {
  Pack3 F, G;
};

/// F of the owner and the derivative by w of what it costs; `from` is what the pull has besides the normal. `most`: the
/// largest y so far; where `near` only one up to most_near is right.
template <bool near, class Constants>
PHYMUL_INLINE FacePull face_pull(const Constants& constants, int k, Pack3 w, Pack3 dw, Pack bound, Pack3 from,
                                 Pack& most) {
  const Pack share = constants.at(k), height = constants.at(k + 1), rest = constants.at(k + 2);
  const Pack q = dot(w, w);
  const Pack y = dot(dw, w + (w - dw)) * rest;
  const Pack a = q * rest;
  if constexpr (near) most = larger(y, most);
  const Pack c = select(q > bound, near ? inverse_root_change_near(a, y) : inverse_root_change(a, y), all(-1.0f));
  const Pack3 F = share * (from + height * (dw + c * w));
  const Pack rho = c + 1.0f;
  return {F, (height * rho) * (F - (rest * rho * rho * dot(w, F)) * w)};
}

template <bool bounded, bool cell, bool near, class Constants>
PHYMUL_INLINE SimplexForces simplex_forces(Pack3 d1, Pack3 d2, Pack3 d3, const Constants& constants, Pack& most) {
  const Pack3 E1 = constants.vector(0), E2 = constants.vector(3), E3 = constants.vector(6);
  const Pack3 e1 = E1 + d1, e2 = E2 + d2, e3 = E3 + d3;
  const Pack3 c1 = cross(e2, e3), c2 = cross(e3, e1), c3 = cross(e1, e2);
  const Pack3 dc1 = cross(d2, e3) + cross(E2, d3), dc2 = cross(d3, e1) + cross(E3, d1),
              dc3 = cross(d1, e2) + cross(E1, d2);
  const Pack l1 = collapsed * dot(e1, e1), l2 = dot(e2, e2), l3 = dot(e3, e3);
  const Pack3 e12 = e2 - e1, e13 = e3 - e1;

  // Columns: of each base, first the share, beta / |w0| and 1 / |w0|^2, then its lambda.
  const Pack lambda1_2 = constants.at(12), lambda1_3 = constants.at(13);
  const FacePull p1 =
      face_pull<near>(constants, 9, c1, dc1, collapsed * l2 * l3, lambda1_2 * d2 + lambda1_3 * d3 - d1, most);
  const Pack lambda2_1 = constants.at(17), lambda2_3 = constants.at(18);
  const FacePull p2 = face_pull<near>(constants, 14, c2, dc2, l1 * l3, lambda2_1 * d1 + lambda2_3 * d3 - d2, most);
  const Pack lambda3_1 = constants.at(22), lambda3_2 = constants.at(23);
  const FacePull p3 = face_pull<near>(constants, 19, c3, dc3, l1 * l2, lambda3_1 * d1 + lambda3_2 * d2 - d3, most);
  const Pack lambda0_1 = constants.at(27), lambda0_2 = constants.at(28), lambda0_3 = constants.at(29);
  const FacePull p0 =
      face_pull<near>(constants, 24, c1 + c2 + c3, dc1 + dc2 + dc3, collapsed * dot(e12, e12) * dot(e13, e13),
                      lambda0_1 * d1 + lambda0_2 * d2 + lambda0_3 * d3, most);

  const Pack3 A1 = p1.G + p0.G, A2 = p2.G + p0.G, A3 = p3.G + p0.G;
  Pack3 f1 = p1.F - lambda0_1 * p0.F - lambda2_1 * p2.F - lambda3_1 * p3.F - (cross(A2, e3) + cross(e2, A3));
  Pack3 f2 = p2.F - lambda0_2 * p0.F - lambda1_2 * p1.F - lambda3_2 * p3.F - (cross(e3, A1) + cross(A3, e1));
  Pack3 f3 = p3.F - lambda0_3 * p0.F - lambda1_3 * p1.F - lambda2_3 * p2.F - (cross(A1, e2) + cross(e1, A2));

  const Pack inverse = constants.at(30), stiffness = constants.at(31);
  const Pack q = stiffness * inverse * volume_pressure<bounded>((dot(d1, c1) + dot(E1, dc1)) * inverse);
  f1 -= q * c1;
  f2 -= q * c2;
  f3 -= q * c3;
  if constexpr (cell) {
    const Pack3 g1 = inverse * (c1 - dc1), g2 = inverse * (c2 - dc2), g3 = inverse * (c3 - dc3);
    const Columns H{g1.x * d1 + g2.x * d2 + g3.x * d3, g1.y * d1 + g2.y * d2 + g3.y * d3,
                    g1.z * d1 + g2.z * d2 + g3.z * d3};
    const Columns P = cell_stress<bounded>(H, constants.at(32), constants.at(33));
    f1 -= g1.x * P.c0 + g1.y * P.c1 + g1.z * P.c2;
    f2 -= g2.x * P.c0 + g2.y * P.c1 + g2.z * P.c2;
    f3 -= g3.x * P.c0 + g3.y * P.c1 + g3.z * P.c2;
  }
  return {f1, f2, f3};
}

/// Where a face has grown far beyond its area, which is rare.
template <bool bounded, bool cell, class Constants>
[[gnu::noinline]] SimplexForces far_simplex_forces(Pack3 d1, Pack3 d2, Pack3 d3, const Constants& constants) {
  Pack most{};
  return simplex_forces<bounded, cell, false>(d1, d2, d3, constants, most);
}

template <bool bounded, bool cell>
PHYMUL_INLINE void simplex_rows_of(const simd::Rows& simplices, const simd::Job& job) {
  for (int r = 0; r < simplices.count; ++r) {
    const float* row = simplices.rows + static_cast<std::int64_t>(r) * simd::simplex_columns * lanes;
    if (job.rows_far) prefetch_rows<simd::simplex_columns>(row);
    std::int32_t offset[4 * lanes];
    __builtin_memcpy(offset, row, sizeof offset);
    const Pack3 u0 = gather(job.u, offset);
    const Pack3 d1 = gather(job.u, offset + lanes) - u0, d2 = gather(job.u, offset + 2 * lanes) - u0,
                d3 = gather(job.u, offset + 3 * lanes) - u0;
    const LaneConstants constants{row + 4 * lanes};
    Pack most = all(-1.0f);
    SimplexForces f = simplex_forces<bounded, cell, true>(d1, d2, d3, constants, most);
    if (any_below(all(most_near), most)) [[unlikely]]
      f = far_simplex_forces<bounded, cell>(d1, d2, d3, constants);
    scatter_add(job.force, offset, -(f.f1 + f.f2 + f.f3));
    scatter_add(job.force, offset + lanes, f.f1);
    scatter_add(job.force, offset + 2 * lanes, f.f2);
    scatter_add(job.force, offset + 3 * lanes, f.f3);
  }
}

template <bool bounded>
void simplex_rows(const simd::Job& job) {
  if (job.simplices.count > 0) simplex_rows_of<bounded, false>(job.simplices, job);
  if (job.cell_simplices.count > 0) simplex_rows_of<bounded, true>(job.cell_simplices, job);
}

}  // namespace phymul::cpu::PHYMUL_ISA
