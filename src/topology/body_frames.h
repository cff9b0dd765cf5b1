// SPDX-License-Identifier: MIT
//
// Where each part of a body is and how it lies, so that what is calibrated on it does not depend on how it is turned.
#pragma once

#include <phymul/model.h>
#include <phymul/types.h>

#include <functional>
#include <vector>

namespace phymul {

/// Products of the coordinates of a vector: xx, yy, zz, xy, yz, zx.
using Products = Eigen::Matrix<double, 6, 1>;

inline Products products(const Vec3& x) {
  return {x.x() * x.x(), x.y() * x.y(), x.z() * x.z(), x.x() * x.y(), x.y() * x.z(), x.z() * x.x()};
}

/// (p . x) (q . x) is their dot product with products(x).
inline Products product_weights(const Vec3& p, const Vec3& q) {
  const Mat3 both = p * q.transpose();
  return {
      both(0, 0), both(1, 1), both(2, 2), both(0, 1) + both(1, 0), both(1, 2) + both(2, 1), both(2, 0) + both(0, 2)};
}

struct BodyFrame {
  Vec3 centre = Vec3::Zero();
  Mat3 axes = Mat3::Identity();  ///< columns
};

/// A function that calls its argument with the numbers of each two particles that belong together.
using ParticlePairs = std::function<void(const std::function<void(Index, Index)>&)>;

/// Frames of the parts that no pair joins.
class BodyFrames {
 public:
  /// `volume` [N]: of each particle; those of none count nowhere. The axes are the principal ones of the volume. Where
  /// a part is about as long along two of them, these lie as the pairs do: along the edges of a lattice, not between
  /// them.
  BodyFrames(const Model& model, const std::vector<double>& volume, const ParticlePairs& pairs);

  Index part(Index particle) const { return part_[particle]; }
  const BodyFrame& of_part(Index part) const { return frames_[part]; }
  /// Place of a particle in the frame of its part.
  Vec3 local(Index particle) const {
    const BodyFrame& frame = frames_[part_[particle]];
    return frame.axes.transpose() * (model_.rest[particle] - frame.centre);
  }
  Index parts() const { return static_cast<Index>(frames_.size()); }

 private:
  const Model& model_;
  std::vector<Index> part_;  // [N]
  std::vector<BodyFrame> frames_;
};

// Pure bending in linear elasticity, which the stabiliser is calibrated by (stabiliser.cpp).

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
