// SPDX-License-Identifier: MIT
//
// What bases, volumes and domains give, as their passes wrote it. Needs tables.glsl.

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
