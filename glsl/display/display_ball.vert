// SPDX-License-Identifier: MIT
//
// Particles as balls: a square towards the eye each, on which the fragment shader draws half a sphere.
uniform highp isampler2D list;
uniform int list_log2;
uniform bool listed;     // false: all particles
uniform float radius;    // m

out vec2 disc;    // -1 ... 1
out vec3 centre;  // in the eye's axes, m
out float share;

void main() {
  int row = gl_VertexID / 6;
  int i = listed ? texelFetch(list, texel(row, list_log2), 0).x : row;
  int corner = gl_VertexID % 6;
  disc = vec2(corner == 1 || corner == 2 || corner == 4 ? 1.0 : -1.0,
              corner == 2 || corner == 4 || corner == 5 ? 1.0 : -1.0);
  centre = seen(rest_place(i) + moved_by(i));
  share = displacement_scale * length(moved_by(i));
  gl_Position = projection * vec4(centre + radius * vec3(disc, 0.0), 1.0);
}
