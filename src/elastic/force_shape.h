// SPDX-License-Identifier: MIT
//
// The shape-memory model: where a base wants its particle, and what its pull gives back to the base.
// Notation of phymul/topology.h. With e1 = x_b - x_a, e2 = x_c - x_a:
//   w = e1 x e2  (2-D: e1 turned left by a right angle),  n = w / |w|
//   P*_t = lambda_a x_a + lambda_b x_b + lambda_c x_c + beta n
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace phymul {

template <class S>
using Vec = Eigen::Matrix<S, 3, 1>;

/// A base in flight.
template <class S>
struct BaseFrame {
  Vec<S> e1, e2;              ///< m; e2 unused in 2-D
  Vec<S> n = Vec<S>::Zero();  ///< unit normal; zero where the base has collapsed to a line or a point
  S length = 0;               ///< |w|, m^2 (2-D: m)
};

/// A base whose |w| is below `collapsed` times the product of its edges has no direction left and gives no normal term.
/// Relative, so that it means the same at any size. The normal is never softened: that would make a collapsed body a
/// rest state.
template <class S>
inline constexpr S collapsed = S(1e-12);

template <class S>
BaseFrame<S> base_frame_3d(const Vec<S>& xa, const Vec<S>& xb, const Vec<S>& xc) {
  BaseFrame<S> f;
  f.e1 = xb - xa;
  f.e2 = xc - xa;
  const Vec<S> w = f.e1.cross(f.e2);
  f.length = w.norm();
  if (f.length > collapsed<S> * f.e1.norm() * f.e2.norm()) f.n = w / f.length;
  return f;
}

template <class S>
BaseFrame<S> base_frame_2d(const Vec<S>& xa, const Vec<S>& xb) {
  BaseFrame<S> f;
  f.e1 = xb - xa;
  f.e2.setZero();
  const Vec<S> w(-f.e1.y(), f.e1.x(), S(0));
  f.length = w.norm();
  if (f.length > S(0)) f.n = w / f.length;
  return f;
}

/// Derivative by w of an energy whose change is F . d(beta n): G = beta / |w| (F - n (n.F)).
template <class S>
Vec<S> height_slope(const BaseFrame<S>& f, S beta, const Vec<S>& force) {
  if (f.n == Vec<S>::Zero()) return Vec<S>::Zero();
  return (beta / f.length) * (force - f.n.dot(force) * f.n);
}

/// Forces on the vertices of a base whose owner feels F, as -dE/dx of an energy with dE = F . d(P*_t - x_i):
///   on b: -lambda_b F - e2 x G,  on c: -lambda_c F - G x e1,  on a: what makes the four forces sum to zero.
template <class S>
std::array<Vec<S>, 3> base_reaction_3d(const BaseFrame<S>& f, const std::array<S, 3>& lambda, S beta,
                                       const Vec<S>& force) {
  const Vec<S> G = height_slope(f, beta, force);
  const Vec<S> on_b = -lambda[1] * force - f.e2.cross(G);
  const Vec<S> on_c = -lambda[2] * force - G.cross(f.e1);
  return {-(force + on_b + on_c), on_b, on_c};
}

/// The same in 2-D, where w is e1 turned left: on b: -lambda_b F - G turned right.
template <class S>
std::array<Vec<S>, 3> base_reaction_2d(const BaseFrame<S>& f, const std::array<S, 3>& lambda, S beta,
                                       const Vec<S>& force) {
  const Vec<S> G = height_slope(f, beta, force);
  const Vec<S> on_b = -lambda[1] * force - Vec<S>(G.y(), -G.x(), S(0));
  return {-(force + on_b), on_b, Vec<S>::Zero()};
}

}  // namespace phymul
