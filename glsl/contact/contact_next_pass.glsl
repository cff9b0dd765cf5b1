// SPDX-License-Identifier: MIT
//
// Per contact and each of its four particles, the next entry of that particle's contacts, -1 behind the last. Needs
// contact_lists.glsl.

RESULT(0, int, next_entry);

void entry_row(int entry) {
  next_entry = -1;
  ivec4 who = who_meet(entry >> 2);
  if (who.x < 0) return;
  int k = member(who, entry & 3);
  if (takes_pushes(k)) next_entry = entry_after(entry >> 2, k);
}

PASS_MAIN(entry_row)
