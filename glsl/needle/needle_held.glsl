// SPDX-License-Identifier: MIT
//
// Which nodes a shaft that bends holds, and how they give way: NeedlePath::couple_sideways of src/cpu. Needs
// needle_motion.glsl, needle_shaft.glsl, two_floats.glsl, and coupling().

// By how much a held node counts as softer than it is: two nodes that move as one leave no system singular.
const float slack = 1e-9;

shared int held_node[MOST_NODES];   // nodes held sideways in this step
shared float held_arm[MOST_NODES];  // m from the hub

int held_count;
int held_row;  // of the lane's node among them; -1: not held

// Held are those on the shaft and the one at the tip, but no two closer than half a spread: closer ones move as one,
// and forces against each other would only turn the tissue.
void choose_held(int lane) {
  held_count = 0;
  held_row = -1;
  float before = 0.0;
  for (int k = 0; k < node_count; ++k) {
    float along = node_place[k].w;
    bool at_tip = is_last(k) && !through && (!punctured || !is_ahead_of_tip(along));
    float arm = shaft_arm(along);
    if (!on_shaft(k) && !at_tip) continue;
    if (node_motion[k].w == 0.0 && arm == 0.0) continue;
    if (held_count > 0 && before - along < 0.5 * spread) continue;
    if (lane == k) held_row = held_count;
    if (lane == 0) {
      held_node[held_count] = k;
      held_arm[held_count] = arm;
    }
    ++held_count;
    before = along;
  }
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
