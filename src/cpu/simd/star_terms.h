// SPDX-License-Identifier: MIT
//
// Corner simplices of boxes along the axes, by the particle they meet in. With e_a, e_b, e_c the edges to neighbours
// along x, y, z, each normal e_a x e_b serves the two bases on its sides and, in sums of three, the bases over the far
// faces. Formulas as in simplex_terms.h, with spokes turned outward:
//   a = +-d, so that every edge is h + a along its axis;  t = |w0| (n - n0) = dw + c w,  m = t + w0 = |w0| n
// Where the edges are along the axes, w and dw differ in one component alone.
#pragma once

#include "simplex_terms.h"

namespace phymul::cpu::PHYMUL_ISA {

/// A vector by its component, or one number per axis.
struct ByAxis {
  Pack at[3];
};

/// Below this |w|^2 / |w0|^2, 1 + y has no longer the digits of it.
inline constexpr float flat = 0.25f;

/// inverse_root_change of n normals at once, step after step: one alone would wait for its own results.
template <int n>
PHYMUL_INLINE void inverse_root_changes(const Pack (&a)[n], const Pack (&y)[n], Pack (&c)[n]) {
  Pack root[n], residual[n];
#pragma GCC unroll 4
  for (int k = 0; k < n; ++k) root[k] = rough_inverse_root(a[k]);
#pragma GCC unroll 4
  for (int k = 0; k < n; ++k) c[k] = root[k] - 1.0f;
#pragma GCC unroll 4
  for (int k = 0; k < n; ++k) residual[k] = c[k] * c[k] + (c[k] + c[k]);
#pragma GCC unroll 4
  for (int k = 0; k < n; ++k) residual[k] = a[k] * residual[k] + y[k];
#pragma GCC unroll 4
  for (int k = 0; k < n; ++k) c[k] -= (root[k] * residual[k]) * (0.5f - 0.375f * residual[k]);
#pragma GCC unroll 4
  for (int k = 0; k < n; ++k) c[k] = zero_at_rest(y[k], c[k]);
}

/// inverse_root_change of 1 + y; `exact` gives |w|^2 / |w0|^2 of normal k, and a mask of bases that have one, for lanes
/// below `floor`.
template <int n, class Exact>
PHYMUL_INLINE void normal_changes(const Pack (&y)[n], Pack floor, Pack (&c)[n], const Exact& exact) {
  Pack a[n];
#pragma GCC unroll 4
  for (int k = 0; k < n; ++k) a[k] = y[k] + 1.0f;
  Pack least = a[0];
  for (int k = 1; k < n; ++k) least = smaller(a[k], least);
  if (!any_below(least, floor)) [[likely]] {
    inverse_root_changes(a, y, c);
    return;
  }
#pragma GCC unroll 4
  for (int k = 0; k < n; ++k) {
    Pack ratio;
    Ints normal;
    exact(k, ratio, normal);
    const Ints low = a[k] < floor;
    c[k] = select(low & ~normal, all(-1.0f), inverse_root_change(select(low, ratio, a[k]), y[k]));
  }
}

PHYMUL_INLINE Pack squared(const ByAxis& v) {
  return v.at[0] * v.at[0] + v.at[1] * v.at[1] + v.at[2] * v.at[2];
}

/// height rho (F - rest (m.F) m): what F costs, by w.
PHYMUL_INLINE ByAxis cost_by_normal(const ByAxis& m, const ByAxis& F, Pack height_rho, Pack rest) {
  const Pack along = rest * (m.at[0] * F.at[0] + m.at[1] * F.at[1] + m.at[2] * F.at[2]);
  ByAxis G;
  for (int k = 0; k < 3; ++k) G.at[k] = height_rho * (F.at[k] - along * m.at[k]);
  return G;
}

struct StarWork {
  ByAxis a[3][2], f[3][2];  // spokes, [axis][side]: displacement, force; both turned outward
  Pack edge[3][2];          // h + a along the axis
  ByAxis dw[3][2][2];       // of the normal along an axis, [axis][side of the next axis][of the one after]
  ByAxis apex[8];           // by octant: what its base over the far faces costs, by the normal
  Pack pressure[8];         // by octant: what its volume costs, by a normal times an edge
  Pack floor;
};

/// Edge (axis, side) whole.
PHYMUL_INLINE ByAxis edge_of(const StarWork& star, int axis, int side) {
  ByAxis e = star.a[axis][side];
  e.at[axis] = star.edge[axis][side];
  return e;
}

/// w - w0 of the four normals along axis C.
template <int C>
PHYMUL_INLINE void normals(StarWork& star, const simd::BoxShape& box) {
  constexpr int A = (C + 1) % 3, B = (C + 2) % 3;
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    const ByAxis &a = star.a[A][k & 1], &b = star.a[B][k >> 1];
    const Pack ea = star.edge[A][k & 1], eb = star.edge[B][k >> 1];
    ByAxis& dw = star.dw[C][k & 1][k >> 1];
    dw.at[A] = a.at[B] * b.at[C] - a.at[C] * eb;
    dw.at[B] = a.at[C] * b.at[A] - ea * b.at[C];
    dw.at[C] = (a.at[A] * eb - a.at[B] * b.at[A]) + all(box.h[A]) * b.at[B];
  }
}

