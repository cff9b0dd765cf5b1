// SPDX-License-Identifier: MIT
//
// Everything that pulls at one particle, in a fixed order: its own attractor or bases, what reactions give back,
// volumes, cells, springs, loads. Needs displacement.glsl; delta_spring.glsl where SPRINGS is defined;
// integrate_displacement.glsl where CUT is.

uniform sampler2D particle;  // 1/m, k_i, m
uniform int particle_log2;
uniform isampler2D lists;  // first rows of: reaction or share, volume entries, cell entries, springs
uniform int lists_log2;
uniform isampler2D entries;  // reaction, volume entries, cell entries, spring ends, one after another
uniform int entries_log2;
uniform int volume_start, cell_start, spring_start;

#ifdef ATTRACTORS
uniform sampler2D force;  // F_i
uniform int force_log2;
#endif
#ifdef SHARES
uniform isampler2D share;  // owner j, bits of the share of -F_j
uniform int share_log2;
#endif
#ifdef BASE_TERMS
uniform isampler2D index;  // Nc, X, Bc, X'
uniform int index_log2;
uniform sampler2DArray base_terms;  // on a, b, c, owner
uniform int base_terms_log2;
#endif
#ifdef VOLUMES
uniform sampler2DArray volume_terms;  // on a, b, c, d
uniform int volume_terms_log2;
#endif
#ifdef CELLS
uniform sampler2DArray cell_terms;  // columns of the stress
uniform int cell_terms_log2;
uniform sampler2D cell_gradient;
uniform int cell_gradient_log2;
#endif
#ifdef SPRINGS
uniform sampler2D spring;  // X_other - X_i, stiffness
uniform int spring_log2;
#endif
#if defined(FORCES) || defined(FIXED)
uniform isampler2D load_index;  // first and end row of force parts, first row of target parts, their number * 8 + fixed
uniform int load_index_log2;
uniform sampler2D load_parts;  // vector, number of the value it is multiplied by
uniform int load_parts_log2;
uniform sampler2D load_values;  // a row of load_count values per instant
uniform int load_values_log2;
uniform int load_count;
#endif
#ifdef CUT
uniform float largest_acceleration;  // m/s^2: elastic force over mass is cut to it
#endif
uniform int instant;  // whose values act on the step: of its old time; the next are of its new time

vec3 own_force(int i) {
  vec3 F = vec3(0.0);
#ifdef ATTRACTORS
  F = fetch(force, force_log2, i).xyz;
#endif
#ifdef CONSERVATIVE
  ivec4 at = fetch(index, index_log2, i);
  for (int t = at.w; t < at.w + at.z; ++t) F = F + fetch(base_terms, base_terms_log2, t, 3).xyz;
#endif
  return F;
}

vec3 elastic_force(int i) {
  ivec4 first = fetch(lists, lists_log2, i);
  ivec4 end = fetch(lists, lists_log2, i + 1);
  vec3 F = own_force(i);
#ifdef SHARES
  for (int row = first.x; row < end.x; ++row) {
    ivec4 given = fetch(share, share_log2, row);
    F = F - intBitsToFloat(given.y) * fetch(force, force_log2, given.x).xyz;
  }
#endif
#ifdef BASE_TERMS
  for (int row = first.x; row < end.x; ++row) {
    int entry = fetch(entries, entries_log2, row).x;
    F = F + fetch(base_terms, base_terms_log2, entry >> 2, entry & 3).xyz;
  }
#endif
#ifdef VOLUMES
  for (int row = first.y; row < end.y; ++row) {
    int entry = fetch(entries, entries_log2, volume_start + row).x;
    F = F + fetch(volume_terms, volume_terms_log2, entry >> 2, entry & 3).xyz;
  }
#endif
#ifdef CELLS
  for (int row = first.z; row < end.z; ++row) {
    int entry = fetch(entries, entries_log2, cell_start + row).x;
    int cell = entry >> 3;
    vec3 g = fetch(cell_gradient, cell_gradient_log2, entry).xyz;
    F = F - (g.x * fetch(cell_terms, cell_terms_log2, cell, 0).xyz + g.y * fetch(cell_terms, cell_terms_log2, cell, 1).xyz +
             g.z * fetch(cell_terms, cell_terms_log2, cell, 2).xyz);
  }
#endif
#ifdef SPRINGS
  vec3 u_i = displaced(i);
  for (int row = first.w; row < end.w; ++row) {
    int other = fetch(entries, entries_log2, spring_start + row).x;
    vec4 pull = fetch(spring, spring_log2, row);
    F = F + spring_force(pull.xyz, displaced(other) - u_i, pull.w);
  }
#endif
  return F;
}

#if defined(FORCES) || defined(FIXED)
// Sum of value * vector over rows of parts, with the values of an instant.
vec3 load_sum(int first, int end, int at) {
  vec3 sum = vec3(0.0);
  for (int row = first; row < end; ++row) {
    vec4 part = fetch(load_parts, load_parts_log2, row);
    sum = sum + fetch(load_values, load_values_log2, at * load_count + int(part.w)).x * part.xyz;
  }
  return sum;
}
#endif

// w: 1 where the elastic part was cut.
vec4 net_force(int i) {
  vec3 F = elastic_force(i);
  float was_cut = 0.0;
#ifdef CUT
  float largest = fetch(particle, particle_log2, i).z * largest_acceleration;
  was_cut = inner_product(F, F) > largest * largest ? 1.0 : 0.0;
  F = cut_force(F, largest);
#endif
#ifdef FORCES
  ivec4 rows = fetch(load_index, load_index_log2, i);
  F = F + load_sum(rows.x, rows.y, instant);
#endif
  return vec4(F, was_cut);
}

// Bit k set: coordinate k is imposed.
int fixed_axes(int i) {
#ifdef FIXED
  return fetch(load_index, load_index_log2, i).w & 7;
#else
  return 0;
#endif
}

vec3 free_part(vec3 vector, int fixed_at) {
  return vec3((fixed_at & 1) != 0 ? 0.0 : vector.x, (fixed_at & 2) != 0 ? 0.0 : vector.y,
              (fixed_at & 4) != 0 ? 0.0 : vector.z);
}
