// SPDX-License-Identifier: MIT
//
// A needle's state as a step ends: which nodes slid, what bends the shaft, and what the hub felt, the sum over the steps
// of a batch and the last of them: force and torque about it, N and N m; w of the last force: particles that it touched.
// Drawn only; needs needle_motion.glsl.

STORED(needle_impulses, needle_impulses_place);
STORED(needle_hubs, needle_hubs_place);
STORED(needle_node_ends, needle_node_ends_place);
STORED(needle_twist_pushes, needle_twist_pushes_place);
STORED(needle_twists, needle_twists_place);
STORED(settled_sides, settled_sides_place);

RESULT(0, vec4, next_state);

vec4 felt(bool turning) {
  vec4 sum = vec4(0.0);
  for (int k = 0; k < node_count; ++k) {
    vec4 hub = fetch_changing(needle_hubs, needle_hubs_place, k);
    vec3 reaction = -inverse_dt * fetch_changing(needle_impulses, needle_impulses_place, k).xyz;
    if (turning) {
      sum.xyz += cross_product(hub.xyz, reaction);
      if (turned != 0.0) sum.xyz -= inverse_dt * fetch_changing(needle_twists, needle_twists_place, k).xyz;
    } else {
      if (turned != 0.0) sum.xyz -= inverse_dt * fetch_changing(needle_twist_pushes, needle_twist_pushes_place, k).xyz;
      sum += vec4(hub.w * reaction, fetch_changing(needle_node_ends, needle_node_ends_place, k).z);
    }
  }
  return sum;
}

#ifdef BENDING
// What bends the shaft, in the tool's frame at the step's end.
void find_loads(int row) {
  shaft_loads = 0;
  for (int k = 0; k < node_count && bending_stiffness > 0.0; ++k) {
    vec4 end = fetch_changing(needle_node_ends, needle_node_ends_place, k);
    if (!(end.w > 0.0)) continue;
    ++shaft_loads;
    if (row != load_row(int(end.w) - 1)) continue;
    vec3 load = -inverse_dt * fetch_changing(settled_sides, settled_sides_place, k).xyz;
    next_state = vec4(end.x, inner_product(frame_row(number, 0).xyz, load), inner_product(frame_row(number, 1).xyz, load),
                      0.0);
  }
}
#endif

void end_row(int row) {
  begin_needle();
  begin_motion();
  next_state = state_row(row);
#ifdef BENDING
  find_loads(row);
#endif
  if (row < header_rows) {
    next_state = header_row(row);
  } else if (row < header_rows + hub_rows) {
    int kind = row - header_rows;  // sum of forces, of torques; last force, torque
    vec4 now = felt((kind & 1) != 0);
    if (kind >= 2) {
      next_state = now;
    } else {
      next_state = vec4(number > 1 ? next_state.xyz + now.xyz : now.xyz, 0.0);
    }
  } else if (row < node_row(node_count)) {
    next_state.y = fetch_changing(needle_node_ends, needle_node_ends_place, row - node_row(0)).y;
  }
}

PASS_MAIN(end_row)
