// SPDX-License-Identifier: MIT
//
// A shaft that bends: all nodes onto it at once, between the draws of needle_settle_pass.glsl. Twin of
// NeedlePath::hold_on_bent of src/cpu. Needs needle_held.glsl and needle_sweeps.glsl.

STORED(needle_holds, needle_holds_place);  // needle_hold_pass.glsl

// m, by which node k, where the step ends, is off the shaft as it is bent by what it holds the tissue with; 0 where it
// is not held.
vec3 off_shaft(int k) {
  vec3 off = across(node_place[k].xyz - gone + dt * node_motion[k].xyz);
  float arm = shaft_arm(node_place[k].w);
  bool is_one = false;
  for (int row = 0; row < held_count; ++row) {
    is_one = is_one || held_node[row] == k;
    off = off + (inverse_dt * shaft_compliance(arm, held_arm[row])) * node_side[held_node[row]].xyz;
  }
  return is_one ? off : vec3(0.0);
}

void take_holds() {
  for (int row = 0; row < held_count; ++row) {
    int node = held_node[row];
    vec3 wanted = fetch_changing(needle_holds, needle_holds_place, node).xyz;
    vec3 impulse = wanted - node_side[node].xyz;
    node_side[node].xyz = wanted;
    push_nodes(node, impulse);
  }
}
