// SPDX-License-Identifier: MIT
//
// Height scale of the area exponent for packs; delta_height.h has the formulas, with growth = y / 2.
#pragma once

#include "job.h"
#include "pack.h"

namespace phymul::cpu::PHYMUL_ISA {

struct Height {
  Pack excess, value, slope;  // g - 1, g, g'(s)
};

PHYMUL_INLINE Pack log_one_plus(Pack y) {
  const Pack a = y + 1.0f;
  const Ints e = ((Ints)a - 0x3f3504f3) >> 23;
  const Pack m = (Pack)((Ints)a - (e << 23));
  const Pack x = select(e == 0, y, m - 1.0f);
  const Pack t = x / (x + 2.0f);
  const Pack t2 = t * t;
  const Pack series = 0.6666667f + t2 * (0.4f + t2 * (0.28571429f + t2 * 0.22222222f));
  const Pack log_m = 2.0f * t + t * (t2 * series);
  const Pack exponent = __builtin_convertvector(e, Pack);
  return 0.693145751953125f * exponent + (log_m + 1.4286068203e-6f * exponent);
}

PHYMUL_INLINE Pack exp_minus_one(Pack z_in) {
  const Pack z = select(z_in < -80.0f, all(-80.0f), z_in);
  const Pack shifted = z * 1.442695f + 0.5f;
  Ints k = __builtin_convertvector(shifted, Ints);
  k += shifted < __builtin_convertvector(k, Pack);  // a mask is -1: truncation becomes floor
  const Pack whole = __builtin_convertvector(k, Pack);
  const Pack r = (z - whole * 0.693145751953125f) - whole * 1.4286068203e-6f;
  const Pack tail =
      0.5f + r * (0.16666667f + r * (0.041666668f + r * (0.008333334f + r * (0.0013888889f + r * 0.0001984127f))));
  const Pack small = r + (r * r) * tail;
  const Pack power = (Pack)((k + 127) << 23);
  return power * small + (power - 1.0f);
}

/// y = s^2 - 1.
PHYMUL_INLINE Height height_of(Pack y, Pack s, Pack p) {
  const Pack growth = 0.5f * y;
  const Pack excess = exp_minus_one(-p * log_one_plus(growth));
  const Pack value = excess + 1.0f;
  return {excess, value, -p * s * value / (growth + 1.0f)};
}

}  // namespace phymul::cpu::PHYMUL_ISA
