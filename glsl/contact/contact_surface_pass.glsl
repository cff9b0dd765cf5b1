// SPDX-License-Identifier: MIT
//
// Per particle of a surface, its displacement and where it would go. Needs pushed_tables.glsl and contact_surfaces.glsl.

CHANGING(displacement, displacement_place);

RESULT(0, vec4, moved);
RESULT(1, vec4, free);

void surface_row(int k) {
  int i = fetch_ivec4(surface, surface_place, k).x;
  moved = vec4(fetch_changing(displacement, displacement_place, i).xyz,
               fetch_load_vec4(pushed_shift, pushed_shift_place, i).w);
  free = fetch_load_vec4(free_velocity, free_velocity_place, i);
}

PASS_MAIN(surface_row)
