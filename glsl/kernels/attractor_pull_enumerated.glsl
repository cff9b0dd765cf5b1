// SPDX-License-Identifier: MIT
//
// P*_i - x_i as in attractor_pull.glsl, without a bases table: every triple j < k < l of the neighbour rows is a base,
// in the order in which three loops count them, and only w_t beta_t is stored, four a row; 0 where the triple is no
// base. Needs tables.glsl and base.glsl.

vec3 neighbour_displaced(int r) {
  return displaced(fetch_int(neighbours, neighbours_place, r));
}

vec3 neighbour_edge(int r) {
  return fetch_vec4(edge_alpha, edge_alpha_place, r).xyz;
}

vec3 attractor_pull(int i, vec3 u_i) {
  ivec2 own = base_rows(i);
  if (own.x == own.y) return vec3(0.0);
  ivec2 near = neighbour_rows(i);
  vec3 pull = vec3(0.0);
  for (int r = near.x; r < near.y; r += ROW_STRIDE) {
    pull = pull + fetch_vec4(edge_alpha, edge_alpha_place, r).w * (neighbour_displaced(r) - u_i);
  }
  int row = height_row(i);
  int lane = 0;
  vec4 heights = vec4(0.0);
  for (int j = near.x; j < near.y - 2 * ROW_STRIDE; j += ROW_STRIDE) {
    vec3 u_j = neighbour_displaced(j);
    vec3 X_j = neighbour_edge(j);
    for (int k = j + ROW_STRIDE; k < near.y - ROW_STRIDE; k += ROW_STRIDE) {
      vec3 d1 = neighbour_displaced(k) - u_j;
      vec3 E1 = neighbour_edge(k) - X_j;
      for (int l = k + ROW_STRIDE; l < near.y; l += ROW_STRIDE) {
        if (lane == 0) heights = fetch_vec4(height, height_place, row);
        float weighted = lane == 0 ? heights.x : lane == 1 ? heights.y : lane == 2 ? heights.z : heights.w;
        row += lane == 3 ? ROW_STRIDE : 0;
        lane = (lane + 1) & 3;
        if (weighted == 0.0) continue;
        vec3 E2 = neighbour_edge(l) - X_j;
        vec3 d2 = neighbour_displaced(l) - u_j;
        pull = pull + weighted * delta_base_3d(E1, E2, d1, d2).dn;
      }
    }
  }
  return pull;
}
