// SPDX-License-Identifier: MIT
//
// StrainEnergy::fibres at F = I + H, of mu, K, k and the direction a: neo-Hookean, and k/8 (|F a|^2 - 1)^2, where
// |F a|^2 - 1 = 2 a . H a + |H a|^2. Needs columns.glsl, volume.glsl, neo_hookean.glsl.

KERNEL_CONSTANT int energy_constants = 6;

KERNEL real fibre_strain(real3 a, real3 stretched) {
  return literal(2.0f) * inner_product(a, stretched) + inner_product(stretched, stretched);
}

KERNEL Columns energy_stress(Columns H, real p[energy_constants]) {
  real3 a = real3(p[3], p[4], p[5]);
  real3 stretched = times(H, a);
  real tension = literal(0.5f) * p[2] * fibre_strain(a, stretched);
  return plus_outer(neo_hookean_stress(H, change_of(H), p[0], p[1]), tension * (a + stretched), a);
}

// In place of squared_condition: along the fibres the slope of their force grows by (3 |F a|^2 - 1) / 2.
KERNEL real energy_condition(Columns H, real p[energy_constants]) {
  real3 a = real3(p[3], p[4], p[5]);
  real along = literal(1.0f) + literal(1.5f) * fibre_strain(a, times(H, a));
  real condition = squared_condition(H, change_of(H));
  return select(along > literal(1.0f), along * condition, condition);
}
