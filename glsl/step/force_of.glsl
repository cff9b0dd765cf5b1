// SPDX-License-Identifier: MIT
//
// F_i, N: as the attractor pass wrote it, or with RECOMPUTE_FORCES computed where it is asked for, which needs
// attractor_pass.glsl.

vec3 force_of(int i) {
#ifdef RECOMPUTE_FORCES
  attractor_row(i);
  return attractor_result.xyz;
#else
  return fetch_changing(force, force_place, i).xyz;
#endif
}
