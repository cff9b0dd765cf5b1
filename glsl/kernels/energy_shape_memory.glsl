// SPDX-License-Identifier: MIT
//
// StrainEnergy::shape_memory at F = I + H, of c and kappa. Needs columns.glsl, volume.glsl, shape_memory.glsl.

KERNEL_CONSTANT int energy_constants = 2;

KERNEL Columns energy_stress(Columns H, real p[energy_constants]) {
  Change change = change_of(H);
  return plus(shape_stress(H, change, p[0]), volume_stress(change, p[1]));
}
