// SPDX-License-Identifier: MIT
//
// Where each part of a body is and how it lies, so that what is calibrated on it does not depend on how it is turned.
#pragma once

#include <phymul/model.h>

#include <functional>
#include <vector>

namespace phymul {

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
