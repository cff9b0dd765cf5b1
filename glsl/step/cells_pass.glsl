// SPDX-License-Identifier: MIT
//
// Per cell row, the first Piola stress of its mean deformation times its volume, J, by columns. With ENERGY the cell's
// energy, J, in place of it. Needs tables.glsl and delta_cell.glsl.

#ifdef ENERGY
RESULT(0, vec4, energy);
#else
RESULT(0, vec4, cell_column_0);
RESULT(1, vec4, cell_column_1);
RESULT(2, vec4, cell_column_2);
#endif

void cell_row(int row) {
  ivec4 near = fetch_ivec4(cell_vertex, cell_vertex_place, 2 * row);
  ivec4 far = fetch_ivec4(cell_vertex, cell_vertex_place, 2 * row + 1);
  vec3 u_0 = displaced(near.x);
  // H = F - 1. Differences to the first corner: the gradients sum to zero.
  Columns H = Columns(vec3(0.0), vec3(0.0), vec3(0.0));
  for (int corner = 1; corner < 8; ++corner) {
    ivec4 half_of = corner < 4 ? near : far;
    int lane = corner & 3;
    int v = lane == 0 ? half_of.x : lane == 1 ? half_of.y : lane == 2 ? half_of.z : half_of.w;
    if (v < 0) break;
    add_outer(H, displaced(v) - u_0, fetch_vec4(cell_gradient, cell_gradient_place, 8 * row + corner).xyz);
  }
  vec2 stiffness = fetch_vec2(cell_stiffness, cell_stiffness_place, row);
#ifdef ENERGY
  energy = vec4(cell_energy(H, stiffness.x, stiffness.y), 0.0, 0.0, 0.0);
#else
  Columns P = cell_stress(H, stiffness.x, stiffness.y);
  cell_column_0 = vec4(P.c0, 0.0);
  cell_column_1 = vec4(P.c1, 0.0);
  cell_column_2 = vec4(P.c2, 0.0);
#endif
}

PASS_MAIN(cell_row)
