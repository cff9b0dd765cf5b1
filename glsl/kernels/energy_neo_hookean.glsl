// SPDX-License-Identifier: MIT
//
// StrainEnergy::neo_hookean at F = I + H, of mu and K. Needs columns.glsl, volume.glsl, neo_hookean.glsl.

KERNEL_CONSTANT int energy_constants = 2;

KERNEL Columns energy_stress(Columns H, real p[energy_constants]) {
  return neo_hookean_stress(H, change_of(H), p[0], p[1]);
}
