// SPDX-License-Identifier: MIT
//
// The volumes that a scene keeps, as in src/device/float_scene.h, and what passes write of them. Needs tables.glsl.

TABLE_FLOATS(kept_laws, kept_laws_place);    // two rows a volume: unit (m), 1 / unit, mean mass / 6 (kg);
                                             // over unit^3: what it lacks at rest, what it may lack
TABLE_INTS(kept_ranges, kept_ranges_place);  // per particle: first and end row of kept_around, its volume or -1
TABLE_INTS(kept_around, kept_around_place);  // facets at a particle: corners a, b, c, row
TABLE_INTS(kept_facets, kept_facets_place);  // a, b, c, and o, from where places of the volume are seen
TABLE_FLOATS(kept_edges, kept_edges_place);  // three rows a facet, over the unit: X_a - X_o, X_b - X_a, X_c - X_a
TABLE_INTS(kept_nodes, kept_nodes_place);    // per sum: first and end of what it adds, its volume

STORED(kept_along, kept_along_place);  // per particle: which way it goes, of no unit
STORED(kept_sums, kept_sums_place);    // per sum: 6 dV, 6 c1, 6 c2, 6 c3, over unit^3
STORED(kept_roots, kept_roots_place);  // per volume: how far along, m; first step of the batch that lost it

vec4 kept_law(int volume, int row) {
  return fetch_load_vec4(kept_laws, kept_laws_place, 2 * volume + row);
}
