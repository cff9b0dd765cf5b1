// SPDX-License-Identifier: MIT
//
// The mean deformation of a domain of the particle-averaged law. Needs tables.glsl and columns.glsl.

// F - I. spread: the force of its spread on its particle, N.
Columns domain_gradient(int d, ivec4 rows, float inverse_volume, out vec3 spread) {
  vec3 u_d = displaced(owner_of(d));
  Columns H = Columns(vec3(0.0), vec3(0.0), vec3(0.0));
  spread = vec3(0.0);
  for (int row = rows.x; row < rows.z; row += ROW_STRIDE) {
    vec4 to_neighbour = fetch_vec4(link, link_place, row);
    vec3 apart = displaced(owner_of(fetch_int(link_domain, link_domain_place, row))) - u_d;
    H = plus_outer(H, apart, to_neighbour.xyz);
    spread = spread + to_neighbour.w * apart;
  }
  return scaled(inverse_volume, H);
}
