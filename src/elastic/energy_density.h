// SPDX-License-Identifier: MIT
//
// The energies of a material per rest volume, as functions of the deformation gradient F (StrainEnergy in topology.h).
// That of shape memory is the energy of a base, charged at F and averaged over an isotropic set of base normals m:
//   W(F) = sum_m q_m 1/2 |n_m(F) - F m|^2,   n_m(F) = cof(F) m / |cof(F) m|
// The set is the four diagonals of a cube (0.15 each) and its three axes (2/15 each): its second and fourth moments are
// those of the sphere, so that small strains see exactly mu = 7/15, lambda = -1/5 per unit of stiffness.
#pragma once

#include <phymul/topology_textures.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/inverse_cube_root.h"
#include "force_volume.h"

namespace phymul::cpu {

template <class S>
using Mat = Eigen::Matrix<S, 3, 3>;

template <class S>
Mat<S> cofactor(const Mat<S>& F) {
  Mat<S> C;
  C << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return C;
}

template <class S>
struct ShapeDirection {
  Vec<S> m, t1, t2;  ///< right-handed orthonormal: t1 x t2 = m
  S weight;
};

template <class S>
const std::array<ShapeDirection<S>, 7>& shape_directions() {
  static const std::array<ShapeDirection<S>, 7> directions = [] {
    std::array<ShapeDirection<S>, 7> d;
    const S r = S(1) / std::sqrt(S(3));
    const std::array<Vec<S>, 7> normals{Vec<S>(r, r, r), Vec<S>(-r, r, r), Vec<S>(r, -r, r), Vec<S>(r, r, -r),
                                        Vec<S>(1, 0, 0), Vec<S>(0, 1, 0),  Vec<S>(0, 0, 1)};
    for (std::size_t i = 0; i < 7; ++i) {
      const Vec<S> helper = std::abs(normals[i].x()) < S(0.9) ? Vec<S>(1, 0, 0) : Vec<S>(0, 1, 0);
      const Vec<S> t1 = helper.cross(normals[i]).normalized();
      d[i] = {normals[i], t1, normals[i].cross(t1), i < 4 ? S(0.15) : S(2) / S(15)};
    }
    return d;
  }();
  return directions;
}

/// W(F) and, where asked for, dW/dF.
template <class S>
S shape_energy(const Mat<S>& F, Mat<S>* gradient) {
  S energy = 0;
  for (const ShapeDirection<S>& d : shape_directions<S>()) {
    const Vec<S> f1 = F * d.t1, f2 = F * d.t2, fm = F * d.m;
    const BaseFrame<S> base = base_frame_3d<S>(Vec<S>::Zero(), f1, f2);
    const Vec<S> r = base.n - fm;
    energy += S(0.5) * d.weight * r.squaredNorm();
    if (!gradient) continue;
    *gradient -= d.weight * r * d.m.transpose();
    if (base.n == Vec<S>::Zero()) continue;
    const Vec<S> G = (d.weight / base.length) * (r - base.n.dot(r) * base.n);
    *gradient += f2.cross(G) * d.t1.transpose() + G.cross(f1) * d.t2.transpose();
  }
  return energy;
}

/// k/8 (|F a|^2 - 1)^2, and its derivative by F added to *gradient.
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

/// mu/2 (g(J) tr(F^T F) - 3) with g = J^(-2/3), below J = 0.7 its tangent there: squashed further, the true energy is
/// so stiff that steps of half the limit would not be stable. The tangent alone would let a body gain energy by
/// shrinking to a point; 3.1 mu (0.7 - J)^2, added there, makes up for it.
template <class S>
S neo_hookean_energy(const Mat<S>& F, S mu, Mat<S>* gradient) {
  const S J = F.determinant(), kink = std::max(J, S(0.7)), root = inverse_cube_root(kink), at_kink = root * root;
  const S slope = S(-2) / S(3) * at_kink / kink, g = at_kink + slope * (J - kink);
  const S below = kink - J;
  if (gradient) *gradient = mu * (g * F + (S(0.5) * slope * F.squaredNorm() - S(6.2) * below) * cofactor(F));
  return mu * (S(0.5) * (g * F.squaredNorm() - S(3)) + S(3.1) * below * below);
}

/// Lame's constants at rest, Pa.
template <class S>
struct Lame {
  S mu, lambda;
};
template <class S>
Lame<S> lame_at_rest(StrainEnergy energy, const std::array<S, most_energy_constants>& p) {
  if (energy == StrainEnergy::neo_hookean) return {p[0], p[1] - S(2) / S(3) * p[0]};
  return {S(7) / S(15) * p[0], p[1] - p[0] / S(5)};  // Calibration in topology.h
}

/// The change of dpsi/dF with F = I + H at H = 0: 2 mu sym(H) + lambda tr(H) I, and k (a . H a) a a^T along fibres.
template <class S>
Mat<S> stress_near_rest(StrainEnergy energy, const std::array<S, most_energy_constants>& p, const Mat<S>& H) {
  const auto [mu, lambda] = lame_at_rest(energy, p);
  Mat<S> P = mu * (H + H.transpose()) + lambda * H.trace() * Mat<S>::Identity();
  if (energy != StrainEnergy::fibres) return P;
  const Vec<S> a(p[3], p[4], p[5]);
  return P + p[2] * a.dot(H * a) * a * a.transpose();
}

/// The square of the condition number |F| |F^-1| by Frobenius' norm, over its value 9 at rest; |F|^2 |cof(F)|^2 / 9
/// where det F > 1; times what fibres grow by. 1e6 below det F = 0.7, where laws change.
template <class S>
S squared_condition(StrainEnergy energy, const std::array<S, most_energy_constants>& p, const Mat<S>& F) {
  const S J = F.determinant(), huge = S(1e6);
  if (!(J > S(0.7))) return huge;
  const S condition = F.squaredNorm() * cofactor(F).squaredNorm() / (S(9) * std::min(J * J, S(1)));
  if (energy != StrainEnergy::fibres) return condition;
  const Vec<S> a(p[3], p[4], p[5]);
  return condition * std::max(S(1), S(1) + S(1.5) * ((F * a).squaredNorm() - a.squaredNorm()));
}

/// psi(F), Pa, of the constants `p` (EnergyConstants), and where asked for its derivative by F.
template <class S>
S energy_density(const TopologyOptions& options, const std::array<S, most_energy_constants>& p, const Mat<S>& F,
                 Mat<S>* gradient) {
  if (gradient) gradient->setZero();
  S energy = 0;
  switch (options.strain_energy) {
    case StrainEnergy::shape_memory:
      energy = p[0] * shape_energy(F, gradient);
      if (gradient) *gradient *= p[0];
      break;
    case StrainEnergy::fibres:
      energy = p[0] * shape_energy(F, gradient);
      if (gradient) *gradient *= p[0];
      energy += fibre_energy(F, p[2], Vec<S>(p[3], p[4], p[5]), gradient);
      break;
    case StrainEnergy::neo_hookean:
      energy = neo_hookean_energy(F, p[0], gradient);
      break;
  }
  return energy + volume_energy(F, p[1], options.volume_law, gradient);
}

}  // namespace phymul::cpu
