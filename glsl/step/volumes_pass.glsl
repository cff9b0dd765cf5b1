// SPDX-License-Identifier: MIT
//
// Per volume row (2-D: area), the forces on its vertices. Needs tables.glsl and volume.glsl.

RESULT(0, vec4, volume_on_a);
RESULT(1, vec4, volume_on_b);
RESULT(2, vec4, volume_on_c);
RESULT(3, vec4, volume_on_d);

void volume_row(int row) {
  ivec4 vertex = fetch_ivec4(volume, volume_place, row);
  vec4 e1 = fetch_vec4(volume_e1, volume_e1_place, row);
  vec4 e2 = fetch_vec4(volume_e2, volume_e2_place, row);
  vec3 u_a = displaced(vertex.x);
  vec3 d1 = displaced(vertex.y) - u_a;
  vec3 d2 = displaced(vertex.z) - u_a;
#if DIMENSION == 3
  vec3 E3 = fetch_vec4(volume_e3, volume_e3_place, row).xyz;
  vec3 d3 = displaced(vertex.w) - u_a;
#endif
  vec3 a, b, c, d;
#if DIMENSION == 2
  triangle_area_forces(e1.xyz, e2.xyz, d1, d2, e1.w, e2.w, a, b, c);
  d = vec3(0.0);
#else
  tetrahedron_volume_forces(e1.xyz, e2.xyz, E3, d1, d2, d3, e1.w, e2.w, a, b, c, d);
#endif
  volume_on_a = vec4(a, 0.0);
  volume_on_b = vec4(b, 0.0);
  volume_on_c = vec4(c, 0.0);
  volume_on_d = vec4(d, 0.0);
}

PASS_MAIN(volume_row)
