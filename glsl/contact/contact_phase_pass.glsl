// SPDX-License-Identifier: MIT
//
// A phase of the sweeps, with the result of one contact after another in ascending order: contact_press_kernel.glsl. A
// contact's turn has come when it is that of each of its particles; of those no two share a particle that takes pushes.
// Each particle and each meeting has a row, and all rows of a contact compute all of it. Needs contact_sweeps.glsl and
// contact_law.glsl.

TABLE_INTS(next_entries, next_entries_place);
uniform int rounds;  // sweeps
uniform int phase;   // counts from 1

RESULT(0, vec4, pressing_now);
RESULT(1, vec4, pushing_now);
RESULT(2, ivec4, turns_now);

bool has_come(int entry, int k) {
  int turn = fetch_ivec4(turns, turns_place, k).x;
  return turn == entry || turn == unmoved;
}

bool is_next(int m, ivec4 who) {
  return has_come(4 * m, who.x) && has_come(4 * m + 1, who.y) && has_come(4 * m + 2, who.z) &&
         has_come(4 * m + 3, who.w);
}

vec4 pressed_row(int row) {
  return fetch_changing(pressing, pressing_place, row);
}

float ease_of(int k) {
  return fetch_changing(surface_moved, surface_moved_place, k).w;
}

// Changes nothing where push_apart() does not.
Meeting press(int m, ivec4 who, inout vec4 done) {
  vec4 nearest = fetch_changing(meeting_nearest, meeting_nearest_place, m);
  vec4 v0 = pressed_row(who.x);
  vec4 v1 = pressed_row(who.y);
  vec4 v2 = pressed_row(who.z);
  vec4 v3 = pressed_row(who.w);
  Meeting meeting;
  meeting.v = mat4x3(v0.xyz, v1.xyz, v2.xyz, v3.xyz);
  meeting.open = mat4x3(open_axes(v0.w), open_axes(v1.w), open_axes(v2.w), open_axes(v3.w));
  meeting.given = mat4x3(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
  meeting.ease = vec4(ease_of(who.x), ease_of(who.y), ease_of(who.z), ease_of(who.w));
  meeting.weight = vec4(1.0, -nearest.xyz);
  push_apart(meeting, fetch_changing(meeting_normal, meeting_normal_place, m).xyz, nearest.w, done);
  return meeting;
}

vec3 of_member(mat4x3 each, int j) {
  return j == 0 ? each[0] : j == 1 ? each[1] : j == 2 ? each[2] : each[3];
}

void pass_on(int entry) {
  int next = fetch_int(next_entries, next_entries_place, entry);
  if (next < 0) {
    turns_now.y = turns_now.y + 1;
    next = turns_now.y < rounds ? turns_now.z : done_with;
  }
  turns_now.x = next;
}

void phase_row(int row) {
  pressing_now = pressed_row(row);
  pushing_now = fetch_changing(pushing, pushing_place, row);
  turns_now = fetch_ivec4(turns, turns_place, row);
  bool is_particle = row < surface_count;
  int entry = is_particle ? turns_now.x : 4 * (row - surface_count);
  if (entry < 0) return;
  int m = entry >> 2;
  ivec4 who = who_meet(m);
  if (who.x < 0 || !is_next(m, who)) return;
  vec4 done = pressed_row(surface_count + m);
  Meeting meeting = press(m, who, done);
  if (!is_particle) {
    pressing_now = done;
    return;
  }
  pressing_now = vec4(of_member(meeting.v, entry & 3), pressing_now.w);
  pushing_now = vec4(pushing_now.xyz + of_member(meeting.given, entry & 3), max(pushing_now.w, float(phase)));
  pass_on(entry);
}

PASS_MAIN(phase_row)
