// SPDX-License-Identifier: MIT
//
// Sums over the facets of kept volumes, up to sixteen terms to one: of facets (FACETS), then of sums. Places are those at
// the step's end. Needs kept_facet.glsl.

uniform int kept_first_node;    // of what is drawn
uniform int kept_first_source;  // of the sums that it adds

RESULT(0, vec4, kept_sum);

vec4 facet_row(int row, float inverse_unit) {
  ivec4 at = fetch_load_ivec4(kept_facets, kept_facets_place, row);
  vec3 u_a = displaced(at.x);
  vec3 da = inverse_unit * (u_a - displaced(at.w));
  vec3 de = inverse_unit * (displaced(at.y) - u_a);
  vec3 df = inverse_unit * (displaced(at.z) - u_a);
  KeptFacet facet = KeptFacet(kept_edge(row, 0), kept_edge(row, 1), kept_edge(row, 2), da, de, df);
  vec3 p = fetch_load_vec4(kept_along, kept_along_place, at.x).xyz;
  vec3 q = fetch_load_vec4(kept_along, kept_along_place, at.y).xyz - p;
  vec3 r = fetch_load_vec4(kept_along, kept_along_place, at.z).xyz - p;
  return facet_volume(facet, p, q, r);
}

void facets_row(int row) {
  ivec4 node = fetch_load_ivec4(kept_nodes, kept_nodes_place, kept_first_node + row);
  float inverse_unit = kept_law(node.z, 0).y;
  kept_sum = vec4(0.0);
  for (int facet = node.x; facet < node.y; ++facet) kept_sum = kept_sum + facet_row(facet, inverse_unit);
}

void sums_row(int row) {
  ivec4 node = fetch_load_ivec4(kept_nodes, kept_nodes_place, kept_first_node + row);
  kept_sum = vec4(0.0);
  for (int source = node.x; source < node.y; ++source) {
    kept_sum = kept_sum + fetch_load_vec4(kept_sums, kept_sums_place, source - kept_first_source);
  }
}

#ifdef FACETS
PASS_MAIN(facets_row)
#else
PASS_MAIN(sums_row)
#endif
