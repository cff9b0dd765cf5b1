// SPDX-License-Identifier: MIT
//
// One round of refining a node's weights: coefficients, and sums over up to 32 particles. Drawn only; needs
// needle_weights_of.glsl.

RESULT(0, vec4, sums_row);
RESULT(1, vec4, solution_row);

void weights_row(int row) {
  begin_needle();
  if (!makes_node() || row * branch >= total_found()) discard;
  mat4 lower;
  cholesky(total_moments(), lower);
#ifdef FIRST
  solution_row = solved(lower, vec4(1.0, 0.0, 0.0, 0.0));
#else
  solution_row = fetch_changing(weight_solutions, weight_solutions_place, 0) + missing_of(lower);
#endif
  vec4 coefficients = solution_row;
  vec4 sum = vec4(0.0);
  float inverse_reach = 1.0 / reach;
  int end = min(branch * (row + 1), total_found());
  for (int j = branch * row; j < end; ++j) {
    vec4 b = basis_of(j, inverse_reach);
    float inside = inside_of(b);
    float weight = inside * inside * dot(coefficients, b);
    sum += weight * b;
  }
  sums_row = sum;
}

PASS_MAIN(weights_row)
