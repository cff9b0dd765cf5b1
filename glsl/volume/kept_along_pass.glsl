// SPDX-License-Identifier: MIT
//
// Per particle, which way it goes to bring its volume back: the gradient of the volume at the step's start over the
// mass, in coordinates that nothing holds. No tool holds anything here: then volumes are kept on the host. Needs
// net_force.glsl and kept_facet.glsl.

RESULT(0, vec4, kept_direction);

void along_row(int i) {
  kept_direction = vec4(0.0);
  ivec4 around = fetch_load_ivec4(kept_ranges, kept_ranges_place, i);
  if (around.z < 0) return;
  vec4 law = kept_law(around.z, 0);
  vec3 area = vec3(0.0);
  for (int row = around.x; row < around.y; ++row) {
    ivec4 at = fetch_load_ivec4(kept_around, kept_around_place, row);
    vec3 u_a = displaced(at.x);
    vec3 de = law.y * (displaced(at.y) - u_a);
    vec3 df = law.y * (displaced(at.z) - u_a);
    area = area + facet_area(KeptFacet(vec3(0.0), kept_edge(at.w, 1), kept_edge(at.w, 2), vec3(0.0), de, df));
  }
  float share = law.z * fetch_vec4(particle, particle_place, i).x;
  kept_direction = vec4(free_part(share * area, fixed_axes(i)), 0.0);
}

PASS_MAIN(along_row)
