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

}  // namespace phymul
