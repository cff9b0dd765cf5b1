// SPDX-License-Identifier: MIT
//
// By one group: contacts in ascending order, those that there are, and for each particle that takes pushes the list of
// contacts it is in (in no order yet: contact_order_kernel.glsl). Needs contact_tables.glsl and contact_group.glsl.

layout(local_size_x = GROUP) in;

uniform int queue_next, raw_list, owner_list;  // words: scratch

bool takes_pushes(int k) {
  return int(float_row(surface_velocity_place + k).w) != 7;
}

int member(ivec4 who, int j) {
  return j == 0 ? who.x : j == 1 ? who.y : j == 2 ? who.z : who.w;
}

void list_contacts(int lane) {
  int count = surface_count * body_count;
  int length = (count + GROUP - 1) / GROUP;
  int from = min(lane * length, count);
  int to = min(from + length, count);
  int own = 0;
  for (int m = from; m < to; ++m) own += load_rows[meeting_place + 4 * m].x >= 0 ? 1 : 0;
  int at = count_before(lane, own);
  for (int m = from; m < to; ++m) {
    if (load_rows[meeting_place + 4 * m].x < 0) continue;
    load_words[live_list + at] = m;
    ++at;
  }
  if (lane == GROUP - 1) {
    load_words[live_count] = at;
    load_words[live_count + 1] = 0;
  }
}

void main() {
  int lane = int(gl_LocalInvocationID.x);
  list_contacts(lane);
  for (int k = lane; k <= surface_count; k += GROUP) load_words[queue_first + k] = 0;
  for (int k = lane; k < surface_count; k += GROUP) load_words[turn_list + k] = 0;
  wait_for_group();
  int contacts = load_words[live_count];
  for (int c = lane; c < contacts; c += GROUP) {
    ivec4 who = load_rows[meeting_place + 4 * load_words[live_list + c]];
    for (int j = 0; j < 4; ++j) {
      int k = member(who, j);
      load_words[ticket_list + 4 * c + j] = -1;
      if (takes_pushes(k)) atomicAdd(load_words[queue_first + k + 1], 1);
    }
  }
  wait_for_group();
  add_up_words(lane, queue_first, surface_count + 1);
  for (int k = lane; k < surface_count; k += GROUP) load_words[queue_next + k] = load_words[queue_first + k];
  wait_for_group();
  for (int c = lane; c < contacts; c += GROUP) {
    ivec4 who = load_rows[meeting_place + 4 * load_words[live_list + c]];
    for (int j = 0; j < 4; ++j) {
      int k = member(who, j);
      if (!takes_pushes(k)) continue;
      int entry = atomicAdd(load_words[queue_next + k], 1);
      load_words[raw_list + entry] = 4 * c + j;
      load_words[owner_list + entry] = k;
    }
  }
}
