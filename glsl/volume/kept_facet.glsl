// SPDX-License-Identifier: MIT
//
// Twin of tests/mirror/mirror_scene.cpp: a facet of a closed surface, seen from a particle o of it, over the unit of the volume.
// What it encloses is a difference from rest, as forces are. Needs kept_tables.glsl.

struct KeptFacet {
  vec3 a, e, f;        // at rest: from o to a, from a to b, from a to c
  vec3 da, de, df;     // what they have gained
};

vec3 kept_edge(int facet, int row) {
  return fetch_load_vec4(kept_edges, kept_edges_place, 3 * facet + row).xyz;
}

// Twice its area, outward.
vec3 facet_area(KeptFacet facet) {
  return cross_product(facet.e + facet.de, facet.f + facet.df);
}

// Six times what the tetrahedron o, a, b, c has gained, and its c1, c2, c3 along p at a, q more at b, r more at c.
vec4 facet_volume(KeptFacet facet, vec3 p, vec3 q, vec3 r) {
  vec3 a = facet.a + facet.da;
  vec3 e = facet.e + facet.de;
  vec3 f = facet.f + facet.df;
  vec3 area = cross_product(e, f);
  vec3 area_gained = cross_product(facet.de, f) + cross_product(facet.e, facet.df);
  vec3 first = cross_product(q, f) + cross_product(e, r);
  vec3 second = cross_product(q, r);
  return vec4(inner_product(facet.da, area) + inner_product(facet.a, area_gained),
              inner_product(p, area) + inner_product(a, first), inner_product(p, first) + inner_product(a, second),
              inner_product(p, second));
}
