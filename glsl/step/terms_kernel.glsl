// SPDX-License-Identifier: MIT
//
// One dispatch over the rows of all passes before the step that do not need each other, whole groups each. Needs
// tables.glsl and the passes asked for.

layout(local_size_x = GROUP) in;

uniform int pair;
uniform int attractor_groups, base_groups, volume_groups, wall_groups;  // the rest are of domains
uniform int base_rows_count, volume_count, wall_count, domain_count;

#ifdef ATTRACTOR_ROWS
void store_attractor(int i) {
  if (i >= particle_count) return;
  attractor_row(i);
  changing_rows[force_place + i] = floatBitsToInt(attractor_result);
}
#endif

#ifdef BASE_ROWS
void store_base(int t) {
  if (t >= base_rows_count || fetch_ivec4(bases, bases_place, t).x < 0) return;  // fills up a slice
  base_row(t);
  int at = base_terms_place + 4 * t;
  changing_rows[at] = floatBitsToInt(base_on_a);
  changing_rows[at + 1] = floatBitsToInt(base_on_b);
  changing_rows[at + 2] = floatBitsToInt(base_on_c);
#ifndef AVERAGED
  changing_rows[at + 3] = floatBitsToInt(base_on_owner);
#endif
}
#endif

#ifdef VOLUME_ROWS
void store_volume(int row) {
  if (row >= volume_count) return;
  volume_row(row);
  int at = volume_terms_place + 4 * row;
  changing_rows[at] = floatBitsToInt(volume_on_a);
  changing_rows[at + 1] = floatBitsToInt(volume_on_b);
  changing_rows[at + 2] = floatBitsToInt(volume_on_c);
  changing_rows[at + 3] = floatBitsToInt(volume_on_d);
}
#endif

#ifdef WALL_ROWS
void store_wall(int row) {
  if (row >= wall_count) return;
  wall_row(row);
  int at = wall_terms_place + 4 * row;
  changing_rows[at] = floatBitsToInt(wall_on_1);
  changing_rows[at + 1] = floatBitsToInt(wall_on_2);
  changing_rows[at + 2] = floatBitsToInt(wall_on_3);
  changing_rows[at + 3] = floatBitsToInt(wall_on_4);
}
#endif

#ifdef DOMAIN_ROWS
#ifdef DISSIPATES
uniform int next_strains_place;

void store_strains(int at) {
#ifdef STRAIN_RATE
  changing_rows[at] = floatBitsToInt(rate_normal);
  changing_rows[at + 1] = floatBitsToInt(rate_shear);
#endif
#ifdef STRAIN_BRANCH
  changing_rows[at + BRANCH_NORMAL] = floatBitsToInt(branch_normal);
  changing_rows[at + BRANCH_SHEAR] = floatBitsToInt(branch_shear);
#endif
}
#endif

void store_domain(int d) {
  if (d >= domain_count || fetch_ivec4(domain_range, domain_range_place, d).x < 0) return;  // fills up a slice
  domain_row(d);
  int at = domain_terms_place + 4 * d;
  changing_rows[at] = floatBitsToInt(domain_column_0);
  changing_rows[at + 1] = floatBitsToInt(domain_column_1);
  changing_rows[at + 2] = floatBitsToInt(domain_column_2);
#ifdef DISSIPATES
  store_strains(next_strains_place + 4 * d);
#endif
}
#endif

void main() {
  displacement_place = pair_place(pair);
  int row = own_group() * GROUP + int(gl_LocalInvocationID.x);
#ifdef ATTRACTOR_ROWS
  if (row < attractor_groups * GROUP) {
    store_attractor(row);
    return;
  }
  row -= attractor_groups * GROUP;
#endif
#ifdef BASE_ROWS
  if (row < base_groups * GROUP) {
    store_base(row);
    return;
  }
  row -= base_groups * GROUP;
#endif
#ifdef VOLUME_ROWS
  if (row < volume_groups * GROUP) {
    store_volume(row);
    return;
  }
  row -= volume_groups * GROUP;
#endif
#ifdef WALL_ROWS
  if (row < wall_groups * GROUP) {
    store_wall(row);
    return;
  }
  row -= wall_groups * GROUP;
#endif
#ifdef DOMAIN_ROWS
  store_domain(row);
#endif
}