/// Gives back to the edges along A and B what their normal (axis C, sides of k) costs: `leg` of its own bases, and
/// those of the octants on its sides.
template <int C>
PHYMUL_INLINE void give_to_edges(StarWork& star, int k, const ByAxis& leg, ByAxis (&fa)[2], ByAxis (&fb)[2]) {
  constexpr int A = (C + 1) % 3, B = (C + 2) % 3;
  const int low = (k & 1) << A | (k >> 1) << B, high = low | 1 << C;
  ByAxis cost;
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) cost.at[i] = leg.at[i] + (star.apex[high].at[i] - star.apex[low].at[i]);
  if constexpr (C == 2) {
    const ByAxis below = edge_of(star, 2, 0), above = edge_of(star, 2, 1);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) cost.at[i] += star.pressure[low] * below.at[i] + star.pressure[high] * above.at[i];
  }
  const ByAxis ea = edge_of(star, A, k & 1), eb = edge_of(star, B, k >> 1);
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    const int p = (i + 1) % 3, q = (i + 2) % 3;
    fa[k & 1].at[i] -= eb.at[p] * cost.at[q] - eb.at[q] * cost.at[p];
    fb[k >> 1].at[i] -= cost.at[p] * ea.at[q] - cost.at[q] * ea.at[p];
  }
}

/// Bases of the two neighbours along axis C over the triangles in the plane across: four normals.
template <bool whole, int C>
PHYMUL_INLINE void across(StarWork& star, const simd::BoxShape& box, Ints octants) {
  constexpr int A = (C + 1) % 3, B = (C + 2) % 3;
  const simd::BoxShape::Leg& leg = box.leg[C];
  const Pack w0 = all(leg.area), rest = all(leg.rest);
  ByAxis dw[4];
  Pack tilt[4], y[4], c[4];
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) dw[k] = star.dw[C][k & 1][k >> 1];
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    tilt[k] = dw[k].at[A] * dw[k].at[A] + dw[k].at[B] * dw[k].at[B];
    y[k] = (tilt[k] + dw[k].at[C] * (dw[k].at[C] + all(leg.twice_area))) * rest;
  }
  normal_changes(
      y, star.floor, c, [&](int k, Pack& ratio, Ints& normal) __attribute__((always_inline)) {
        const Pack wc = dw[k].at[C] + w0, q = tilt[k] + wc * wc;
        ratio = q * rest;
        normal = q > collapsed * squared(edge_of(star, A, k & 1)) * squared(edge_of(star, B, k >> 1));
      });
  ByAxis fa[2] = {star.f[A][0], star.f[A][1]}, fb[2] = {star.f[B][0], star.f[B][1]};
  ByAxis far[2], sum[2]{};  // share * a of the owners
  for (int i = 0; i < 3; ++i) {
    far[0].at[i] = all(leg.share) * star.a[C][0].at[i];
    far[1].at[i] = all(leg.share) * star.a[C][1].at[i];
  }
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    const Pack rho = c[k] + 1.0f;
    ByAxis t, F;
    t.at[A] = rho * dw[k].at[A];
    t.at[B] = rho * dw[k].at[B];
    t.at[C] = dw[k].at[C] + c[k] * (dw[k].at[C] + w0);
    const int octant = (k & 1) << A | (k >> 1) << B;
    const Ints below = (octants & (1 << octant)) != 0, above = (octants & (1 << (octant | 1 << C))) != 0;
    for (int i = 0; i < 3; ++i) {
      if constexpr (whole) {
        sum[0].at[i] += t.at[i];
        F.at[i] = all(leg.twice_share_height) * t.at[i] - (far[0].at[i] + far[1].at[i]);
      } else {
        const Pack pull = all(leg.share_height) * t.at[i];
        const Pack low = select(below, pull - far[0].at[i], Pack{}), high = select(above, pull - far[1].at[i], Pack{});
        sum[0].at[i] += low;
        sum[1].at[i] += high;
        F.at[i] = low + high;
      }
    }
    t.at[C] += w0;
    give_to_edges<C>(star, k, cost_by_normal(t, F, all(leg.height) * rho, rest), fa, fb);
  }
