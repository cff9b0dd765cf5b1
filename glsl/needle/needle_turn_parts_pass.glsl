// SPDX-License-Identifier: MIT
//
// Sums over the particles of a node, sixteen for each (TEAM), where a shaft turns: which way it pushes them, their moment
// of inertia about it, and the moment of that push. Drawn only; needs needle_turning.glsl.

RESULT(0, vec4, push_part);    // m; m^2
RESULT(1, vec4, moment_part);  // m^2

void turn_parts_row(int row) {
  begin_needle();
  begin_motion();
  int k = row / TEAM;
  if (k >= node_count) discard;
  push_part = vec4(0.0);
  moment_part = vec4(0.0);
  int end = around(k);
  for (int j = row - k * TEAM; j < end; j += TEAM) {
    ivec2 entry = list_entry(k, j);
    float weight = intBitsToFloat(entry.y);
    vec3 place = place_of(entry.x) - gone;
    vec3 arm = across(place);
    push_part.w += weight * inner_product(arm, arm);
    if (is_held(entry.x)) continue;
    vec3 way = turning_of(entry.x);
    push_part.xyz += weight * way;
    moment_part.xyz += weight * cross_product(place, way);
  }
}

PASS_MAIN(turn_parts_row)
