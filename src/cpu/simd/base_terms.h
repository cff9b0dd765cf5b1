// SPDX-License-Identifier: MIT
//
// Bases, a slice of particles at a time. glsl/kernels/base.glsl has the formulas; here with
//   a = |w|^2 / |w0|^2,  y = a - 1 (from dw, not from a),  c = 1 / sqrt(a) - 1
//   n - n0 = (dw + c w) / |w0|,   1 / |w| = (1 + c) / |w0|
// A collapsed base has c = -1: no normal, n - n0 = -n0.
#pragma once

#include "job.h"
#include "pack_rows.h"

namespace phymul::cpu::PHYMUL_ISA {

/// See turned_base() there.
inline constexpr float collapsed = 1e-12f;

struct BaseRow {
  Pack3 E1, E2;
  Pack lambda_b, lambda_c, height, rest, share;  // height: beta / |w0|; rest: 1 / |w0|^2
};

PHYMUL_INLINE BaseRow load_base(const float* row) {
  return {load3(row + 3 * lanes), load3(row + 6 * lanes), load(row + 9 * lanes), load(row + 10 * lanes),
          load(row + 11 * lanes), load(row + 12 * lanes), load(row + 13 * lanes)};
}

struct BaseNow {
  Pack3 d1, d2, e1, e2, w;
  Pack3 change;  // |w0| (n - n0)
  Pack rho;      // |w0| / |w|
};

template <bool plane>
PHYMUL_INLINE BaseNow base_now(const BaseRow& row, Pack3 ua, Pack3 ub, Pack3 uc) {
  BaseNow now;
  now.d1 = ub - ua;
  now.e1 = row.E1 + now.d1;
  Pack3 dw;
  Pack edges;
  if constexpr (plane) {
    now.d2 = now.e2 = Pack3{};
    dw = {-now.d1.y, now.d1.x, Pack{}};
    now.w = {-now.e1.y, now.e1.x, Pack{}};
    edges = Pack{};
  } else {
    now.d2 = uc - ua;
    now.e2 = row.E2 + now.d2;
    dw = cross(now.d1, now.e2) + cross(row.E1, now.d2);
    now.w = cross(now.e1, now.e2);
    edges = collapsed * dot(now.e1, now.e1) * dot(now.e2, now.e2);
  }
  const Pack q = dot(now.w, now.w);
  const Pack y = dot(dw, all(2.0f) * now.w - dw) * row.rest;
  const Pack a = q * row.rest;
  const Pack c = select(q > edges, inverse_root_change(a, y), all(-1.0f));
  now.rho = c + 1.0f;
  now.change = dw + c * now.w;
  return now;
}

PHYMUL_INLINE Pack3 height_slope(const BaseNow& now, const BaseRow& row, Pack3 F) {
  const Pack along = row.rest * now.rho * now.rho * dot(now.w, F);
  return (row.height * now.rho) * (F - along * now.w);
}

/// Gives what the owner's force F costs the base to its vertices.
template <bool plane>
PHYMUL_INLINE void give_back(const BaseNow& now, const BaseRow& row, Pack3 F, const std::int32_t* offset, char* force) {
  const Pack3 G = height_slope(now, row, F);
  if constexpr (plane) {
    const Pack3 on_b = -(row.lambda_b * F) - Pack3{G.y, -G.x, Pack{}};
    scatter_add(force, offset, -(F + on_b));
    scatter_add(force, offset + lanes, on_b);
  } else {
    const Pack3 on_b = -(row.lambda_b * F) - cross(now.e2, G), on_c = -(row.lambda_c * F) - cross(G, now.e1);
    scatter_add(force, offset, -(F + on_b + on_c));
    scatter_add(force, offset + lanes, on_b);
    scatter_add(force, offset + 2 * lanes, on_c);
  }
}

template <simd::BaseUse use, bool plane>
void base_slices(const simd::Job& job) {
  for (int slice = 0; slice < job.bases.count; ++slice) {
    const int first = job.bases.first[slice], last = job.bases.first[slice + 1];
    const Pack3 ui = gather_row(job.u + 16 * lanes * slice);
    const auto row_at = [&](int r) {
      return job.bases.rows + static_cast<std::int64_t>(r) * simd::base_columns * lanes;
    };
    Pack3 sum{};
    const auto now_of = [&](const float* row, const BaseRow& base, std::int32_t* offset, Pack3& ua) PHYMUL_INLINED {
      PHYMUL_COPY(offset, row, 3 * sizeof(Pack));
      ua = gather(job.u, offset);
      const Pack3 ub = gather(job.u, offset + lanes);
      const Pack3 uc = plane ? Pack3{} : gather(job.u, offset + 2 * lanes);
      return base_now<plane>(base, ua, ub, uc);
    };
    for (int r = first; r < last; ++r) {
      std::int32_t offset[3 * lanes];
      Pack3 ua;
      if (job.rows_far) prefetch_rows<simd::base_columns>(row_at(r));
      const BaseRow base = load_base(row_at(r));
      const BaseNow now = now_of(row_at(r), base, offset, ua);
      Pack3 pull = (ua - ui) + base.lambda_b * now.d1 + base.height * now.change;
      if constexpr (!plane) pull += base.lambda_c * now.d2;
      if constexpr (use == simd::BaseUse::conservative) {
        const Pack3 F = base.share * pull;
        sum += F;
        give_back<plane>(now, base, F, offset, job.force);
      } else {
        sum += base.share * pull;
      }
    }
    if constexpr (use == simd::BaseUse::conservative) {
      add_row(job.force + 16 * lanes * slice, sum);
      continue;
    }
    const Pack3 F = load(job.stiffness + slice * lanes) * sum;
    if constexpr (use == simd::BaseUse::attractor) {
      store_row(job.pull + 16 * lanes * slice, F);
      continue;
    }
    add_row(job.force + 16 * lanes * slice, F);
    for (int r = first; r < last; ++r) {
      std::int32_t offset[3 * lanes];
      Pack3 ua;
      const BaseRow base = load_base(row_at(r));
      const BaseNow now = now_of(row_at(r), base, offset, ua);
      give_back<plane>(now, base, base.share * F, offset, job.force);
    }
  }
}

}  // namespace phymul::cpu::PHYMUL_ISA
