// SPDX-License-Identifier: MIT
//
// Lines between particles: links, edges of faces. Or from each particle to its attractor, where there are no pairs.
uniform highp isampler2D pairs;
uniform int pairs_log2;
uniform bool paired;                          // false: line i goes from particle i to where second_displacement says
uniform highp sampler2D second_displacement;  // of the attractors
uniform int second_displacement_log2;

void main() {
  int line = gl_VertexID / 6;
  ivec2 ends = paired ? texelFetch(pairs, texel(line, pairs_log2), 0).xy : ivec2(line);
  vec3 second = rest_place(ends.y);
  second += paired ? moved_by(ends.y) : texelFetch(second_displacement, texel(line, second_displacement_log2), 0).xyz;
  share = displacement_scale * 0.5 * (length(moved_by(ends.x)) + length(moved_by(ends.y)));
  draw_line(seen(rest_place(ends.x) + moved_by(ends.x)), seen(second), gl_VertexID % 6);
}
