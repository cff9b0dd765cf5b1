// SPDX-License-Identifier: MIT
//
// Of what needle_parts_pass.glsl wrote, one row a node. Drawn only; needs needle_state.glsl.

STORED(place_parts, place_parts_place);
STORED(motion_parts, motion_parts_place);
STORED(hub_parts, hub_parts_place);
uniform int only_new;

RESULT(0, vec4, node_place_row);  // from the tip; along the axis
RESULT(1, vec4, node_motion_row);
RESULT(2, vec4, node_hub_row);

void means_row(int k) {
  begin_needle();
  if (k >= node_count || (only_new != 0 && k < known)) discard;
  vec4 place = fetch_changing(place_parts, place_parts_place, TEAM * k);
  vec4 motion = fetch_changing(motion_parts, motion_parts_place, TEAM * k);
  vec4 hub = fetch_changing(hub_parts, hub_parts_place, TEAM * k);
  for (int m = 1; m < TEAM; ++m) {
    place += fetch_changing(place_parts, place_parts_place, TEAM * k + m);
    motion += fetch_changing(motion_parts, motion_parts_place, TEAM * k + m);
    hub += fetch_changing(hub_parts, hub_parts_place, TEAM * k + m);
  }
  node_place_row = vec4(place.xyz, inner_product(axis, place.xyz));
  node_motion_row = motion;
  node_hub_row = hub;
}

PASS_MAIN(means_row)
