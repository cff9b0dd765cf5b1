// SPDX-License-Identifier: MIT
//
// Law::walls: energy and forces of a triangle with its patch, in double precision, from the formulas in topology.h. The
// membrane is neo-Hookean in plane stress: with the stretch of area s and I = |F|^2, J minimises
//   psi = mu/2 (J^(-2/3) I + J^(4/3) f(s) - 3) + K/2 (J - 1)^2,   f(s) = 1/s^2
// where J/s is the stretch of the thickness: the first two terms are J^(-2/3) (I + (J/s)^2). Below s = 0.36 f is
// replaced by its tangent, below 0.03 by a parabola. So a wall that is crushed to a line or a point has a finite
// energy, and opens again.
#pragma once

#include <phymul/topology_textures.h>

#include <Eigen/Geometry>
#include <cmath>
#include <span>

namespace phymul {

inline constexpr double least_area_stretch = 0.36;  ///< where f becomes linear
inline constexpr double least_normal = 0.03;        ///< s below which the normal is no longer scaled to unit length

/// f and f' / s.
struct AreaLaw {
  double f, slope;
};
inline AreaLaw area_law(double s) {
  constexpr double s0 = least_area_stretch, cube = s0 * s0 * s0;
  if (s >= s0) return {1.0 / (s * s), -2.0 / (s * s * s * s)};
  const double scale = std::max(s, least_normal);
  return {(3.0 * s0 - 2.0 * scale + (scale * scale - s * s) / scale) / cube, -2.0 / (cube * scale)};
}

/// The ratio of volumes J of plane stress. `compliance`: 2 mu / (3 K).
inline double plane_stress_ratio(double I, double f, double compliance) {
  double J = 1.0;
  for (int k = 0; k < 60; ++k) {
    const double J23 = std::cbrt(J * J), h = (J - 1.0) * J * J23 + compliance * (J * J * f - 0.5 * I);
    const double slope = J * J23 + 5.0 / 3.0 * (J - 1.0) * J23 + 2.0 * compliance * J * f;
    const double next = std::max(J - h / slope, 0.1 * J);
    if (next == J) break;
    J = next;
  }
  return J;
}

/// frequency_growth() of a body of walls alone, by the largest wall_stiffening(). That is over 4 mu; the modulus at
/// rest, at which J is free, is 2 mu / (1 - nu). As that of domains it may be too low, by 15 %.
inline double growth_of_walls(const TopologyTextures& t, double stiffening) {
  double compliance = 0.0;  // (1 - 2 nu) / (1 + nu)
  for (const WallTexel& w : t.walls) compliance = std::max(compliance, w.compliance);
  return std::max(1.0, stiffening * std::max(1.0, (2.0 + 4.0 * compliance) / (2.0 + compliance) / 1.15));
}

/// Whether nothing else of the model is elastic.
inline bool has_walls_alone(const TopologyTextures& t) {
  return !t.walls.empty() && t.domains.empty() && t.base_count == 0 && t.springs.empty() && t.volumes.empty();
}

/// F, and second derivatives of positions in place of those of `second`.
inline Eigen::Matrix<double, 3, 2> wall_gradient(const WallTexel& w, std::span<const Vec3> rest,
                                                 std::span<const Vec3> x, std::array<Vec3, 3>& second) {
  Eigen::Matrix<double, 3, 2> F;
  F << w.tangent[0], w.tangent[1];
  second = w.second;
  const Index first = w.vertex[0];
  for (std::size_t k = 1; k < 6; ++k) {
    if (w.vertex[k] == none) continue;
    const Vec3 u = (x[w.vertex[k]] - rest[w.vertex[k]]) - (x[first] - rest[first]);
    for (int a = 0; a < 2; ++a) F.col(a) += w.gradient[k][a] * u;
    for (std::size_t ab = 0; ab < 3; ++ab) second[ab] += w.hessian[k][ab] * u;
  }
  return F;
}

/// By how much the membrane has stiffened along its shortest principal stretch, at a fixed J, over 4 mu at rest:
/// J^(-2/3) (1 + 3 (J / s)^2 / stretch^2) / 4.
inline double wall_stiffening(const WallTexel& w, std::span<const Vec3> rest, std::span<const Vec3> x) {
  if (w.shear == 0.0) return 0.0;  // removed
  std::array<Vec3, 3> second;
  const Eigen::Matrix<double, 3, 2> F = wall_gradient(w, rest, x, second);
  const double s = F.col(0).cross(F.col(1)).norm(), I = F.squaredNorm();
  const double J = plane_stress_ratio(I, area_law(s).f, w.compliance), J23 = std::cbrt(J * J);
  const double held = std::max(s * s, least_normal * least_normal), apart = std::max(I * I - 4.0 * held, 0.0);
  return 0.25 * (1.0 / J23 + 1.5 * J23 * J23 * (I + std::sqrt(apart)) / (held * held));
}

/// J. `x`: positions of the model; `force`: added to, N, where it is not empty.
inline double wall_energy(const WallTexel& w, std::span<const Vec3> rest, std::span<const Vec3> x,
                          std::span<Vec3> force) {
  std::array<Vec3, 3> second;
  const Eigen::Matrix<double, 3, 2> F = wall_gradient(w, rest, x, second);
  const Index first = w.vertex[0];
  const Vec3 c = F.col(0).cross(F.col(1)), N = w.tangent[0].cross(w.tangent[1]);
  const double s = c.norm(), scale = std::max(s, least_normal), I = F.squaredNorm();
  const AreaLaw area = area_law(s);
  const double J = plane_stress_ratio(I, area.f, w.compliance), J23 = std::cbrt(J * J);
  // K / mu = 2 / (3 compliance)
  double energy =
      w.shear * (0.5 * (I / J23 + J * J / J23 * area.f - 3.0) + (J - 1.0) * (J - 1.0) / (3.0 * w.compliance));
  const Vec3 n = c / scale;
  Vec3 k;
  for (int ab = 0; ab < 3; ++ab) k[ab] = n.dot(second[ab]) - N.dot(w.second[ab]);
  Mat3 C;
  C << w.bending[0], w.bending[5], w.bending[4], w.bending[5], w.bending[1], w.bending[3], w.bending[4], w.bending[3],
      w.bending[2];
  const Vec3 moment = C * k;
  energy += 0.5 * moment.dot(k);
  if (force.empty()) return energy;

  Vec3 by_normal = moment[0] * second[0] + moment[1] * second[1] + moment[2] * second[2];
  if (s > least_normal) by_normal -= n.dot(by_normal) * n;
  const Vec3 by_c = by_normal / scale + w.shear * 0.5 * J * J / J23 * area.slope * c;
  const Vec3 P1 = w.shear / J23 * F.col(0) + F.col(1).cross(by_c), P2 = w.shear / J23 * F.col(1) + by_c.cross(F.col(0));
  for (std::size_t k_ = 1; k_ < 6; ++k_) {
    if (w.vertex[k_] == none) continue;
    const auto& h = w.hessian[k_];
    const Vec3 pull =
        w.gradient[k_][0] * P1 + w.gradient[k_][1] * P2 + (h[0] * moment[0] + h[1] * moment[1] + h[2] * moment[2]) * n;
    force[w.vertex[k_]] -= pull;
    force[first] += pull;
  }
  return energy;
}

}  // namespace phymul
