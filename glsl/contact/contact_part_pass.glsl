// SPDX-License-Identifier: MIT
//
// What contacts come to, per particle: contact_part_kernel.glsl. Needs pushed_tables.glsl, contact_sweeps.glsl and
// contact_law.glsl.

TABLE_INTS(surface_rows, surface_rows_place);  // by particle: its row of `surface`, -1: none
TABLE_INTS(next_entries, next_entries_place);

RESULT(0, vec4, force_sum);
RESULT(1, vec4, shift_sum);

float ease_of(int k) {
  return fetch_changing(surface_moved, surface_moved_place, k).w;
}

float eased_at(int k, float share, vec3 normal) {
  return eased(fetch_changing(surface_velocity, surface_velocity_place, k).w, ease_of(k), share, normal);
}

// Of corner j of a contact (0: its particle), m.
vec3 parted(int m, int j, float own_ease) {
  vec4 nearest = fetch_changing(meeting_nearest, meeting_nearest_place, m);
  if (nearest.w >= 0.0) return vec3(0.0);
  ivec4 who = who_meet(m);
  vec4 normal = fetch_changing(meeting_normal, meeting_normal_place, m);
  float together = eased_at(who.x, 1.0, normal.xyz) + eased_at(who.y, nearest.x, normal.xyz) +
                   eased_at(who.z, nearest.y, normal.xyz) + eased_at(who.w, nearest.z, normal.xyz);
  if (together == 0.0) return vec3(0.0);
  float way = parting(nearest.w, normal.w, together);
  float share = j == 0 ? 1.0 : j == 1 ? -nearest.x : j == 2 ? -nearest.y : -nearest.z;
  return way * share * own_ease * normal.xyz;
}

void part_row(int i) {
  force_sum = fetch_load_vec4(pushed_force, pushed_force_place, i);
  shift_sum = fetch_load_vec4(pushed_shift, pushed_shift_place, i);
  int k = fetch_int(surface_rows, surface_rows_place, i);
  if (k < 0) return;
  int entry = fetch_ivec4(turns, turns_place, k).z;
  if (entry < 0) return;
  float ease = ease_of(k);
  vec3 shift = vec3(0.0);
  for (; entry >= 0; entry = fetch_int(next_entries, next_entries_place, entry)) {
    shift = shift + parted(entry >> 2, entry & 3, ease);
  }
  shift = open_axes(fetch_changing(surface_velocity, surface_velocity_place, k).w) * shift;
  vec3 push = inverse_dt * fetch_changing(pushing, pushing_place, k).xyz;
  force_sum = force_sum + vec4(push, 0.0);
  shift_sum = shift_sum + vec4(shift, 0.0);
}

PASS_MAIN(part_row)
