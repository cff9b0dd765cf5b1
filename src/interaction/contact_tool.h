// SPDX-License-Identifier: MIT
//
// A particle against a tool in one step, in the tool's frame (fixed to it, so that the tool stands still and the
// particle does all the moving). Pure functions of any scalar, every operation in a fixed order.
#pragma once

#include "distance_to_shape.h"

namespace phymul {

template <class S>
struct ContactLaw {
  S friction{};         // Coulomb's coefficient
  S compliance{};       // m/N
  bool placed = false;  // the tool was put where it is, not moved there
};

template <class S>
struct Touch {
  bool touches = false;
  Vector3<S> impulse;  // N s, on the particle
  Vector3<S> shift;    // m, besides: out of a tool that was put over it
};

/// a / b. In float as drivers divide, written out.
inline double quotient(double a, double b) {
  return a / b;
}
inline float quotient(float a, float b) {
  return a * (1.0f / b);
}

/// Where the particle would be, q1, seen from where it comes from, q0: how deep, and which way is out.
template <class S>
struct Depth {
  S depth{};
  Vector3<S> normal;
};

/// The first point of the way from q0 on that is in the shape (q0 itself, for what lies on the surface), by steps of
/// the distance that is left: none is longer than the way to the surface, so nothing is jumped over. True where there
/// is one; `share` of the way then.
template <class S>
bool first_hit(const ShapeIn<S>& shape, const Vector3<S>& q0, const Vector3<S>& way, const S& length, S& share) {
  constexpr int most = 64;
  share = S(0.0f);
  for (int k = 0; k < most; ++k) {
    const S phi = distance_to(shape, q0 + share * way).phi;
    if (phi <= S(1e-6f) * length) return true;
    share += quotient(phi, length);
    if (share >= S(1.0f)) return false;
  }
  return true;  // along the surface for so long: as good as on it
}

/// The end of the way, q1, is judged by where the way came in if it is longer than half of the shape is thick: the
/// nearest surface may then be the far one. Where it came in counts as a plane, and what is still inside after that
/// comes out by the nearest surface.
template <class S>
Depth<S> depth_after(const ShapeIn<S>& shape, const Vector3<S>& q0, const Vector3<S>& q1, const Vector3<S>& way) {
  const Distance<S> end = distance_to(shape, q1);
  const S length = square_root(inner_product(way, way));
  if (length <= S(0.5f) * shape.thickness || distance_to(shape, q0).phi > length) return {-end.phi, end.normal};
  S share;
  if (!first_hit(shape, q0, way, length, share)) return {-end.phi, end.normal};
  const Vector3<S> at = q0 + share * way;
  const Vector3<S> normal = distance_to(shape, at).normal;
  const S past = inner_product(at - q1, normal);
  if (past <= S(0.0f)) return {-end.phi, end.normal};
  Vector3<S> out = past * normal;
  const Distance<S> left = distance_to(shape, q1 + out);
  if (left.phi < S(0.0f)) out -= left.phi * left.normal;
  const S depth = square_root(inner_product(out, out));
  return {depth, (S(1.0f) / depth) * out};
}

/// What touch_in_step() is for a particle that is so deep.
template <class S>
Touch<S> touch_at_depth(const ShapeIn<S>& shape, const ContactLaw<S>& law, const Depth<S>& in, const Vector3<S>& q0,
                        const Vector3<S>& way, const S& inverse_mass, const S& dt) {
  S before = S(0.0f);
  if (law.placed && law.compliance == S(0.0f)) {
    before = at_most(at_least(S(0.0f), -distance_to(shape, q0).phi), in.depth);
  }
  const S normal_impulse = quotient((in.depth - before) * dt, law.compliance + dt * dt * inverse_mass);
  Touch<S> touch;
  touch.touches = true;
  touch.impulse = normal_impulse * in.normal;
  touch.shift = before * in.normal;
  if (law.friction == S(0.0f)) return touch;
  const Vector3<S> slide = way - inner_product(way, in.normal) * in.normal;
  const S length = square_root(inner_product(slide, slide));
  const S to_stop = quotient(length, dt * inverse_mass), most = law.friction * normal_impulse;
  if (to_stop <= most) {
    touch.impulse -= (S(1.0f) / (dt * inverse_mass)) * slide;
  } else {
    touch.impulse -= quotient(most, length) * slide;
  }
  return touch;
}

/// The impulse along the normal that leaves the particle on the surface (or pressed into it by compliance times the
/// force), and against its sliding that of Coulomb's law: what stops it, but at most friction times the normal one.
/// What a placed tool covers comes out without an impulse. Else a particle that is inside at the step's start slid
/// there over a curved surface, and is due the impulse that keeps it on its curve. `way`: q1 - q0, which in float has
/// more digits than the difference.
template <class S>
Touch<S> touch_in_step(const ShapeIn<S>& shape, const ContactLaw<S>& law, const Vector3<S>& q0, const Vector3<S>& q1,
                       const Vector3<S>& way, const S& inverse_mass, const S& dt) {
  const Depth<S> in = depth_after(shape, q0, q1, way);
  return in.depth > S(0.0f) ? touch_at_depth(shape, law, in, q0, way, inverse_mass, dt) : Touch<S>{};
}

}  // namespace phymul
