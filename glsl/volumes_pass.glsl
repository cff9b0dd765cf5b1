// SPDX-License-Identifier: MIT
//
// Per volume row (2-D: area), the forces on its vertices, a layer each. With ENERGY its energy, J, in place of them.
// Needs displacement.glsl and delta_volume.glsl.

uniform isampler2D volume;  // a, b, c, d
uniform int volume_log2;
uniform sampler2D volume_e1;  // X_b - X_a, 1 / (6 V) (2-D: 1 / (2 A))
uniform int volume_e1_log2;
uniform sampler2D volume_e2;  // X_c - X_a, stiffness
uniform int volume_e2_log2;
uniform sampler2D volume_e3;  // X_d - X_a
uniform int volume_e3_log2;

#ifdef ENERGY
layout(location = 0) out vec4 energy;
invariant energy;
#else
layout(location = 0) out vec4 on_a;
invariant on_a;
layout(location = 1) out vec4 on_b;
invariant on_b;
layout(location = 2) out vec4 on_c;
invariant on_c;
layout(location = 3) out vec4 on_d;
invariant on_d;
#endif

void main() {
  int row = own_row();
  if (row >= row_count) discard;
  ivec4 vertex = fetch(volume, volume_log2, row);
  vec4 e1 = fetch(volume_e1, volume_e1_log2, row);
  vec4 e2 = fetch(volume_e2, volume_e2_log2, row);
  vec3 u_a = displaced(vertex.x);
  vec3 d1 = displaced(vertex.y) - u_a;
  vec3 d2 = displaced(vertex.z) - u_a;
#if DIMENSION == 3
  vec3 E3 = fetch(volume_e3, volume_e3_log2, row).xyz;
  vec3 d3 = displaced(vertex.w) - u_a;
#endif
#ifdef ENERGY
#if DIMENSION == 2
  float change = triangle_change(e1.xyz, e2.xyz, d1, d2, e1.w);
#else
  float change = tetrahedron_change(e1.xyz, e2.xyz, E3, d1, d2, d3, e1.w);
#endif
  energy = vec4(e2.w * volume_energy_density(change), 0.0, 0.0, 0.0);
#else
  vec3 a, b, c, d;
#if DIMENSION == 2
  triangle_area_forces(e1.xyz, e2.xyz, d1, d2, e1.w, e2.w, a, b, c);
  d = vec3(0.0);
#else
  tetrahedron_volume_forces(e1.xyz, e2.xyz, E3, d1, d2, d3, e1.w, e2.w, a, b, c, d);
#endif
  on_a = vec4(a, 0.0);
  on_b = vec4(b, 0.0);
  on_c = vec4(c, 0.0);
  on_d = vec4(d, 0.0);
#endif
}
