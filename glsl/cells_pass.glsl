// SPDX-License-Identifier: MIT
//
// Per cell row, the first Piola stress of its mean deformation times its volume, J: a column a layer. With ENERGY the
// cell's energy, J, in place of it. Needs displacement.glsl and delta_cell.glsl.

uniform isampler2D cell_vertex;  // two rows a cell: corners 0-3, 4-7
uniform int cell_vertex_log2;
uniform sampler2D cell_gradient;  // eight rows a cell
uniform int cell_gradient_log2;
uniform sampler2D cell_stiffness;  // shape, volume
uniform int cell_stiffness_log2;

#ifdef ENERGY
layout(location = 0) out vec4 energy;
invariant energy;
#else
layout(location = 0) out vec4 column_0;
invariant column_0;
layout(location = 1) out vec4 column_1;
invariant column_1;
layout(location = 2) out vec4 column_2;
invariant column_2;
#endif

void main() {
  int row = own_row();
  if (row >= row_count) discard;
  ivec4 near = fetch(cell_vertex, cell_vertex_log2, 2 * row);
  ivec4 far = fetch(cell_vertex, cell_vertex_log2, 2 * row + 1);
  vec3 u_0 = displaced(near.x);
  // H = F - 1. Differences to the first corner: the gradients sum to zero.
  Columns H = Columns(vec3(0.0), vec3(0.0), vec3(0.0));
  for (int corner = 1; corner < 8; ++corner) {
    ivec4 half_of = corner < 4 ? near : far;
    int lane = corner & 3;
    int v = lane == 0 ? half_of.x : lane == 1 ? half_of.y : lane == 2 ? half_of.z : half_of.w;
    if (v < 0) break;
    add_outer(H, displaced(v) - u_0, fetch(cell_gradient, cell_gradient_log2, 8 * row + corner).xyz);
  }
  vec2 stiffness = fetch(cell_stiffness, cell_stiffness_log2, row).xy;
#ifdef ENERGY
  energy = vec4(cell_energy(H, stiffness.x, stiffness.y), 0.0, 0.0, 0.0);
#else
  Columns P = cell_stress(H, stiffness.x, stiffness.y);
  column_0 = vec4(P.c0, 0.0);
  column_1 = vec4(P.c1, 0.0);
  column_2 = vec4(P.c2, 0.0);
#endif
}
