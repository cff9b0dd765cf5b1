// SPDX-License-Identifier: MIT
//
// The list of a new node, behind those that are there. Drawn only, over all lists; needs needle_weights_of.glsl.

RESULT(0, ivec2, list_row);

ivec2 entry_of_list(int j) {
  mat4 lower;
  cholesky(total_moments(), lower);
  vec4 missing = missing_of(lower);
  vec4 b = basis_of(j, 1.0 / reach);
  float inside = inside_of(b);
  // Coefficients are rounded more coarsely than this, where all particles lie to one side.
  float weight = inside * inside * dot(fetch_changing(weight_solutions, weight_solutions_place, 0), b);
  weight = weight + inside * inside * dot(missing, b);
  return ivec2(fetch_int(particles_found, particles_found_place, j), floatBitsToInt(weight));
}

// Fragments beside each other do the same until the end: softpipe gives numbers that are none where some of four branch off.
void append_row(int row) {
  if (int(state_row(1).w) == done) discard;
  begin_needle();
  int j = row - node_count * most_around;
  bool is_new = j >= 0 && makes_node() && j < total_found();
  list_row = entry_of_list(is_new ? j : 0);
  if (!is_new) discard;
}

PASS_MAIN(append_row)
