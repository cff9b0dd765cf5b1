// SPDX-License-Identifier: MIT
//
// A needle's state between the nodes that a step makes: what came of the last one, and where the next one goes. Drawn
// only; needs needle_follow.glsl, needle_weights.glsl and needle_total.glsl.

STORED(entering_rows, entering_rows_place);  // needle_facets_pass.glsl
STORED(behind_rows, behind_rows_place);
STORED(ahead_rows, ahead_rows_place);
uniform int after_node_made;  // 1: passes have looked for a node's particles since the last time
uniform int ends;             // 1: no more of them come in this step

RESULT(0, vec4, next_state);

int added;  // that node, with how many particles; -1: none
int added_around;

int outcome() {
  int found = total_found();
  if (found > most_around || node_count >= longest) return node_full;
  if (found >= 4 && spans(total_moments())) return node_added;
  return found < model_count && reach < 1000.0 * first_reach ? node_again : node_none;
}

void after_node(int result) {
  if (result == node_again) {
    reach *= 1.5;
    return;
  }
  if (result == node_full) {
    full_step = number;
    stage = done;
    return;
  }
  if (result == node_added) {
    added = node_count;
    added_around = total_found();
    ++node_count;
  }
  reach = first_reach;
  if (stage == fills) {
    left -= spread;
  } else if (stage == enters) {
    stage = result == node_added ? looks : done;
    if (result == node_added) slip = way;
  } else {
    stage = done;
  }
}

void meet() {
  vec4 met = fetch_changing(entering_rows, entering_rows_place, 0);
  stage = done;
  if (!(met.x >= 0.0)) return;
  begin_hole();
  way = met.x;
  reach = first_reach;
  stage = enters;
}

// Out again where the nearest surface back along the shaft is one it came out of. A mean over particles lies above the
// deepest point of a dent, so that right after the puncture the tip may still be in front of the facets.
void close() {
  vec4 back = fetch_changing(behind_rows, behind_rows_place, 0);
  bool inside = back.x >= 0.0 ? back.y > 0.0 : first;
  if (!(back.x >= 0.0) && !inside) {
    vec4 front = fetch_changing(ahead_rows, ahead_rows_place, 0);
    inside = front.x >= 0.0 && front.y > 0.0;
  }
  way = inside ? 0.0 : back.x;
  through = !inside;
  reach = first_reach;
  stage = way >= 0.0 ? closes : done;
}

void take_aim() {
  for (int k = 0; k < 2 * MOST_NODES; ++k) {
    if (stage == meets) meet();
    if (stage == looks) look(way);  // the only node is where the surface was met
    if (stage == fills && !(left > 0.0)) close();
    if (stage == done) return;
    aim = stage == enters ? way * axis : stage == fills ? shaft_at(left) : shaft_at(0.0) + way * way_back();
    if (!(any(isnan(aim)) || any(isinf(aim)))) return;
    after_node(node_none);
  }
  stage = done;
}

void aim_row(int row) {
  begin_needle();
  added = -1;
  if (stage != done) {
    if (after_node_made != 0) after_node(outcome());
    take_aim();
  }
  if (ends != 0 && stage != done) unfinished_step = number;
  if (row < header_rows) {
    next_state = header_row(row);
  } else if (added >= 0 && row == node_row(added)) {
    next_state = vec4(float(added_around), 0.0, 0.0, 0.0);
  } else {
    next_state = state_row(row);
  }
}

PASS_MAIN(aim_row)
