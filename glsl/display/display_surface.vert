// SPDX-License-Identifier: MIT
//
// Outer faces, six vertices each: triangles 0 1 2 and 0 2 3 of the ring. All vertices of a face compute its normal from
// all its corners, so a bent quad is lit as one face.
uniform highp isampler2D faces;  // a, b, c, d; d is -1 in a triangle
uniform int faces_log2;

flat out vec3 normal;
out vec3 point;
out float share;

void main() {
  ivec4 ring = texelFetch(faces, texel(gl_VertexID / 6, faces_log2), 0);
  int corner = gl_VertexID % 6;
  corner = corner < 3 ? corner : corner == 3 ? 0 : corner - 2;
  bool triangle = ring.w < 0;
  if (triangle) ring.w = ring.x;  // the second triangle has no area then
  int i = ring[corner];

  vec3 a = seen(rest_place(ring.x) + moved_by(ring.x));
  vec3 b = seen(rest_place(ring.y) + moved_by(ring.y));
  vec3 c = seen(rest_place(ring.z) + moved_by(ring.z));
  vec3 d = seen(rest_place(ring.w) + moved_by(ring.w));
  vec3 area = triangle ? cross(b - a, c - a) : cross(c - a, d - b);
  float size = length(area);
  normal = size > 0.0 ? area / size : vec3(0.0, 0.0, 1.0);
  point = corner == 0 ? a : corner == 1 ? b : corner == 2 ? c : d;
  share = displacement_scale * length(moved_by(i));
  gl_Position = projection * vec4(point, 1.0);
}
