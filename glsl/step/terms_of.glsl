// SPDX-License-Identifier: MIT
//
// What bases, volumes and cells give: as their passes wrote it, or with RECOMPUTE computed where it is asked for, which
// needs those passes' files. Needs tables.glsl.

#ifdef BASE_TERMS
// Force on corner a, b, c or owner (0 to 3) of base t.
vec3 base_term(int t, int corner) {
#ifdef RECOMPUTE
  base_row(t);
#ifndef AVERAGED
  if (corner == 3) return base_on_owner.xyz;
#endif
  return corner == 0 ? base_on_a.xyz : corner == 1 ? base_on_b.xyz : base_on_c.xyz;
#else
  return fetch_layer(base_terms, base_terms_place, t, corner).xyz;
#endif
}
#endif

#ifdef VOLUMES
vec3 volume_term(int row, int corner) {
#ifdef RECOMPUTE
  volume_row(row);
  return corner == 0 ? volume_on_a.xyz : corner == 1 ? volume_on_b.xyz : corner == 2 ? volume_on_c.xyz : volume_on_d.xyz;
#else
  return fetch_layer(volume_terms, volume_terms_place, row, corner).xyz;
#endif
}
#endif

#ifdef CELLS
// The stress of a cell times a corner's gradient.
vec3 cell_term(int cell, vec3 g) {
#ifdef RECOMPUTE
  cell_row(cell);
  vec3 c0 = cell_column_0.xyz;
  vec3 c1 = cell_column_1.xyz;
  vec3 c2 = cell_column_2.xyz;
#else
  vec3 c0 = fetch_layer(cell_terms, cell_terms_place, cell, 0).xyz;
  vec3 c1 = fetch_layer(cell_terms, cell_terms_place, cell, 1).xyz;
  vec3 c2 = fetch_layer(cell_terms, cell_terms_place, cell, 2).xyz;
#endif
  return g.x * c0 + g.y * c1 + g.z * c2;
}
#endif
