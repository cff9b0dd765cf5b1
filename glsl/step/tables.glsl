// SPDX-License-Identifier: MIT
//
// Every table of a body, as in src/device/float_tables.h; a pass pays only for those that it reads. Needs a dialect.

TABLE_FLOATS(particle, particle_place);          // 1/m, k_i, m
TABLE_INTS(neighbours, neighbours_place);        // j
TABLE_FLOATS(alpha, alpha_place);                // alpha_ij
TABLE_FLOATS(edge_alpha, edge_alpha_place);      // X_j - X_i, alpha_ij
TABLE_FLOATS(height, height_place);              // w_t beta_t of four triples
TABLE_INTS(bases, bases_place);                  // a, b, c, bits of beta
TABLE_FLOATS(base_e1, base_e1_place);            // X_b - X_a, lambda_b
TABLE_FLOATS(base_e2, base_e2_place);            // X_c - X_a, lambda_c
TABLE_INTS(base_share, base_share_place);        // owner, bits of k_i w_t (conservative) or of w_t (the others)
TABLE_INTS(share, share_place);                  // owner j, bits of the share of -F_j
TABLE_INTS(entries, entries_place);              // reaction, volume, spring ends, wall entries, one after another
TABLE_INTS(volume, volume_place);                // a, b, c, d
TABLE_FLOATS(volume_e1, volume_e1_place);        // X_b - X_a, 1 / (6 V) (2-D: 1 / (2 A))
TABLE_FLOATS(volume_e2, volume_e2_place);        // X_c - X_a, stiffness
TABLE_FLOATS(volume_e3, volume_e3_place);        // X_d - X_a
TABLE_FLOATS(spring, spring_place);              // X_other - X_i, stiffness
TABLE_INTS(domain_range, domain_range_place);    // first link, first surface link, end; next domain of its particle
TABLE_FLOATS(domain_law, domain_law_place);      // LAW_TEXELS a domain: 1/V, s mu, constants of the energy
TABLE_INTS(domain_owner, domain_owner_place);    // particle; only with SEVERAL_DOMAINS
TABLE_INTS(link_domain, link_domain_place);      // e
TABLE_FLOATS(link, link_place);                  // area, stiffness
TABLE_INTS(wall, wall_place);                    // two a triangle: vertices 0 to 3; 4, 5
TABLE_FLOATS(wall_law, wall_law_place);          // WALL_TEXELS a triangle: src/device/float_tables.h
uniform int volume_start, spring_start, wall_start;  // first rows of their entries

CHANGING(displacement, displacement_place);      // u_i = x_i - X_i, m
CHANGING(velocity, velocity_place);              // m/s
STORED(measured, measured_place);              // what step_pass.glsl tells
STORED(force, force_place);                    // F_i, N
STORED_LAYERS(base_terms, base_terms_place);   // forces on a, b, c, owner
STORED_LAYERS(volume_terms, volume_terms_place);  // forces on a, b, c, d
STORED_LAYERS(wall_terms, wall_terms_place);   // walls_pass.glsl
STORED_LAYERS(strains, strains_place);         // that domains keep: kept_strains.glsl; only with DISSIPATES
STORED(dissipation, dissipation_place);        // two texels a domain: 2 mu T, lambda T, 2 mu b, lambda b; share that decays
STORED_LAYERS(domain_terms, domain_terms_place);  // columns of the stress; w: the force of the spread

TABLE_INTS(load_index, load_index_place);    // first and end row of force parts, first row of target parts, their number * 8 + fixed
TABLE_FLOATS(load_parts, load_parts_place);  // vector, number of the value it is multiplied by
TABLE_FLOATS(load_values, load_values_place);  // a row of load_count values per instant
uniform int load_count;
TABLE_FLOATS(stiffness_factor, stiffness_factor_place);  // per domain; only with SCALED_STIFFNESS
TABLE_INTS(joint_ranges, joint_ranges_place);  // first row and end of joint_ends; only with JOINTS
TABLE_INTS(joint_ends, joint_ends_place);      // spring of a joint, bits of the share of its force
STORED_LAYERS(joint_state, joint_state_place);  // joint_law.glsl

// First row and end of what belongs to particle i.
#ifdef SLICED
TABLE_INTS(neighbour_ranges, neighbour_ranges_place);
TABLE_INTS(base_ranges, base_ranges_place);  // of `height` where ENUMERATED
TABLE_INTS(reaction_ranges, reaction_ranges_place);
TABLE_INTS(volume_ranges, volume_ranges_place);
TABLE_INTS(spring_ranges, spring_ranges_place);
TABLE_INTS(wall_ranges, wall_ranges_place);

ivec2 neighbour_rows(int i) {
  return fetch_ivec2(neighbour_ranges, neighbour_ranges_place, i);
}
ivec2 base_rows(int i) {
  return fetch_ivec2(base_ranges, base_ranges_place, i);
}
int height_row(int i) {
  return base_rows(i).x;
}
ivec2 reaction_rows(int i) {
  return fetch_ivec2(reaction_ranges, reaction_ranges_place, i);
}
ivec2 volume_rows(int i) {
  return fetch_ivec2(volume_ranges, volume_ranges_place, i);
}
ivec2 spring_rows(int i) {
  return fetch_ivec2(spring_ranges, spring_ranges_place, i);
}
ivec2 wall_rows(int i) {
  return fetch_ivec2(wall_ranges, wall_ranges_place, i);
}
#else
TABLE_INTS(index, index_place);  // Nc, X, Bc, X'
TABLE_INTS(lists, lists_place);  // first rows of: reaction or share, volume entries, springs, wall entries
TABLE_INTS(first_height, first_height_place);

ivec2 neighbour_rows(int i) {
  ivec4 at = fetch_ivec4(index, index_place, i);
  return ivec2(at.y, at.y + at.x);
}
ivec2 base_rows(int i) {
  ivec4 at = fetch_ivec4(index, index_place, i);
  return ivec2(at.w, at.w + at.z);
}
int height_row(int i) {
  return fetch_int(first_height, first_height_place, i);
}
ivec2 reaction_rows(int i) {
  return ivec2(fetch_ivec4(lists, lists_place, i).x, fetch_ivec4(lists, lists_place, i + 1).x);
}
ivec2 volume_rows(int i) {
  return ivec2(fetch_ivec4(lists, lists_place, i).y, fetch_ivec4(lists, lists_place, i + 1).y);
}
ivec2 spring_rows(int i) {
  return ivec2(fetch_ivec4(lists, lists_place, i).z, fetch_ivec4(lists, lists_place, i + 1).z);
}
ivec2 wall_rows(int i) {
  return ivec2(fetch_ivec4(lists, lists_place, i).w, fetch_ivec4(lists, lists_place, i + 1).w);
}
#endif

vec3 displaced(int i) {
  return fetch_changing(displacement, displacement_place, i).xyz;
}

// The particle of domain d.
int owner_of(int d) {
#ifdef SEVERAL_DOMAINS
  return fetch_int(domain_owner, domain_owner_place, d);
#else
  return d;
#endif
}
