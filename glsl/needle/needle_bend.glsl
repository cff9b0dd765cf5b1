// SPDX-License-Identifier: MIT
//
// A shaft that bends: all nodes onto it at once. Twin of NeedlePath::couple_sideways and hold_on_bent of src/cpu. The
// system's condition grows with the fourth power of the number of nodes, so it is factored in sums of two floats; the
// sweeps then find what the step's impulses leave. Needs needle_nodes.glsl and needle_held.glsl.

shared vec4 held_rows[MOST_NODES];    // of each, for all lanes
shared vec4 held_off[MOST_NODES];
shared vec2 pivot;

vec2 pair_at(int place, int i, int j) {
  int at = place + 2 * (i * longest + j);
  return intBitsToFloat(ivec2(needle_words[at], needle_words[at + 1]));
}

void store_pair(int place, int i, int j, vec2 value) {
  int at = place + 2 * (i * longest + j);
  needle_words[at] = floatBitsToInt(value.x);
  needle_words[at + 1] = floatBitsToInt(value.y);
}

// The lower triangular factor, a row for each held node, column by column. Nothing is held where there is none.
void factor(int lane) {
  for (int j = 0; j < held_count; ++j) {
    vec2 entry = vec2(0.0);
    if (held_row >= j) {
      entry = gives(held_row, j);
      for (int k = 0; k < j; ++k) {
        entry = sum_of(entry, -product_of(pair_at(stiffness_place, held_row, k), pair_at(stiffness_place, j, k)));
      }
      if (held_row == j) pivot = entry;
    }
    wait_for_group();
    bool positive = pivot.x > 0.0;
    vec2 root = root_of(pivot);
    if (held_row >= j && positive) {
      store_pair(stiffness_place, held_row, j, held_row == j ? root : quotient_of(entry, root));
    }
    wait_for_group();
    if (!positive) {
      held_count = 0;
      held_row = -1;
    }
  }
}

// The lane's own row of the inverse, which is a column of it as well.
void invert() {
  for (int i = held_row; i < held_count; ++i) {
    vec2 entry = vec2(i == held_row ? 1.0 : 0.0, 0.0);
    for (int k = held_row; k < i; ++k) {
      entry = sum_of(entry, -product_of(pair_at(stiffness_place, i, k), pair_at(inverse_place, held_row, k)));
    }
    store_pair(inverse_place, held_row, i, quotient_of(entry, pair_at(stiffness_place, i, i)));
  }
  for (int i = held_count - 1; i >= 0; --i) {
    vec2 entry = i < held_row ? vec2(0.0) : pair_at(inverse_place, held_row, i);
    for (int k = i + 1; k < held_count; ++k) {
      entry = sum_of(entry, -product_of(pair_at(stiffness_place, k, i), pair_at(inverse_place, held_row, k)));
    }
    store_pair(inverse_place, held_row, i, quotient_of(entry, pair_at(stiffness_place, i, i)));
  }
}

void couple_sideways(int lane) {
  choose_held(lane);
  wait_for_group();
  factor(lane);
  if (held_row >= 0) invert();
  wait_for_group();
}

vec3 own_change() {
  vec2 x = vec2(0.0);
  vec2 y = vec2(0.0);
  vec2 z = vec2(0.0);
  for (int k = 0; k < held_count; ++k) {
    vec2 entry = pair_at(inverse_place, held_row, k);
    vec3 off = held_off[k].xyz;
    x = sum_of(x, product_of(entry, vec2(off.x, 0.0)));
    y = sum_of(y, product_of(entry, vec2(off.y, 0.0)));
    z = sum_of(z, product_of(entry, vec2(off.z, 0.0)));
  }
  return vec3(x.x, y.x, z.x);
}

// Where the step ends, the shaft is bent by what it holds the tissue with.
void hold_on_bent(int lane) {
  if (held_row >= 0) held_rows[held_row] = vec4(own_side, 0.0);
  wait_for_group();
  if (held_row >= 0) {
    vec3 off = across(own_place - gone + dt * own_motion);
    for (int k = 0; k < held_count; ++k) {
      off = off + (inverse_dt * shaft_compliance(held_arm[held_row], held_arm[k])) * held_rows[k].xyz;
    }
    held_off[held_row] = vec4(off, 0.0);
  }
  wait_for_group();
  if (held_row >= 0) {
    vec3 wanted = own_side - own_change();
    float most = surface_friction * own_pushed;
    float size = sqrt(inner_product(wanted, wanted));
    if (!punctured && size > most) wanted = wanted * (most / size);
    held_rows[held_row] = vec4(wanted - own_side, 0.0);
    own_side = wanted;
  }
  wait_for_group();
  if (lane < node_count) {
    for (int k = 0; k < held_count; ++k) {
      own_motion = own_motion + coupling(lane, held_node[k]).xyz * held_rows[k].xyz;
    }
  }
  wait_for_group();
}

// What bends the shaft, in the tool's frame at the step's end; returns how many forces.
int store_loads() {
  if (held_row < 0) return held_count;
  int at = load_place(held_row);
  vec3 load = -inverse_dt * own_side;
  needle_words[at] = floatBitsToInt(own_along);
  needle_words[at + 1] = floatBitsToInt(inner_product(frame_row(number, 0).xyz, load));
  needle_words[at + 2] = floatBitsToInt(inner_product(frame_row(number, 1).xyz, load));
  needle_words[at + 3] = 0;
  return held_count;
}
