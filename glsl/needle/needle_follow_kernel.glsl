// SPDX-License-Identifier: MIT
//
// Where a needle's hole goes, by the positions at the step's start: NeedlePath::follow of src/cpu, by one group. A look
// for the particles around a place, and a node whose coupling is not known, are a unit of work each; what units a
// dispatch does not get done the next one goes on with. Needs needle_surface.glsl, needle_node.glsl and
// needle_shaft.glsl.

layout(local_size_x = GROUP) in;

uniform int most_units;     // in a dispatch
uniform int goes_on, ends;  // 1: with what a dispatch before left of this step; no other comes in it

const int done = 0, enters = 1, looks = 2, fills = 3, closes = 4, couples = 5;

int stage, coupled, full_step;
float left;   // m from the tip of the next node on the way made since the last one
float reach;  // m, of the next node's weights
float way;    // m from the tip to where the hole begins or ends
bool first;   // the hole had one node
vec3 behind;  // from the tip, along the shaft

void begin_hole() {
  node_count = 0;
  coupled = 0;
  shaft_loads = 0;
  punctured = false;
  through = false;
  slip = 0.0;
}

void begin_step(int lane) {
  stage = through ? couples : looks;
  // Out again: as far as the skin gave way, so that rounding does not part them.
  bool out_again = false;
  if (node_count > 0) out_again = is_ahead_of_tip(inner_product(axis, mean_place(lane, 0)));
  if (out_again) begin_hole();
  if (node_count > 0) return;
  stage = done;
  vec2 met = meet_surface(lane, vec3(0.0), axis, true);
  if (!(met.x >= 0.0)) return;
  begin_hole();
  way = met.x;
  reach = first_reach;
  stage = enters;
}

void look(int lane) {
  slip = max(slip, inner_product(axis, mean_place(lane, node_count - 1)));
  stage = couples;
  if (slip < (punctured ? spread : needle_radius)) return;
  punctured = true;
  first = node_count == 1;
  left = slip - spread;
  slip = 0.0;
  reach = first_reach;
  stage = fills;
}

// Out again where the nearest surface back along the shaft is one it came out of. A mean over particles lies above the
// deepest point of a dent, so that right after the puncture the tip may still be in front of the facets.
void close(int lane, vec3 tip) {
  vec2 back = vec2(-1.0, 0.0);
  bool inside = false;
  for (int side = 0; side < 2; ++side) {
    vec2 met = meet_surface(lane, tip, side == 0 ? behind : -behind, false);
    if (side == 0) back = met;
    inside = met.x >= 0.0 ? met.y > 0.0 : side == 0 && first;
    if (back.x >= 0.0 || inside) break;
  }
  way = inside ? 0.0 : back.x;
  through = !inside;
  reach = first_reach;
  stage = way >= 0.0 ? closes : couples;
}

void after_node(int outcome) {
  if (outcome == node_again) {
    reach *= 1.5;
    return;
  }
  if (outcome == node_full) {
    full_step = number;
    stage = done;
    return;
  }
  reach = first_reach;
  if (stage == fills) {
    left -= spread;
  } else if (stage == enters) {
    stage = outcome == node_added ? looks : done;
    if (outcome == node_added) slip = way;
  } else {
    stage = couples;
  }
}

void work(int lane) {
  if (stage == looks) look(lane);
  if (stage == couples) {
    if (coupled < node_count) {
      couple_node(lane, coupled);
      ++coupled;
    } else {
      stage = done;
    }
    return;
  }
  vec3 tip = shaft_at(0.0);
  behind = shaft_at(min(spread, needle_length)) - tip;
  behind = behind * (1.0 / sqrt(inner_product(behind, behind)));
  if (stage == fills && !(left > 0.0)) close(lane, tip);
  if (stage == couples) return;
  vec3 x = stage == enters ? way * axis : stage == fills ? shaft_at(left) : tip + way * behind;
  after_node(add_node(lane, x, reach));
}

void store(int word, int value) {
  needle_words[state_place + word] = value;
}

void main() {
  int lane = int(gl_LocalInvocationID.x);
  begin_needle();
  coupled = state_word(HEADER_COUPLED);
  full_step = number == 1 && goes_on == 0 ? 0 : state_word(HEADER_FULL);
  stage = state_word(HEADER_STAGE);
  left = state_real(HEADER_LEFT);
  reach = state_real(HEADER_REACH);
  way = state_real(HEADER_WAY);
  first = state_word(HEADER_FIRST) != 0;
  wait_for_group();
  if (full_step != 0) {
    stage = done;  // what follows is done again from the step before
  } else if (goes_on == 0) {
    begin_step(lane);
  }
  for (int unit = 0; unit < most_units; ++unit) {
    if (stage == done) break;
    work(lane);
  }
  if (ends != 0 && stage != done && full_step == 0) full_step = number;
  if (lane > 0) return;
  store(HEADER_COUNT, node_count);
  store(HEADER_PUNCTURED, punctured ? 1 : 0);
  store(HEADER_THROUGH, through ? 1 : 0);
  store(HEADER_SLIP, floatBitsToInt(slip));
  store(HEADER_LOADS, shaft_loads);
  store(HEADER_FULL, full_step);
  store(HEADER_COUPLED, coupled);
  store(HEADER_STAGE, stage);
  store(HEADER_LEFT, floatBitsToInt(left));
  store(HEADER_REACH, floatBitsToInt(reach));
  store(HEADER_WAY, floatBitsToInt(way));
  store(HEADER_FIRST, first ? 1 : 0);
}
