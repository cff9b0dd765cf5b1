// SPDX-License-Identifier: MIT
//
// A shaft that bends: all nodes onto it at once. Twin of NeedlePath::couple_sideways and hold_on_bent of src/cpu. The
// system's condition grows with the fourth power of the number of nodes, so it is factored in sums of two floats; the
// sweeps then find what the step's impulses leave. Needs needle_nodes.glsl, needle_shaft.glsl and two_floats.glsl.

// By how much a held node counts as softer than it is: two nodes that move as one leave no system singular.
const float slack = 1e-9;

shared int held_node[MOST_NODES];     // nodes held sideways in this step
shared float held_arm[MOST_NODES];    // m from the hub
shared vec4 held_rows[MOST_NODES];    // of each, for all lanes
shared vec4 held_off[MOST_NODES];
shared vec2 pivot;

int held_count;
int own_row;  // of the lane's node among them; -1: not held

vec2 pair_at(int place, int i, int j) {
  int at = place + 2 * (i * longest + j);
  return intBitsToFloat(ivec2(needle_words[at], needle_words[at + 1]));
}

void store_pair(int place, int i, int j, vec2 value) {
  int at = place + 2 * (i * longest + j);
  needle_words[at] = floatBitsToInt(value.x);
  needle_words[at + 1] = floatBitsToInt(value.y);
}

// Held are those on the shaft and the one at the tip, but no two closer than half a spread: closer ones move as one,
// and forces against each other would only turn the tissue.
void choose_held(int lane) {
  held_count = 0;
  own_row = -1;
  float before = 0.0;
  for (int k = 0; k < node_count; ++k) {
    float along = node_place[k].w;
    bool at_tip = is_last(k) && !through && (!punctured || along >= 0.0);
    float arm = shaft_arm(along);
    if (!on_shaft(k) && !at_tip) continue;
    if (node_motion[k].w == 0.0 && arm == 0.0) continue;
    if (held_count > 0 && before - along < 0.5 * spread) continue;
    if (lane == k) own_row = held_count;
    if (lane == 0) {
      held_node[held_count] = k;
      held_arm[held_count] = arm;
    }
    ++held_count;
    before = along;
  }
  wait_for_group();
}

// m / (N s), of the shaft and the tissue.
vec2 gives(int row, int column) {
  float a = held_arm[row];
  float b = held_arm[column];
  float nearer = min(a, b);
  vec2 length = sum_of(exact_product(3.0, max(a, b)), vec2(-nearer, 0.0));
  vec2 bend = product_of(product_of(exact_product(nearer, nearer), length),
                         vec2(inverse_dt * (1.0 / (6.0 * bending_stiffness)), 0.0));
  vec2 both = sum_of(exact_product(dt, coupling(held_node[row], held_node[column]).w), bend);
  return row == column ? sum_of(both, vec2(slack * both.x, 0.0)) : both;
}

// The lower triangular factor, a row for each held node, column by column. Nothing is held where there is none.
void factor(int lane) {
  for (int j = 0; j < held_count; ++j) {
    vec2 entry = vec2(0.0);
    if (own_row >= j) {
      entry = gives(own_row, j);
      for (int k = 0; k < j; ++k) {
        entry = sum_of(entry, -product_of(pair_at(stiffness_place, own_row, k), pair_at(stiffness_place, j, k)));
      }
      if (own_row == j) pivot = entry;
    }
    wait_for_group();
    bool positive = pivot.x > 0.0;
    vec2 root = root_of(pivot);
    if (own_row >= j && positive) {
      store_pair(stiffness_place, own_row, j, own_row == j ? root : quotient_of(entry, root));
    }
    wait_for_group();
    if (!positive) {
      held_count = 0;
      own_row = -1;
    }
  }
}

// The lane's own row of the inverse, which is a column of it as well.
void invert() {
  for (int i = own_row; i < held_count; ++i) {
    vec2 entry = vec2(i == own_row ? 1.0 : 0.0, 0.0);
    for (int k = own_row; k < i; ++k) {
      entry = sum_of(entry, -product_of(pair_at(stiffness_place, i, k), pair_at(inverse_place, own_row, k)));
    }
    store_pair(inverse_place, own_row, i, quotient_of(entry, pair_at(stiffness_place, i, i)));
  }
  for (int i = held_count - 1; i >= 0; --i) {
    vec2 entry = i < own_row ? vec2(0.0) : pair_at(inverse_place, own_row, i);
    for (int k = i + 1; k < held_count; ++k) {
      entry = sum_of(entry, -product_of(pair_at(stiffness_place, k, i), pair_at(inverse_place, own_row, k)));
    }
    store_pair(inverse_place, own_row, i, quotient_of(entry, pair_at(stiffness_place, i, i)));
  }
}

void couple_sideways(int lane) {
  choose_held(lane);
  factor(lane);
  if (own_row >= 0) invert();
  wait_for_group();
}

vec3 own_change() {
  vec2 x = vec2(0.0);
  vec2 y = vec2(0.0);
  vec2 z = vec2(0.0);
  for (int k = 0; k < held_count; ++k) {
    vec2 entry = pair_at(inverse_place, own_row, k);
    vec3 off = held_off[k].xyz;
    x = sum_of(x, product_of(entry, vec2(off.x, 0.0)));
    y = sum_of(y, product_of(entry, vec2(off.y, 0.0)));
    z = sum_of(z, product_of(entry, vec2(off.z, 0.0)));
  }
  return vec3(x.x, y.x, z.x);
}

// Where the step ends, the shaft is bent by what it holds the tissue with.
void hold_on_bent(int lane) {
  if (own_row >= 0) held_rows[own_row] = vec4(own_side, 0.0);
  wait_for_group();
  if (own_row >= 0) {
    vec3 off = across(own_place - gone + dt * own_motion);
    for (int k = 0; k < held_count; ++k) {
      off = off + (inverse_dt * shaft_compliance(held_arm[own_row], held_arm[k])) * held_rows[k].xyz;
    }
    held_off[own_row] = vec4(off, 0.0);
  }
  wait_for_group();
  if (own_row >= 0) {
    vec3 wanted = own_side - own_change();
    float most = surface_friction * own_pushed;
    float size = sqrt(inner_product(wanted, wanted));
    if (!punctured && size > most) wanted = wanted * (most / size);
    held_rows[own_row] = vec4(wanted - own_side, 0.0);
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
  if (own_row < 0) return held_count;
  int at = load_place(own_row);
  vec3 load = -inverse_dt * own_side;
  needle_words[at] = floatBitsToInt(own_along);
  needle_words[at + 1] = floatBitsToInt(inner_product(frame_row(number, 0).xyz, load));
  needle_words[at + 2] = floatBitsToInt(inner_product(frame_row(number, 1).xyz, load));
  needle_words[at + 3] = 0;
  return held_count;
}
