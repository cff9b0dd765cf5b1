// SPDX-License-Identifier: MIT
//
// Where a needle's hole goes: what both passes of it need. Twin of needle_follow_kernel.glsl. Needs needle_state.glsl and
// needle_shaft.glsl.

void begin_hole() {
  node_count = 0;
  shaft_loads = 0;
  punctured = false;
  through = false;
  slip = 0.0;
}

// The last node is so far along the shaft.
void look(float along) {
  slip = max(slip, along);
  stage = done;
  if (slip < (punctured ? spread : needle_radius)) return;
  punctured = true;
  first = node_count == 1;
  left = slip - spread;
  slip = 0.0;
  reach = first_reach;
  stage = fills;
}

// From the tip, back along the shaft.
vec3 way_back() {
  vec3 back = shaft_at(min(spread, needle_length)) - shaft_at(0.0);
  return back * (1.0 / sqrt(inner_product(back, back)));
}
