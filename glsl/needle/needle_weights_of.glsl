// SPDX-License-Identifier: MIT
//
// The weights of a node as they are refined: what both passes of it need. Needs needle_total.glsl.

TABLE_INTS(particles_found, particles_found_place);
STORED(weight_sums, weight_sums_place);          // of up to 32 particles: weight * basis
STORED(weight_solutions, weight_solutions_place);  // coefficients that those came from

bool makes_node() {
  return stage != done && total_found() <= most_around && node_count < longest && total_found() >= 4;
}

vec4 basis_of(int j, float inverse_reach) {
  return basis_at(fetch_int(particles_found, particles_found_place, j), aim, inverse_reach);
}

// What the weights' sums lack, as coefficients.
vec4 missing_of(mat4 lower) {
  vec4 sum = vec4(0.0);
  for (int part = 0; part * branch < total_found(); ++part) {
    sum += fetch_changing(weight_sums, weight_sums_place, part);
  }
  return solved(lower, vec4(1.0, 0.0, 0.0, 0.0) - sum);
}
