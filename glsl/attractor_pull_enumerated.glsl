// SPDX-License-Identifier: MIT
//
// P*_i - x_i as in attractor_pull.glsl, without a bases table: every triple j < k < l of the neighbour rows is a base,
// in the order in which three loops count them, and only w_t beta_t is stored, four a texel; 0 where the triple is no
// base. Needs displacement.glsl and delta_base.glsl.

uniform isampler2D index;  // Nc, X, Bc, X'
uniform int index_log2;
uniform isampler2D neighbours;
uniform int neighbours_log2;
uniform sampler2D edge_alpha;  // X_j - X_i, alpha_ij
uniform int edge_alpha_log2;
uniform isampler2D first_height;
uniform int first_height_log2;
uniform sampler2D height;
uniform int height_log2;
uniform float area_exponent;

vec3 neighbour_displaced(int r) {
  return displaced(fetch(neighbours, neighbours_log2, r).x);
}

vec3 attractor_pull(int i, vec3 u_i) {
  ivec4 at = fetch(index, index_log2, i);
  if (at.z == 0) return vec3(0.0);
  int end = at.y + at.x;
  vec3 pull = vec3(0.0);
  for (int r = at.y; r < end; ++r) {
    pull = pull + fetch(edge_alpha, edge_alpha_log2, r).w * (neighbour_displaced(r) - u_i);
  }
  int texel = fetch(first_height, first_height_log2, i).x;
  int lane = 0;
  vec4 heights = vec4(0.0);
  for (int j = at.y; j < end - 2; ++j) {
    vec3 u_j = neighbour_displaced(j);
    vec3 X_j = fetch(edge_alpha, edge_alpha_log2, j).xyz;
    for (int k = j + 1; k < end - 1; ++k) {
      vec3 d1 = neighbour_displaced(k) - u_j;
      vec3 E1 = fetch(edge_alpha, edge_alpha_log2, k).xyz - X_j;
      for (int l = k + 1; l < end; ++l) {
        if (lane == 0) heights = fetch(height, height_log2, texel);
        float weighted = lane == 0 ? heights.x : lane == 1 ? heights.y : lane == 2 ? heights.z : heights.w;
        texel += lane == 3 ? 1 : 0;
        lane = (lane + 1) & 3;
        if (weighted == 0.0) continue;
        vec3 E2 = fetch(edge_alpha, edge_alpha_log2, l).xyz - X_j;
        vec3 d2 = neighbour_displaced(l) - u_j;
        pull = pull + weighted * delta_base_3d(E1, E2, d1, d2, area_exponent).change;
      }
    }
  }
  return pull;
}
