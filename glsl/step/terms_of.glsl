// SPDX-License-Identifier: MIT
//
// What bases, volumes and cells give, as their passes wrote it. Needs tables.glsl.

#ifdef BASE_TERMS
// Force on corner a, b, c or owner (0 to 3) of base t.
vec3 base_term(int t, int corner) {
  return fetch_layer(base_terms, base_terms_place, t, corner).xyz;
}
#endif

#ifdef VOLUMES
vec3 volume_term(int row, int corner) {
  return fetch_layer(volume_terms, volume_terms_place, row, corner).xyz;
}
#endif

#ifdef CELLS
// The stress of a cell times a corner's gradient.
vec3 cell_term(int cell, vec3 g) {
  vec3 c0 = fetch_layer(cell_terms, cell_terms_place, cell, 0).xyz;
  vec3 c1 = fetch_layer(cell_terms, cell_terms_place, cell, 1).xyz;
  vec3 c2 = fetch_layer(cell_terms, cell_terms_place, cell, 2).xyz;
  return g.x * c0 + g.y * c1 + g.z * c2;
}
#endif
