// SPDX-License-Identifier: MIT
//
// The mean deformation of cells. The formula is that of delta_cell.h.
#pragma once

#include "volume_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

struct Columns {
  Pack3 c0, c1, c2;
};

/// A direction m of the cell's mean deformation F = I + H, with |m|^2 = 1 / `norm`: w = cof(F) m, dw = w - m, Hm = H m;
/// bound: see below.
struct Direction {
  Pack3 r, G;  // |m| (n(F) - F m / |m|); rho (r - n (n.r)), rho = |m| / |w|
};

PHYMUL_INLINE Direction direction(Pack3 m, Pack3 dw, Pack3 Hm, Pack bound, Pack norm) {
  const Pack3 w = m + dw;
  const Pack q = norm * dot(w, w);
  const Pack y = norm * dot(dw, w + m);
  const Pack c = select(q > bound, inverse_root_change(q, y), all(-1.0f));
  const Pack3 r = dw + c * w - Hm;
  const Pack rho = c + 1.0f;
  return {r, rho * (r - (norm * rho * rho * dot(w, r)) * w)};
}

/// dE/dF over its stiffness, as a derivative by F: P by itself and A by cof(F).
struct CellSums {
  Columns P, A;
};

/// Sums over the seven directions; C = cof(F) - I. The diagonals are (+-1, +-1, +-1).
PHYMUL_INLINE CellSums direction_sums(const Columns& H, const Columns& C, Pack bound) {
  const Pack one = all(1.0f), zero{}, third = all(0.33333334f);
  const Pack diagonal = all(0.05f), axis = all(0.13333334f);  // weights over |m|^2
  const Pack3 Cp = C.c0 + C.c1, Cm = C.c1 - C.c0, Hp = H.c0 + H.c1, Hm = H.c1 - H.c0;
  const Direction a = direction({one, one, one}, Cp + C.c2, Hp + H.c2, bound, third);
  const Direction b = direction({-one, one, one}, Cm + C.c2, Hm + H.c2, bound, third);
  const Direction c = direction({one, -one, one}, C.c2 - Cm, H.c2 - Hm, bound, third);
  const Direction d = direction({one, one, -one}, Cp - C.c2, Hp - H.c2, bound, third);
  const Direction x = direction({one, zero, zero}, C.c0, H.c0, bound, one);
  const Direction y = direction({zero, one, zero}, C.c1, H.c1, bound, one);
  const Direction z = direction({zero, zero, one}, C.c2, H.c2, bound, one);
  CellSums sums;
  const auto fold = [&](Pack3 va, Pack3 vb, Pack3 vc, Pack3 vd, Columns & to) __attribute__((always_inline)) {
    const Pack3 ad = va + vd, bc = vc - vb;
    to.c0 = diagonal * (ad + bc);
    to.c1 = diagonal * (ad - bc);
    to.c2 = diagonal * ((va - vd) + (vb + vc));
  };
  fold(a.r, b.r, c.r, d.r, sums.P);
  fold(a.G, b.G, c.G, d.G, sums.A);
  sums.P = {-(sums.P.c0 + axis * x.r), -(sums.P.c1 + axis * y.r), -(sums.P.c2 + axis * z.r)};
  sums.A.c0 += axis * x.G;
  sums.A.c1 += axis * y.G;
  sums.A.c2 += axis * z.G;
  return sums;
}

/// P = dE/dF at F = I + H.
template <bool bounded>
PHYMUL_INLINE Columns cell_stress(const Columns& H, Pack shape, Pack volume) {
  const Columns F{{H.c0.x + 1.0f, H.c0.y, H.c0.z}, {H.c1.x, H.c1.y + 1.0f, H.c1.z}, {H.c2.x, H.c2.y, H.c2.z + 1.0f}};
  // cof(I + H) - I = tr(H) I - H^T + cof(H), without the cancellation of its left side.
  Columns C{cross(H.c1, H.c2), cross(H.c2, H.c0), cross(H.c0, H.c1)};
  const Pack determinant = dot(H.c0, C.c0);
  const Pack minors = C.c0.x + C.c1.y + C.c2.z;
  const Pack trace = H.c0.x + H.c1.y + H.c2.z;
  C.c0 += Pack3{trace - H.c0.x, -H.c1.x, -H.c2.x};
  C.c1 += Pack3{-H.c0.y, trace - H.c1.y, -H.c2.y};
  C.c2 += Pack3{-H.c0.z, -H.c1.z, trace - H.c2.z};
  // Of two unit vectors across m, |F t1| |F t2| is at most half the squared norm of F: bounds the square of |w| below
  // which it is collapsed.
  const Pack norm = dot(F.c0, F.c0) + dot(F.c1, F.c1) + dot(F.c2, F.c2);
  const CellSums sums = direction_sums(H, C, (0.25f * collapsed) * norm * norm);
  const Pack q = volume * volume_pressure<bounded>(trace + minors + determinant);
  const Columns& A = sums.A;
  Columns P{cross(A.c1, F.c2) + cross(F.c1, A.c2), cross(A.c2, F.c0) + cross(F.c2, A.c0),
            cross(A.c0, F.c1) + cross(F.c0, A.c1)};
  P.c0 = shape * (sums.P.c0 + P.c0) + q * C.c0;
  P.c1 = shape * (sums.P.c1 + P.c1) + q * C.c1;
  P.c2 = shape * (sums.P.c2 + P.c2) + q * C.c2;
  P.c0.x += q;
  P.c1.y += q;
  P.c2.z += q;
  return P;
}

template <int corners, bool bounded>
PHYMUL_INLINE void cell_rows_of(const simd::Rows& cells, const simd::Job& job) {
  for (int r = 0; r < cells.count; ++r) {
    const float* row = cells.rows + static_cast<std::int64_t>(r) * simd::cell_columns(corners) * lanes;
    std::int32_t offset[corners * lanes];
    __builtin_memcpy(offset, row, sizeof offset);
    const float* gradient = row + corners * lanes;
    const Pack3 u0 = gather(job.u, offset);
    Columns H{};
#pragma GCC unroll 8
    for (int k = 1; k < corners; ++k) {
      const Pack3 d = gather(job.u, offset + k * lanes) - u0, g = load3(gradient + 3 * (k - 1) * lanes);
      H.c0 += g.x * d;
      H.c1 += g.y * d;
      H.c2 += g.z * d;
    }
    const float* stiffness = gradient + 3 * (corners - 1) * lanes;
    const Columns P = cell_stress<bounded>(H, load(stiffness), load(stiffness + lanes));
    Pack3 sum{};
#pragma GCC unroll 8
    for (int k = 1; k < corners; ++k) {
      const Pack3 g = load3(gradient + 3 * (k - 1) * lanes);
      const Pack3 f = g.x * P.c0 + g.y * P.c1 + g.z * P.c2;
      sum += f;
      scatter_add(job.force, offset + k * lanes, -f);
    }
    scatter_add(job.force, offset, sum);
  }
}

template <bool bounded>
void cell_rows(const simd::Job& job) {
  if (job.cells4.count > 0) cell_rows_of<4, bounded>(job.cells4, job);
  if (job.cells6.count > 0) cell_rows_of<6, bounded>(job.cells6, job);
  if (job.cells8.count > 0) cell_rows_of<8, bounded>(job.cells8, job);
}

}  // namespace phymul::cpu::PHYMUL_ISA
