// SPDX-License-Identifier: MIT
//
// Pure bending in linear elasticity, which the stabiliser is calibrated by (stabiliser.cpp).
#pragma once

#include <phymul/model.h>

#include <vector>

namespace phymul {

/// Bending along axis a about the plane x_b = 0.
struct Bending {
  int a, b, c;
};

inline std::vector<Bending> bendings(int dimension) {
  if (dimension == 2) return {{0, 1, 2}, {1, 0, 2}};
  return {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
}

/// Constants per unit of Young's modulus.
struct Elastic {
  double mu, lambda;
  double poisson, young;  ///< of the bending field: those of plane strain in 2-D

  Elastic(const Material& material, int dimension) {
    const double nu = material.poisson;
    mu = 0.5 / (1.0 + nu);
    lambda = nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    poisson = dimension == 2 ? nu / (1.0 - nu) : nu;
    young = dimension == 2 ? 1.0 / (1.0 - nu * nu) : 1.0;
  }

  /// Energy density of the strain in a displacement gradient.
  double energy(const Mat3& H) const {
    const Mat3 strain = 0.5 * (H + H.transpose());
    return mu * strain.squaredNorm() + 0.5 * lambda * strain.trace() * strain.trace();
  }
};

inline Vec3 bent(const Vec3& x, const Bending& way, double nu, int dimension) {
  const double across = dimension == 2 ? 0.0 : x[way.c];
  Vec3 u = Vec3::Zero();
  u[way.a] = x[way.a] * x[way.b];
  u[way.b] = -0.5 * (x[way.a] * x[way.a] + nu * (x[way.b] * x[way.b] - across * across));
  if (dimension == 3) u[way.c] = -nu * x[way.b] * across;
  return u;
}

}  // namespace phymul
