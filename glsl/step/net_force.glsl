// SPDX-License-Identifier: MIT
//
// Everything that pulls at one particle, in a fixed order: its own attractor or bases, what reactions give back,
// volumes, domains, springs, walls, loads, joints. Needs tables.glsl, terms_of.glsl; force_of.glsl where ATTRACTORS is
// defined; spring.glsl where SPRINGS is; integrate.glsl where CUT is.

#ifdef CUT
uniform float largest_acceleration;  // m/s^2: elastic force over mass is cut to it
#endif
OF_STEP(int, instant);  // whose values act on the step: of its old time; the next are of its new time

vec3 elastic_force(int i) {
  vec3 F = vec3(0.0);
#ifdef ATTRACTORS
  F = force_of(i);
#endif
#ifdef CONSERVATIVE
  ivec2 own = base_rows(i);
  for (int t = own.x; t < own.y; t += ROW_STRIDE) F = F + base_term(t, 3);
#endif
#ifdef SHARES
  ivec2 giving = reaction_rows(i);
  for (int row = giving.x; row < giving.y; row += ROW_STRIDE) {
    ivec2 given = fetch_ivec2(share, share_place, row);
    F = F - intBitsToFloat(given.y) * force_of(given.x);
  }
#endif
#ifdef BASE_TERMS
  ivec2 touching = reaction_rows(i);
  for (int row = touching.x; row < touching.y; row += ROW_STRIDE) {
    int entry = fetch_int(entries, entries_place, row);
    F = F + base_term(entry >> 2, entry & 3);
  }
#endif
#ifdef VOLUMES
  ivec2 volumes = volume_rows(i);
  for (int row = volumes.x; row < volumes.y; row += ROW_STRIDE) {
    int entry = fetch_int(entries, entries_place, volume_start + row);
    F = F + volume_term(entry >> 2, entry & 3);
  }
#endif
#ifdef DOMAINS
  int next;
  F = F + domain_force(i, next);
#ifdef SEVERAL_DOMAINS
  for (int d = next; d >= 0; d = next) F = F + domain_force(d, next);
#endif
#endif
#ifdef SPRINGS
  vec3 u_i = displaced(i);
  ivec2 springs = spring_rows(i);
  for (int row = springs.x; row < springs.y; row += ROW_STRIDE) {
    int other = fetch_int(entries, entries_place, spring_start + row);
    vec4 pull = fetch_vec4(spring, spring_place, row);
    F = F + spring_force(pull.xyz, displaced(other) - u_i, pull.w);
  }
#endif
#ifdef WALLS
  ivec2 walls = wall_rows(i);
  for (int row = walls.x; row < walls.y; row += ROW_STRIDE) {
    int entry = fetch_int(entries, entries_place, wall_start + row);
    F = F + wall_term(entry >> 3, entry & 7);
  }
#endif
  return F;
}

#if defined(FORCES) || defined(FIXED)
// Sum of value * vector over rows of parts, with the values of an instant.
vec3 load_sum(int first, int end, int at) {
  vec3 sum = vec3(0.0);
  for (int row = first; row < end; ++row) {
    vec4 part = fetch_load_vec4(load_parts, load_parts_place, row);
    sum = sum + fetch_load_float(load_values, load_values_place, at * load_count + int(part.w)) * part.xyz;
  }
  return sum;
}
#endif

vec3 withheld = vec3(0.0);  // N: what cut_elastic_force() took from the force

// w: 1 where it was cut.
vec4 cut_elastic_force(int i) {
  vec3 F = elastic_force(i);
#ifdef CUT
  float largest = fetch_vec4(particle, particle_place, i).z * largest_acceleration;
  vec3 left = cut_force(F, largest);
  withheld = F - left;
  return vec4(left, inner_product(F, F) > largest * largest ? 1.0 : 0.0);
#else
  return vec4(F, 0.0);
#endif
}

// w: 1 where the elastic part was cut.
vec4 net_force(int i) {
  vec4 elastic = cut_elastic_force(i);
  vec3 F = elastic.xyz;
#ifdef FORCES
  ivec4 rows = fetch_load_ivec4(load_index, load_index_place, i);
  F = F + load_sum(rows.x, rows.y, instant);
#endif
#ifdef JOINTS
  ivec4 joined = fetch_load_ivec4(joint_ranges, joint_ranges_place, i);
  for (int row = joined.x; row < joined.y; ++row) {
    ivec4 end = fetch_load_ivec4(joint_ends, joint_ends_place, row);
    F = F + intBitsToFloat(end.y) * fetch_load_layer(joint_state, joint_state_place, end.x, 0).xyz;
  }
#endif
  return vec4(F, elastic.w);
}

// Bit k set: coordinate k is imposed.
int fixed_axes(int i) {
#ifdef FIXED
  return fetch_load_ivec4(load_index, load_index_place, i).w & 7;
#else
  return 0;
#endif
}

vec3 free_part(vec3 vector, int fixed_at) {
  return vec3((fixed_at & 1) != 0 ? 0.0 : vector.x, (fixed_at & 2) != 0 ? 0.0 : vector.y,
              (fixed_at & 4) != 0 ? 0.0 : vector.z);
}
