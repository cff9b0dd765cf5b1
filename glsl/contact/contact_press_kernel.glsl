// SPDX-License-Identifier: MIT
//
// Sweeps over all contacts, by one group, with the result of one after another in ascending order: BodyContacts::press
// of src/interaction. A contact's turn has come when each of its particles has been through all contacts before it in the
// particle's list, which is counted in turns: its ticket. Of those whose turn it is no two share a particle. Contacts far
// from each other are pressed at the same time, those of the next sweep too, and no result depends on which lane came
// first. Every phase presses at least one; what a dispatch leaves the next one does.
// Needs contact_tables.glsl, contact_group.glsl, kernel_language.glsl and contact_law.glsl.

layout(local_size_x = GROUP) in;

uniform int rounds;      // sweeps
uniform int most_turns;  // of loops, in a dispatch

shared int pressed_count;

const int never = 2147483647;

void press(int at, ivec4 who) {
  vec4 nearest = float_row(at + 1);
  vec4 v0 = float_row(surface_velocity_place + who.x);
  vec4 v1 = float_row(surface_velocity_place + who.y);
  vec4 v2 = float_row(surface_velocity_place + who.z);
  vec4 v3 = float_row(surface_velocity_place + who.w);
  Meeting m;
  m.v = mat4x3(v0.xyz, v1.xyz, v2.xyz, v3.xyz);
  m.open = mat4x3(open_axes(v0.w), open_axes(v1.w), open_axes(v2.w), open_axes(v3.w));
  m.given = mat4x3(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
  m.ease = vec4(float_row(surface_moved_place + who.x).w, float_row(surface_moved_place + who.y).w,
                float_row(surface_moved_place + who.z).w, float_row(surface_moved_place + who.w).w);
  m.weight = vec4(1.0, -nearest.xyz);
  vec4 done = float_row(at + 3);
  if (!push_apart(m, float_row(at + 2).xyz, nearest.w, done)) return;
  store_row(at + 3, done);
  store_row(surface_velocity_place + who.x, vec4(m.v[0], v0.w));
  store_row(surface_velocity_place + who.y, vec4(m.v[1], v1.w));
  store_row(surface_velocity_place + who.z, vec4(m.v[2], v2.w));
  store_row(surface_velocity_place + who.w, vec4(m.v[3], v3.w));
  store_row(surface_push_place + who.x, float_row(surface_push_place + who.x) + vec4(m.given[0], 0.0));
  store_row(surface_push_place + who.y, float_row(surface_push_place + who.y) + vec4(m.given[1], 0.0));
  store_row(surface_push_place + who.z, float_row(surface_push_place + who.z) + vec4(m.given[2], 0.0));
  store_row(surface_push_place + who.w, float_row(surface_push_place + who.w) + vec4(m.given[3], 0.0));
}

// A particle that takes no pushes makes nobody wait.
bool has_come(int ticket, int k) {
  return ticket < 0 || load_words[turn_list + k] == ticket;
}

bool is_next(int c) {
  int at = ticket_list + 4 * c;
  ivec4 who = load_rows[meeting_place + 4 * load_words[live_list + c]];
  return has_come(load_words[at], who.x) && has_come(load_words[at + 1], who.y) &&
         has_come(load_words[at + 2], who.z) && has_come(load_words[at + 3], who.w);
}

void pass_on(int at, int k) {
  int ticket = load_words[at];
  if (ticket < 0) return;
  int length = load_words[queue_first + k + 1] - load_words[queue_first + k];
  load_words[turn_list + k] = ticket + 1;
  load_words[at] = ticket + length < rounds * length ? ticket + length : never;
}

void main() {
  int lane = int(gl_LocalInvocationID.x);
  int contacts = load_words[live_count];
  int rows = (contacts + GROUP - 1) / GROUP;
  int phases = most_turns / (3 + 3 * rows);
  if (lane == 0) pressed_count = load_words[live_count + 1];
  wait_for_group();
  for (int phase = 0; phase < phases; ++phase) {
    int before = pressed_count;
    if (before >= contacts * rounds) break;  // for all lanes: none counts on before the next wait
    for (int block = 0; block < rows; block += 32) {
      int end = min(rows - block, 32);
      uint ready = 0u;
      for (int k = 0; k < end; ++k) {
        int c = (block + k) * GROUP + lane;
        if (c < contacts && is_next(c)) ready = ready | (1u << uint(k));
      }
      wait_for_group();
      for (int k = 0; k < end; ++k) {
        if ((ready & (1u << uint(k))) == 0u) continue;
        int c = (block + k) * GROUP + lane;
        int at = meeting_place + 4 * load_words[live_list + c];
        ivec4 who = load_rows[at];
        press(at, who);
        pass_on(ticket_list + 4 * c, who.x);
        pass_on(ticket_list + 4 * c + 1, who.y);
        pass_on(ticket_list + 4 * c + 2, who.z);
        pass_on(ticket_list + 4 * c + 3, who.w);
        atomicAdd(pressed_count, 1);
      }
      wait_for_group();
    }
    if (pressed_count == before) break;  // for all lanes likewise; a turn that never comes must not be waited for
  }
  if (lane == 0) load_words[live_count + 1] = pressed_count;
}
