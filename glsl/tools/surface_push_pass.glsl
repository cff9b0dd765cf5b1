// SPDX-License-Identifier: MIT
//
// Per particle of a surface, what a round gave it, added up over its patches. Needs surface_tables.glsl,
// pushed_tables.glsl and touch_tools.glsl.

RESULT(0, vec4, end_now);
RESULT(1, vec4, way_now);
RESULT(2, vec4, given_now);
RESULT(3, vec4, shift_now);

void push_row(int i) {
  end_now = fetch_load_vec4(corner_end, corner_end_place, i);
  way_now = fetch_load_vec4(corner_way, corner_way_place, i);
  given_now = fetch_load_vec4(corner_given, corner_given_place, i);
  shift_now = fetch_load_vec4(corner_shift, corner_shift_place, i);
  if (!(end_now.w > 0.0) || !(way_now.w > 0.0)) return;
  ivec4 around = fetch_load_ivec4(patch_ranges, patch_ranges_place, i);
  vec3 impulse = vec3(0.0);
  vec3 shift = vec3(0.0);
  for (int row = around.x; row < around.y; ++row) {
    ivec4 at = fetch_load_ivec4(patch_around, patch_around_place, row);
    impulse = impulse + fetch_load_layer(patch_push, patch_push_place, at.x, at.y).xyz;
    if (round_shifts != 0) {
      shift = shift + fetch_load_layer(patch_push, patch_push_place, patch_count + at.x, at.y).xyz;
    }
  }
  ToolFrame end = tool_frame(acting_tool, instant + 1);
  int axes = int(fetch_load_vec4(free_velocity, free_velocity_place, i).w);
  vec3 taken = free_part(turned(end, impulse), axes);
  vec3 by = free_part(turned(end, end_now.w * shift), axes);
  vec3 moved = inside(end, (dt * end_now.w) * taken + by);
  end_now = vec4(end_now.xyz + moved, end_now.w);
  way_now = vec4(way_now.xyz + moved, way_now.w);
  given_now = vec4(given_now.xyz + taken, 0.0);
  shift_now = vec4(shift_now.xyz + by, 0.0);
}

PASS_MAIN(push_row)