#pragma GCC unroll 2
  for (int s = 0; s < 2; ++s) {
    star.f[A][s] = fa[s];
    star.f[B][s] = fb[s];
  }
  for (int i = 0; i < 3; ++i) {
    if constexpr (whole) sum[1].at[i] = sum[0].at[i] = all(leg.share_height) * sum[0].at[i];
    star.f[C][0].at[i] += whole ? sum[0].at[i] - 4.0f * far[0].at[i] : sum[0].at[i];
    star.f[C][1].at[i] += whole ? sum[1].at[i] - 4.0f * far[1].at[i] : sum[1].at[i];
  }
}

/// share * lambda * d of the neighbours, of which bases over far faces take one of each axis.
struct Lean {
  ByAxis xy[4], z[2];  // [x side + 2 (y side)]
};

/// Bases of the centre over the far faces of four octants, on one side along z, and the volumes of their corner
/// simplices. Leaves what they cost, the volumes' force along z in `f`, and adds F by axis and side to `sum`.
template <bool whole, bool bounded, int z>
PHYMUL_INLINE void octants_of(StarWork& star, const simd::BoxShape& box, Ints octants, const Lean& lean,
                              ByAxis (&sum)[3][2]) {
  const Pack rest = all(box.apex_rest);
  ByAxis dw[4];
  Pack y[4], c[4], q[4];
  const auto side = [](int k, int axis) __attribute__((always_inline)) {
    return axis == 0 ? k & 1 : axis == 1 ? k >> 1 : z;
  };
  const auto part = [&](int k, int C) __attribute__((always_inline))->const ByAxis& {
    return star.dw[C][side(k, (C + 1) % 3)][side(k, (C + 2) % 3)];
  };
  const auto rest_normal = [&](int k, int C) __attribute__((always_inline)) {
    return all(side(k, C) != 0 ? box.leg[C].area : -box.leg[C].area);
  };
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    Pack longer{};
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
      Pack sum_i = side(k, 0) != 0 ? part(k, 0).at[i] : -part(k, 0).at[i];
      sum_i = side(k, 1) != 0 ? sum_i + part(k, 1).at[i] : sum_i - part(k, 1).at[i];
      dw[k].at[i] = z != 0 ? sum_i + part(k, 2).at[i] : sum_i - part(k, 2).at[i];
      const Pack w0 = rest_normal(k, i);
      longer += dw[k].at[i] * (dw[k].at[i] + (w0 + w0));
    }
    y[k] = longer * rest;
    const ByAxis& x = star.a[0][k & 1];
    const ByAxis& n = part(k, 0);
    const Pack along = x.at[0] * (n.at[0] + all(box.leg[0].area)) + all(box.h[0]) * n.at[0];
    q[k] = all(box.inverse_volume) * (along + (x.at[1] * n.at[1] + x.at[2] * n.at[2]));
  }
  normal_changes(
      y, star.floor, c, [&](int k, Pack& ratio, Ints& normal) __attribute__((always_inline)) {
        ByAxis e[3], w;
#pragma GCC unroll 3
        for (int axis = 0; axis < 3; ++axis) {
          e[axis] = edge_of(star, axis, side(k, axis));
          for (int i = 0; i < 3 && side(k, axis) == 0; ++i) e[axis].at[i] = -e[axis].at[i];
          w.at[axis] = dw[k].at[axis] + rest_normal(k, axis);
        }
        ByAxis e1, e2;
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) {
          e1.at[i] = e[1].at[i] - e[0].at[i];
          e2.at[i] = e[2].at[i] - e[0].at[i];
        }
        ratio = squared(w) * rest;
        normal = squared(w) > collapsed * squared(e1) * squared(e2);
      });
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) q[k] = all(box.corner_volume) * volume_pressure<bounded>(q[k]);
  ByAxis F[4];
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    const Pack rho = c[k] + 1.0f;
    const Ints here = (octants & (1 << (k | z << 2))) != 0;
    ByAxis m;
    for (int i = 0; i < 3; ++i) {
      const Pack w0 = rest_normal(k, i), t = dw[k].at[i] + c[k] * (dw[k].at[i] + w0);
      m.at[i] = t + w0;
      F[k].at[i] = all(box.apex_share_height) * t - (lean.xy[k].at[i] + lean.z[z].at[i]);
      if constexpr (!whole) F[k].at[i] = select(here, F[k].at[i], Pack{});
    }
    if constexpr (!whole) q[k] = select(here, q[k], Pack{});
    star.apex[k | z << 2] = cost_by_normal(m, F[k], all(box.apex_height) * rho, rest);
    star.pressure[k | z << 2] = q[k];
  }
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    const Pack low = F[0].at[i] + F[2].at[i], high = F[1].at[i] + F[3].at[i];
    sum[0][0].at[i] += low;
    sum[0][1].at[i] += high;
    sum[1][0].at[i] += F[0].at[i] + F[1].at[i];
    sum[1][1].at[i] += F[2].at[i] + F[3].at[i];
    sum[2][z].at[i] = low + high;
    Pack volumes{};
