// SPDX-License-Identifier: MIT
//
// What bases, volumes, walls and domains give, as their passes wrote it. Needs tables.glsl.

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

#ifdef WALLS
// Force on vertex 0 to 5 of a triangle's patch, from what walls_pass.glsl packed; that on vertex 0 balances the others.
vec3 wall_term(int row, int vertex) {
  if (vertex >= 1 && vertex <= 4) return fetch_layer(wall_terms, wall_terms_place, row, vertex - 1).xyz;
  vec4 t1 = fetch_layer(wall_terms, wall_terms_place, row, 0);
  vec4 t2 = fetch_layer(wall_terms, wall_terms_place, row, 1);
  vec4 t3 = fetch_layer(wall_terms, wall_terms_place, row, 2);
  vec3 on_5 = vec3(t1.w, t2.w, t3.w);
  if (vertex == 5) return on_5;
  vec3 sum = t1.xyz + t2.xyz;  // in one expression Mesa would add pairs
  sum = sum + t3.xyz;
  sum = sum + fetch_layer(wall_terms, wall_terms_place, row, 3).xyz;
  return -(sum + on_5);
}
#endif

#ifdef DOMAINS
// The force of a domain on its particle; next: that particle's next domain, or none.
vec3 domain_force(int d, out int next) {
  ivec4 rows = fetch_ivec4(domain_range, domain_range_place, d);
  next = rows.w;
  vec3 F = vec3(fetch_layer(domain_terms, domain_terms_place, d, 0).w,
                fetch_layer(domain_terms, domain_terms_place, d, 1).w,
                fetch_layer(domain_terms, domain_terms_place, d, 2).w);
  for (int row = rows.x; row < rows.z; row += ROW_STRIDE) {
    int e = fetch_int(link_domain, link_domain_place, row);
    vec3 area = fetch_vec4(link, link_place, row).xyz;
    vec3 g = row < rows.y ? area : -area;
    vec3 c0 = fetch_layer(domain_terms, domain_terms_place, e, 0).xyz;
    vec3 c1 = fetch_layer(domain_terms, domain_terms_place, e, 1).xyz;
    vec3 c2 = fetch_layer(domain_terms, domain_terms_place, e, 2).xyz;
    F = F + (g.x * c0 + g.y * c1 + g.z * c2);
  }
  return F;
}
#endif
