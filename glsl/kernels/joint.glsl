// SPDX-License-Identifier: MIT
//
// The law of a joint's spring (src/interaction/joint_set.h).

// Force on the first anchor, where r leads to the second one, m, and v is how it changes, m/s. stretch = |r| - L.
// `holds`: without a rest length, in all directions; else along the line between the anchors, which two at one place do
// not have: no force.
KERNEL real3 joint_pull(real3 r, real3 v, real length_now, real stretch, real k, real c, bool holds, bool slack) {
  real zero = literal(0.0f);
  real3 none = real3(zero, zero, zero);
  real3 direction = (literal(1.0f) / length_now) * r;
  real pull = k * stretch + c * inner_product(v, direction);
  real3 along = select(length_now > zero, pull * direction, none);
  real3 f = select(holds, k * r + c * v, along);
  bool gives_way = slack && (inner_product(f, r) < zero || (!holds && stretch <= zero));
  return select(gives_way, none, f);
}
