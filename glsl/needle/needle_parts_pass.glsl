// SPDX-License-Identifier: MIT
//
// Sums over the particles of a node, sixteen for each (TEAM): where it is, how it moves, and what of it the hub feels.
// Drawn only; needs needle_state.glsl and needle_motion.glsl.

uniform int only_new;  // 1: nodes that the step has made

RESULT(0, vec4, place_part);
RESULT(1, vec4, motion_part);
RESULT(2, vec4, hub_part);  // of particles that no tool holds: places, and how much of the node they are

void parts_row(int row) {
  begin_needle();
  begin_motion();
  int k = row / TEAM;
  if (k >= node_count || (only_new != 0 && k < known)) discard;
  place_part = vec4(0.0);
  motion_part = vec4(0.0);
  hub_part = vec4(0.0);
  int end = around(k);
  for (int j = row - k * TEAM; j < end; j += TEAM) {
    ivec2 entry = list_entry(k, j);
    float weight = intBitsToFloat(entry.y);
    vec3 place = place_of(entry.x);
    place_part += vec4(weight * place, 0.0);
    motion_part += vec4(weight * motion_of(entry.x), 0.0);
    if (!is_held(entry.x)) hub_part += weight * vec4(place - gone, 1.0);
  }
}

PASS_MAIN(parts_row)
