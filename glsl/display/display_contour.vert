// SPDX-License-Identifier: MIT
//
// The rest shape by its contour, edges between a face that looks at the eye and one that does not, and its sharp edges.
uniform highp isampler2D pairs;
uniform int pairs_log2;
uniform highp sampler2D normals;  // two texels a pair: of the faces that meet there; opposite ones at an open edge
uniform int normals_log2;
uniform vec4 eye;                 // place, w = 1; direction towards it, w = 0
uniform float sharp;              // cosine of the least angle between normals that shows

void main() {
  int line = gl_VertexID / 6;
  ivec2 ends = texelFetch(pairs, texel(line, pairs_log2), 0).xy;
  vec3 first = texelFetch(normals, texel(2 * line, normals_log2), 0).xyz;
  vec3 second = texelFetch(normals, texel(2 * line + 1, normals_log2), 0).xyz;
  vec3 a = rest_place(ends.x);
  vec3 b = rest_place(ends.y);
  vec3 towards = eye.xyz - eye.w * 0.5 * (a + b);
  bool contour = dot(first, towards) * dot(second, towards) <= 0.0;
  if (!contour && dot(first, second) > sharp) {
    draw_nothing();
    return;
  }
  share = 0.0;
  draw_line(seen(a), seen(b), gl_VertexID % 6);
}
