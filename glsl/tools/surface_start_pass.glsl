// SPDX-License-Identifier: MIT
//
// Per particle of a surface, where it would go by itself and by the tools before this one. Needs surface_tables.glsl,
// pushed_tables.glsl and touch_tools.glsl.

RESULT(0, vec4, end_before);
RESULT(1, vec4, way_before);

void start_row(int i) {
  ivec4 around = fetch_load_ivec4(patch_ranges, patch_ranges_place, i);
  end_before = vec4(0.0);
  way_before = vec4(0.0);
  if (around.x == around.y) return;
  vec4 v = fetch_load_vec4(free_velocity, free_velocity_place, i);
  TouchedParticle p = untouched(i, displaced(i), v.xyz, int(v.w));
  ToolFrame end = tool_frame(acting_tool, instant + 1);
  Passage own = passage(tool_frame(acting_tool, instant), end, tool_turn(acting_tool, instant), p, dt);
  vec3 shift = inside(end, fetch_load_vec4(pushed_shift, pushed_shift_place, i).xyz);
  end_before = vec4(own.end + shift, p.fixed_at == 7 ? 0.0 : p.inverse_mass);
  way_before = vec4(own.way + shift, 0.0);
}

PASS_MAIN(start_row)
