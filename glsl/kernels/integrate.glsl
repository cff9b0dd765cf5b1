// SPDX-License-Identifier: MIT
//
// Verlet's step (src/cpu/integrate.h) for a displacement u and a velocity v:
//   a = f / m + g,  v+ = d v + dt a,  u+ = u + dt v+
// Imposed coordinates have u+ = target and v+ = (target - u) / dt.

KERNEL real3 acceleration(real3 force, real inverse_mass, real3 gravity) {
  return inverse_mass * force + gravity;
}

// An elastic force, cut to `largest`: SolverOptions::max_displacement_per_step.
KERNEL real3 cut_force(real3 force, real largest) {
  real q = inner_product(force, force);
  return select(q > largest * largest, (largest * (literal(1.0f) / square_root(q))) * force, force);
}

KERNEL void integrate_displacement(INOUT(real3) u, INOUT(real3) v, real3 a, real dt, real damping_factor) {
  v = damping_factor * v + dt * a;
  u = u + dt * v;
}

// Bit k of `fixed_axes` set: coordinate k is imposed; `before` is u before the step.
KERNEL void impose(INOUT(real3) u, INOUT(real3) v, int fixed_axes, real3 target, real3 before, real inverse_dt) {
  real3 imposed = inverse_dt * (target - before);
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
