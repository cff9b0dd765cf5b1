// SPDX-License-Identifier: MIT
//
// Twin of tests/mirror/integrate_displacement.h.

vec3 acceleration(vec3 force, float inverse_mass, vec3 gravity) {
  return inverse_mass * force + gravity;
}

vec3 cut_force(vec3 force, float largest) {
  float q = inner_product(force, force);
  return q > largest * largest ? (largest * (1.0 / sqrt(q))) * force : force;
}

void integrate_displacement(inout vec3 u, inout vec3 v, vec3 a, float dt, float damping_factor) {
  v = damping_factor * v + dt * a;
  u = u + dt * v;
}

// Bit k of `fixed_axes` set: coordinate k is imposed; `before` is u before the step.
void impose(inout vec3 u, inout vec3 v, int fixed_axes, vec3 target, vec3 before, float inverse_dt) {
  vec3 imposed = inverse_dt * (target - before);
  if ((fixed_axes & 1) != 0) {
    u.x = target.x;
    v.x = imposed.x;
  }
  if ((fixed_axes & 2) != 0) {
    u.y = target.y;
    v.y = imposed.y;
  }
  if ((fixed_axes & 4) != 0) {
    u.z = target.z;
    v.z = imposed.z;
  }
}
