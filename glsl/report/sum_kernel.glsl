// SPDX-License-Identifier: MIT
//
// Sums over rows, two rows a group: of energies (ENERGY_OF_PARTICLES, ENERGY_OF_VOLUMES,
// ENERGY_OF_DOMAINS) or of MOMENTA, linear and angular. Needs the pass that has the row.

layout(local_size_x = GROUP) in;

uniform int pair, source_count, partial_place;
uniform int gravity_place;

shared vec4 group_first[GROUP];
shared vec4 group_second[GROUP];

void add_row(int row, inout vec4 first, inout vec4 second) {
#ifdef MOMENTA
  momentum_row(row);
  first += linear;
  second += angular;
#else
#if defined(ENERGY_OF_PARTICLES)
  energy_row(row);
#elif defined(ENERGY_OF_VOLUMES)
  volume_row(row);
#else
  if (fetch_ivec4(domain_range, domain_range_place, row).x < 0) return;  // fills up a slice
  domain_row(row);
#endif
  first += energy;
#endif
}

void main() {
  displacement_place = pair_place(pair);
  velocity_place = displacement_place + place_count;
#ifdef ENERGY_OF_PARTICLES
  instant = 0;
  gravity = fetch_load_vec4(gravity, gravity_place, 0).xyz;
#endif
  int lane = int(gl_LocalInvocationID.x);
  vec4 first = vec4(0.0);
  vec4 second = vec4(0.0);
  int stride = int(gl_NumWorkGroups.x) * GROUP;
  for (int row = int(gl_WorkGroupID.x) * GROUP + lane; row < source_count; row += stride) add_row(row, first, second);
  group_first[lane] = first;
  group_second[lane] = second;
  for (int half_of = GROUP / 2; half_of > 0; half_of /= 2) {
    memoryBarrierShared();
    barrier();
    if (lane < half_of) {
      group_first[lane] += group_first[lane + half_of];
      group_second[lane] += group_second[lane + half_of];
    }
  }
  if (lane > 0) return;
  changing_rows[partial_place + 2 * int(gl_WorkGroupID.x)] = floatBitsToInt(group_first[0]);
  changing_rows[partial_place + 2 * int(gl_WorkGroupID.x) + 1] = floatBitsToInt(group_second[0]);
}
