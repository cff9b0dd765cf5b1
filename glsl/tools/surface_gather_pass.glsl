// SPDX-License-Identifier: MIT
//
// Per particle of a surface, its state before the first round: the loads of its patches are added up. Needs
// surface_tables.glsl.

RESULT(0, vec4, end_now);
RESULT(1, vec4, way_now);
RESULT(2, vec4, given_now);
RESULT(3, vec4, shift_now);

void gather_row(int i) {
  ivec4 around = fetch_load_ivec4(patch_ranges, patch_ranges_place, i);
  float load = 0.0;
  for (int row = around.x; row < around.y; ++row) {
    ivec4 at = fetch_load_ivec4(patch_around, patch_around_place, row);
    vec4 loads = fetch_load_vec4(patch_load, patch_load_place, at.x);
    load = load + (at.y == 0 ? loads.x : at.y == 1 ? loads.y : loads.z);
  }
  end_now = fetch_load_vec4(first_end, first_end_place, i);
  way_now = vec4(fetch_load_vec4(first_way, first_way_place, i).xyz, load);
  given_now = vec4(0.0);
  shift_now = vec4(0.0);
}

PASS_MAIN(gather_row)
