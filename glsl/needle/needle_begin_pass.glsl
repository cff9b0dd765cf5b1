// SPDX-License-Identifier: MIT
//
// A needle's state as a step begins: whether it has left the body, whether its hole must go on. Drawn only; needs
// needle_follow.glsl.

RESULT(0, vec4, next_state);

void begin_step() {
  // Out again: as far as the skin gave way, so that rounding does not part them.
  if (node_count > 0) {
    if (is_ahead_of_tip(fetch_changing(needle_places, needle_places_place, 0).w)) begin_hole();
  }
  if (node_count == 0) {
    stage = meets;
  } else if (!through) {
    look(fetch_changing(needle_places, needle_places_place, node_count - 1).w);
  }
}

void begin_row(int row) {
  begin_needle();
  if (number == 1) {
    full_step = 0;
    unfinished_step = 0;
  }
  stage = done;
  if (full_step == 0 && unfinished_step == 0) begin_step();  // else what follows is done again
  known = node_count;
  next_state = row < header_rows ? header_row(row) : state_row(row);
}

PASS_MAIN(begin_row)