#pragma GCC unroll 4
    for (int k = 0; k < 4; ++k) {
      const Pack w = i == 2 ? part(k, 2).at[i] + all(box.leg[2].area) : part(k, 2).at[i];
      volumes += q[k] * w;
    }
    star.f[2][z].at[i] = -volumes;
  }
}

template <bool whole, bool bounded>
PHYMUL_INLINE void all_octants(StarWork& star, const simd::BoxShape& box, Ints octants) {
  Lean lean;
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    ByAxis of[2];
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; ++axis) {
      of[0].at[axis] = -(all(box.share_lambda[axis]) * star.a[axis][0].at[i]);
      of[1].at[axis] = all(box.share_lambda[axis]) * star.a[axis][1].at[i];
    }
    lean.z[0].at[i] = of[0].at[2];
    lean.z[1].at[i] = of[1].at[2];
#pragma GCC unroll 4
    for (int k = 0; k < 4; ++k) lean.xy[k].at[i] = of[k & 1].at[0] + of[k >> 1].at[1];
  }
  ByAxis sum[3][2]{};
  octants_of<whole, bounded, 0>(star, box, octants, lean, sum);
  octants_of<whole, bounded, 1>(star, box, octants, lean, sum);
#pragma GCC unroll 3
  for (int axis = 0; axis < 3; ++axis) {
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
      const Pack low = all(box.lambda[axis]) * sum[axis][0].at[i], high = all(box.lambda[axis]) * sum[axis][1].at[i];
      star.f[axis][0].at[i] = axis == 2 ? star.f[2][0].at[i] - low : -low;
      star.f[axis][1].at[i] = axis == 2 ? star.f[2][1].at[i] + high : high;
    }
  }
}

/// Forces of a star on its spokes, from `a` and `edge`; `longest` is the sum of squared spokes' displacements.
template <bool whole, bool bounded>
PHYMUL_INLINE void star_forces(StarWork& star, const simd::BoxShape& box, Ints octants, Pack longest) {
  // Beyond, a base may be collapsed though its |w| is not small.
  star.floor = select(longest < all(box.tame), all(flat), all(3.4028234e38f));
  normals<0>(star, box);
  normals<1>(star, box);
  normals<2>(star, box);
  all_octants<whole, bounded>(star, box, octants);
  across<whole, 0>(star, box, octants);
  across<whole, 1>(star, box, octants);
  across<whole, 2>(star, box, octants);
}

/// Forces of a box's mean deformation on its corners are +- x +- y +- z, + on the corner's low sides.
struct BoxForces {
  Pack3 x, y, z;
};

/// From the sums of the four differences along the edges of each axis.
template <bool bounded>
PHYMUL_INLINE BoxForces box_forces(const Pack3& along_x, const Pack3& along_y, const Pack3& along_z,
                                   const simd::BoxShape& box) {
  const Columns H{all(box.gradient[0]) * along_x, all(box.gradient[1]) * along_y, all(box.gradient[2]) * along_z};
  const Columns P = cell_stress<bounded>(H, all(box.shape_stiffness), all(box.volume_stiffness));
  return {all(box.gradient[0]) * P.c0, all(box.gradient[1]) * P.c1, all(box.gradient[2]) * P.c2};
}

}  // namespace phymul::cpu::PHYMUL_ISA
