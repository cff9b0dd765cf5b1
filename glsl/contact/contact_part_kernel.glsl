// SPDX-License-Identifier: MIT
//
// What contacts come to, a lane for each particle of a surface: its impulses as a force over the step, and the little
// way by which overlaps part in a step (BodyContacts::part of src/interaction), gathered over its contacts in ascending order.
// Needs pushed_tables.glsl, contact_tables.glsl, kernel_language.glsl and contact_law.glsl.

layout(local_size_x = GROUP) in;

float eased_at(int k, float share, vec3 normal) {
  return eased(float_row(surface_velocity_place + k).w, float_row(surface_moved_place + k).w, share, normal);
}

float unbound_at(int k, float share) {
  return share * share * float_row(surface_moved_place + k).w;
}

// Of corner j of a contact (0: its particle), m.
vec3 parted(int at, int j, float own_ease) {
  vec4 nearest = float_row(at + 1);
  if (nearest.w >= 0.0) return vec3(0.0);
  ivec4 who = load_rows[at];
  vec4 normal = float_row(at + 2);
  float together = eased_at(who.x, 1.0, normal.xyz) + eased_at(who.y, nearest.x, normal.xyz) +
                   eased_at(who.z, nearest.y, normal.xyz) + eased_at(who.w, nearest.z, normal.xyz);
  float unbound = unbound_at(who.x, 1.0) + unbound_at(who.y, nearest.x) + unbound_at(who.z, nearest.y) +
                  unbound_at(who.w, nearest.z);
  if (together <= least_mobility * unbound) return vec3(0.0);
  float way = parting(nearest.w, normal.w, together);
  float share = j == 0 ? 1.0 : j == 1 ? -nearest.x : j == 2 ? -nearest.y : -nearest.z;
  return way * share * own_ease * normal.xyz;
}

void main() {
  int k = own_group() * GROUP + int(gl_LocalInvocationID.x);
  if (k >= surface_count) return;
  int first = load_words[queue_first + k];
  int end = load_words[queue_first + k + 1];
  if (first == end) return;
  vec3 shift = vec3(0.0);
  float ease = float_row(surface_moved_place + k).w;
  for (int entry = first; entry < end; ++entry) {
    int member = load_words[queue_list + entry];
    shift = shift + parted(meeting_place + 4 * load_words[live_list + (member >> 2)], member & 3, ease);
  }
  shift = open_axes(float_row(surface_velocity_place + k).w) * shift;
  int place = load_rows[surface_place + k].x;
  vec3 push = inverse_dt * float_row(surface_push_place + k).xyz;
  store_row(pushed_force_place + place, float_row(pushed_force_place + place) + vec4(push, 0.0));
  store_row(pushed_shift_place + place, float_row(pushed_shift_place + place) + vec4(shift, 0.0));
}
