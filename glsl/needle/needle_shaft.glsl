// SPDX-License-Identifier: MIT
//
// Twin of src/interaction/needle_shaft.h. Needs needle_tables.glsl.

// m along the shaft from the hub: 0 for places beyond it, the tip's for those ahead of the tip.
float shaft_arm(float along) {
  return clamp(needle_length - along, 0.0, needle_length);
}

// By more than what forces leave open.
bool is_ahead_of_tip(float along) {
  return along < -0.1 * needle_radius;
}

// m/N
float shaft_compliance(float a, float b) {
  float nearer = min(a, b);
  float farther = max(a, b);
  return nearer * nearer * (3.0 * farther - nearer) * (1.0 / (6.0 * bending_stiffness));
}

// From the tip of the unbent shaft, as the last step's forces bend it.
vec3 shaft_at(float along) {
  vec3 x = along * axis;
#ifdef BENDING
  float own = shaft_arm(along);
  for (int k = 0; k < shaft_loads; ++k) {
    vec3 load = shaft_load(k);
    float bend = shaft_compliance(own, shaft_arm(load.x));
    x = x + bend * (load.y * axis_x + load.z * axis_y);
  }
#endif
  return x;
}
