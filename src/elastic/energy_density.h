// SPDX-License-Identifier: MIT
//
// The energies of a material per rest volume, as functions of the deformation gradient F (StrainEnergy in topology.h).
// With the principal stretches s of F,
//   d = sqrt(3 / (1/s1^2 + 1/s2^2 + 1/s3^2)) = sqrt(3) J / |cof(F)|, negative where F is inverted
//   u = 2 d / (1 + (s1^2 + s2^2 + s3^2) / 3): 1 at rest and less elsewhere; at least 0.61 where all s are 0.6 to 1.7
// the energy is neo-Hookean where u >= 0.6 and mu (|F|^2 / 2 - 2.5 d + 1.5) where u <= 0.2. In between, the share of
// the second rises smoothly. By -2.5 d, unlike by J alone, a body collapsed to a line or a point is pushed apart: the
// only minima of the whole are rotations.
#pragma once

#include <phymul/topology_textures.h>

#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "force_volume.h"
#include "model/material.h"

namespace phymul {

/// a^(-1/3), a > 0, to 1e-15 of it; exactly 1 at 1. By operations that IEEE 754 defines to the last bit: std::pow and
/// std::cbrt round as each C library likes.
inline double inverse_cube_root(double a) {
  // The exponent, and with it the logarithm, stands in the first bits: minus a third of it, from 1, is 6 % off at most.
  constexpr std::uint64_t one = std::bit_cast<std::uint64_t>(1.0);
  double x = std::bit_cast<double>(one + one / 3 - std::bit_cast<std::uint64_t>(a) / 3);
  // x (1 - h)^(-1/3) is the root; three terms of that series leave an error of 0.2 h^3: 1e-3, 1e-8, then rounding.
  for (int k = 0; k < 3; ++k) {
    const double h = 1.0 - (a * x) * (x * x);
    x += x * h * (1.0 / 3.0 + (2.0 / 9.0) * h);
  }
  return x;
}

template <class S>
using Mat = Eigen::Matrix<S, 3, 3>;

template <class S>
Mat<S> cofactor(const Mat<S>& F) {
  Mat<S> C;
  C << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return C;
}

/// k/8 (|F a|^2 - |a|^2)^2; adds its derivative by F to *gradient.
template <class S>
S fibre_energy(const Mat<S>& F, S k, const Vec<S>& a, Mat<S>* gradient) {
  const Vec<S> now = F * a;
  const S e = now.squaredNorm() - a.squaredNorm();
  if (gradient) *gradient += S(0.5) * k * e * now * a.transpose();
  return S(0.125) * k * e * e;
}

/// stiffness * U(det F), and its derivative by F added to *gradient.
template <class S>
S volume_energy(const Mat<S>& F, S stiffness, VolumeLaw law, Mat<S>* gradient) {
  const S J = F.determinant();
  if (gradient) *gradient += stiffness * volume_pressure(law, J) * cofactor(F);
  return stiffness * volume_energy_density(law, J);
}

/// The d and u of F, and where asked for their derivatives by F.
template <class S>
struct HowFar {
  S d = 0, u = 0;
  Mat<S> by_d = Mat<S>::Zero(), by_u = Mat<S>::Zero();
};
template <class S>
HowFar<S> how_far(const Mat<S>& F) {
  const Mat<S> cof = cofactor(F);
  const S J = F.determinant(), I1 = F.squaredNorm(), I2 = cof.squaredNorm(), within = S(3) / (S(3) + I1);
  HowFar<S> of;
  if (I2 > S(1e-12) * I1 * I1 + S(1e-30)) {  // else two stretches are nothing beside the third, and d has no direction
    of.d = std::sqrt(S(3) / I2) * J;
    of.by_d = std::sqrt(S(3) / I2) * cof - of.d / I2 * (I1 * F - F * F.transpose() * F);
  }
  of.u = S(2) * of.d * within;
  of.by_u = S(2) * within * of.by_d - S(2) / S(3) * of.u * within * F;
  return of;
}

template <class S>
inline constexpr S end_of_law = S(0.6);  ///< u, below which the energy is not neo-Hookean alone
template <class S>
inline constexpr S begin_of_far = S(0.2);  ///< u, below which nothing of it is neo-Hookean

/// The share w of what the energy passes to, and its derivative by u.
template <class S>
struct Passage {
  S share, slope;
};
template <class S>
Passage<S> passage_at(S u) {
  const S width = end_of_law<S> - begin_of_far<S>, t = std::clamp((end_of_law<S> - u) / width, S(0), S(1));
  return {t * t * (S(3) - S(2) * t), S(-6) * t * (S(1) - t) / width};
}

/// (1 - w) mu/2 (J^(-2/3) |F|^2 - 3) + w times the far energy. Sets *gradient, to which others add.
template <class S>
S neo_hookean_energy(const Mat<S>& F, S mu, Mat<S>* gradient) {
  const HowFar<S> of = how_far(F);
  const Mat<S> H = F - Mat<S>::Identity();
  const S I1 = F.squaredNorm(), e = H.trace() + cofactor(H).trace() + H.determinant();
  const S J = S(1) + e > S(1e-9) ? S(1) + e : S(1), root = inverse_cube_root(J), g = root * root;
  // g - 1 = (root^3 - 1) (root + 1) / (root^2 + root + 1) and I1 - 3, so that small strains keep their digits.
  const S less = -e / J * (root + S(1)) / (g + root + S(1));
  const S near = S(0.5) * (less * I1 + (S(2) * H.trace() + H.squaredNorm()));
  const auto [w, slope] = passage_at(of.u);
  const S far = S(0.5) * I1 - S(2.5) * of.d + S(1.5);
  if (gradient) {
    const Mat<S> by_near = g * (F - I1 / (S(3) * J) * cofactor(F));
    *gradient = mu * ((S(1) - w) * by_near + w * (F - S(2.5) * of.by_d) + slope * (far - near) * of.by_u);
  }
  return mu * ((S(1) - w) * near + w * far);
}

/// (1 - k) X + k (e^(b X) - 1) / b, and its derivatives by X.
template <class S>
struct Exponential {
  S energy, slope, rise;
};
template <class S>
Exponential<S> exponential(S k, S b, S X) {
  const S t = std::min(b * X, S(most_exponent)), e = std::exp(t);
  const S grown = b > S(0) ? std::expm1(t) / b + e * (X - t / b) : X;
  return {(S(1) - k) * X + k * grown, S(1) + k * (e - S(1)), b * X < S(most_exponent) ? k * b * e : S(0)};
}

/// The energy of StrainEnergy::stiffening over mu, without K U(J), of X and, while the passage leaves anything of it,
/// of (1 - w) c (Y - X) / (1 + d X). `p`: EnergyConstants.
template <class S>
S stiffening_energy(const Mat<S>& F, const std::array<S, most_energy_constants>& p, Mat<S>* gradient) {
  const S k = p[2], b = p[3], c = p[4], d = p[5];
  Mat<S> by_X;
  const S X = S(2) * neo_hookean_energy(F, S(1), &by_X);
  const Exponential<S> first = exponential(k, b, X);
  S energy = S(0.5) * first.energy;
  if (gradient) *gradient = first.slope * by_X;
  const HowFar<S> of = how_far(F);
  const auto [w, slope] = passage_at(of.u);
  if (c == S(0) || !(w < S(1))) return energy;
  // cof(F) / J^(2/3) has the invariants of F / J^(1/3) in the other order: Y is X of it.
  const Mat<S> cof = cofactor(F);
  const S J = F.determinant(), g = std::pow(J, S(-2) / S(3)), I1 = F.squaredNorm(), I2 = cof.squaredNorm();
  const S near_X = g * I1 - S(3), Y = g * g * I2 - S(3), within = S(1) / (S(1) + d * near_X);
  const Mat<S> by_near_X = g * (F - I1 / (S(3) * J) * cof);
  const Mat<S> by_Y = g * g * (I1 * F - F * F.transpose() * F - S(2) * I2 / (S(3) * J) * cof);
  const S second = S(0.5) * c * (Y - near_X) * within;
  if (gradient) {
    *gradient += (S(1) - w) * (c * within * (by_Y - by_near_X) - S(2) * d * within * second * by_near_X) -
                 slope * second * of.by_u;
  }
  return energy + (S(1) - w) * second;
}

/// Lame's constants at rest, Pa.
template <class S>
struct Lame {
  S mu, lambda;
};
template <class S>
Lame<S> lame_at_rest(const std::array<S, most_energy_constants>& p) {
  return {p[0], p[1] - S(2) / S(3) * p[0]};
}

/// The change of dpsi/dF with F = I + H at H = 0: 2 mu sym(H) + lambda tr(H) I, and k (a . H a) a a^T along fibres.
template <class S>
Mat<S> stress_near_rest(StrainEnergy energy, const std::array<S, most_energy_constants>& p, const Mat<S>& H) {
  const auto [mu, lambda] = lame_at_rest(p);
  Mat<S> P = mu * (H + H.transpose()) + lambda * H.trace() * Mat<S>::Identity();
  if (energy != StrainEnergy::fibres) return P;
  const Vec<S> a(p[3], p[4], p[5]);
  return P + p[2] * a.dot(H * a) * a * a.transpose();
}

/// Bounds of StrainEnergy::stiffening: how much the stiffness of its shear rises over neo-Hookean's at X, and what
/// share of the largest eigenvalue at rest, about K + 4/3 mu, that is. The share is to be raised to growth_exponent(),
/// which (1 + e x)^(1/e) <= 1 + x takes into account. The factors 4 and 2 are calibrated, as that exponent is.
template <class S>
S stiffening_at(const std::array<S, most_energy_constants>& p, S X) {
  const Exponential<S> first = exponential(p[2], p[3], X);
  return first.slope - S(1) + S(2) * X * first.rise +
         S(4) * std::abs(p[4]) * std::sqrt(std::max(X, S(0))) / (S(1) + p[5] * X);
}
template <class S>
S share_of_shear(const std::array<S, most_energy_constants>& p) {
  return S(2) * p[0] * p[1] / ((p[1] + S(4) / S(3) * p[0]) * (p[1] + S(1.6) * p[0]));
}

/// The square of the condition number |F| |F^-1| by Frobenius' norm, over its value 9 at rest; |F|^2 |cof(F)|^2 / 9
/// where det F > 1; times what fibres or stiffening grow by. 1e6 where the energy is not what it is near rest, 2e6
/// where F is inverted.
template <class S>
S squared_condition(StrainEnergy energy, const std::array<S, most_energy_constants>& p, const Mat<S>& F) {
  const S J = F.determinant();
  if (!(how_far(F).u >= end_of_law<S>)) return J > S(0) ? S(1e6) : S(2e6);
  const S condition = F.squaredNorm() * cofactor(F).squaredNorm() / (S(9) * std::min(J * J, S(1)));
  if (energy == StrainEnergy::stiffening) {
    Mat<S> by_X;
    const S X = S(2) * neo_hookean_energy(F, S(1), &by_X);
    return std::min(condition * (S(1) + share_of_shear(p) * stiffening_at(p, X)), S(9e5));
  }
  if (energy != StrainEnergy::fibres) return condition;
  const Vec<S> a(p[3], p[4], p[5]);
  return condition * std::max(S(1), S(1) + S(1.5) * ((F * a).squaredNorm() - a.squaredNorm()));
}

/// psi(F), Pa, of the constants `p` (EnergyConstants), and where asked for its derivative by F.
template <class S>
S energy_density(const TopologyOptions& options, const std::array<S, most_energy_constants>& p, const Mat<S>& F,
                 Mat<S>* gradient) {
  if (gradient) gradient->setZero();
  if (options.strain_energy == StrainEnergy::stiffening) {
    const S shape = p[0] * stiffening_energy(F, p, gradient);
    if (gradient) *gradient *= p[0];
    return shape + volume_energy(F, p[1], options.volume_law, gradient);
  }
  S energy = neo_hookean_energy(F, p[0], gradient);
  if (options.strain_energy == StrainEnergy::fibres) {
    energy += fibre_energy(F, p[2], Vec<S>(p[3], p[4], p[5]), gradient);
  }
  return energy + volume_energy(F, p[1], options.volume_law, gradient);
}

}  // namespace phymul
