// SPDX-License-Identifier: MIT
//
// What holds a node on the shaft, where that bends: an impulse sideways, N s. Drawn only, a row for each node; needs
// needle_held_rows.glsl, and two_floats.glsl.

STORED(settled_sides, settled_sides_place);    // needle_settle_pass.glsl
STORED(settled_motions, settled_motions_place);
STORED(needle_impulses, needle_impulses_place);  // m: how far nodes are off the shaft

RESULT(0, vec4, hold_row);

vec3 change_of(int row) {
  vec2 x = vec2(0.0);
  vec2 y = vec2(0.0);
  vec2 z = vec2(0.0);
  for (int k = 0; k < held_count; ++k) {
    vec2 entry = pair_at(row, k);
    vec3 off = fetch_changing(needle_impulses, needle_impulses_place, held_node[k]).xyz;
    x = sum_of(x, product_of(entry, vec2(off.x, 0.0)));
    y = sum_of(y, product_of(entry, vec2(off.y, 0.0)));
    z = sum_of(z, product_of(entry, vec2(off.z, 0.0)));
  }
  return vec3(x.x, y.x, z.x);
}

void hold_node_row(int k) {
  begin_needle();
  if (k >= node_count) discard;
  read_held();
  vec3 side = fetch_changing(settled_sides, settled_sides_place, k).xyz;
  vec3 wanted = side;
  for (int row = 0; row < held_count; ++row) {
    if (held_node[row] == k) wanted = side - change_of(row);
  }
  float pushed = is_last(k) ? fetch_changing(settled_motions, settled_motions_place, k).w : 0.0;
  float most = surface_friction * pushed;
  float size = sqrt(inner_product(wanted, wanted));
  if (!punctured && size > most) wanted = wanted * (most / size);
  hold_row = vec4(wanted, 0.0);
}

PASS_MAIN(hold_node_row)
