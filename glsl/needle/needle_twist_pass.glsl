// SPDX-License-Identifier: MIT
//
// How a shaft that turns twists the particles around each node: NeedlePath::twist of src/cpu. Drawn only, a row for each
// node; needs needle_limits.glsl.

STORED(push_parts, push_parts_place);  // needle_turn_parts_pass.glsl
STORED(moment_parts, moment_parts_place);

RESULT(0, vec4, twist_row);   // impulse on the tissue, N s; how much of the way that it pushes a particle, N s / m
RESULT(1, vec4, moment_row);  // its moment about the hub, N m s; what is left of the friction along the shaft

void twist_node_row(int own) {
  begin_needle();
  if (own >= node_count) discard;
  begin_motion();
  for (int k = 0; k < node_count; ++k) node_place[k] = fetch_changing(needle_places, needle_places_place, k);
  share_out_length();
  twist_row = vec4(0.0);
  moment_row = vec4(0.0, 0.0, 0.0, 1.0);
  if (!on_shaft(own) || node_limit[own] == 0.0) return;
  vec4 way = vec4(0.0);
  vec3 moment = vec3(0.0);
  for (int m = 0; m < TEAM; ++m) {
    way += fetch_changing(push_parts, push_parts_place, TEAM * own + m);
    moment += fetch_changing(moment_parts, moment_parts_place, TEAM * own + m).xyz;
  }
  float slide = slide_of(node_place[own].xyz, fetch_changing(needle_motions, needle_motions_place, own).xyz);
  float all = sqrt(slide * slide + turned * turned);
  if (way.w > 0.1 * needle_radius * needle_radius) {
    float torque = node_limit[own] * needle_radius * (turned / all) * (1.0 / way.w);
    twist_row = vec4(torque * way.xyz, torque);
    moment_row.xyz = torque * moment;
  }
  moment_row.w = abs(slide) / all;
}

PASS_MAIN(twist_node_row)
