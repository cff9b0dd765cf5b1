// SPDX-License-Identifier: MIT
//
// A shaft that bends: all nodes onto it at once, in a fragment that goes through all of them. Twin of
// NeedlePath::hold_on_bent of src/cpu. Needs needle_held.glsl and needle_sweeps.glsl.

STORED(needle_inverse, needle_inverse_place);  // needle_invert_pass.glsl

vec3 held_off[MOST_NODES];

vec2 inverse_at(int row, int column) {
  return fetch_vec2(needle_inverse, needle_inverse_place, row * longest + column);
}

void find_held() {
  choose_held(0);
  if (!(inverse_at(0, 0).x > 0.0)) held_count = 0;  // there was none
}

vec3 change_of(int row) {
  vec2 x = vec2(0.0);
  vec2 y = vec2(0.0);
  vec2 z = vec2(0.0);
  for (int k = 0; k < held_count; ++k) {
    vec2 entry = inverse_at(row, k);
    vec3 off = held_off[k];
    x = sum_of(x, product_of(entry, vec2(off.x, 0.0)));
    y = sum_of(y, product_of(entry, vec2(off.y, 0.0)));
    z = sum_of(z, product_of(entry, vec2(off.z, 0.0)));
  }
  return vec3(x.x, y.x, z.x);
}

// Where the step ends, the shaft is bent by what it holds the tissue with.
void hold_on_bent() {
  for (int row = 0; row < held_count; ++row) {
    int node = held_node[row];
    vec3 off = across(node_place[node].xyz - gone + dt * node_motion[node].xyz);
    for (int k = 0; k < held_count; ++k) {
      off = off + (inverse_dt * shaft_compliance(held_arm[row], held_arm[k])) * node_side[held_node[k]].xyz;
    }
    held_off[row] = off;
  }
  for (int row = 0; row < held_count; ++row) {
    int node = held_node[row];
    vec3 side = node_side[node].xyz;
    vec3 wanted = side - change_of(row);
    float most = is_last(node) ? surface_friction * pushed : 0.0;
    float size = sqrt(inner_product(wanted, wanted));
    if (!punctured && size > most) wanted = wanted * (most / size);
    node_side[node].xyz = wanted;
    push_nodes(node, wanted - side);
  }
}
