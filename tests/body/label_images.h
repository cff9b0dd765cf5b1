// SPDX-License-Identifier: MIT
//
// Labelled images of shapes in closed form.
#pragma once

#include <phymul/labels.h>

#include <cstdint>

#include "body_shapes.h"

namespace phymul::test {

/// A cube of `count` voxels along each side of 0.12 m around the origin; label_at gives that of a place.
template <class LabelAt>
LabelImage painted(Index count, const LabelAt& label_at) {
  const double side = 0.12, voxel = side / count;
  LabelImage image;
  image.size = {count, count, count};
  image.origin = Vec3::Constant(0.5 * (voxel - side));
  for (int axis = 0; axis < 3; ++axis) image.step[axis] = voxel * Vec3::Unit(axis);
  for (Index k = 0; k < count; ++k) {
    for (Index j = 0; j < count; ++j) {
      for (Index i = 0; i < count; ++i) {
        image.label.push_back(static_cast<std::uint16_t>(label_at(Vec3(image.origin + voxel * Vec3(i, j, k)))));
      }
    }
  }
  return image;
}

/// Of radius 0.05, label 1, with one of `radius`, label 2, in its middle.
inline LabelImage ball_in_ball(Index count, double radius) {
  return painted(count, [=](const Vec3& x) { return x.norm() > 0.05 ? 0 : x.norm() > radius ? 1 : 2; });
}

/// A random solid; each place in it belongs to the nearest of 2 to 6 centres.
inline LabelImage random_labels(std::uint32_t seed) {
  const Solid solid = random_solid(seed);
  std::mt19937 bits(seed);
  VecList centres(2 + seed % 5);
  for (Vec3& centre : centres) centre = 0.05 * random_vector(bits, 3);
  return painted(48, [&](const Vec3& x) {
    if (solid.distance(x) > 0.0) return 0;
    int nearest = 0;
    for (int k = 1; k < static_cast<int>(centres.size()); ++k) {
      if ((x - centres[k]).norm() < (x - centres[nearest]).norm()) nearest = k;
    }
    return nearest + 1;
  });
}

}  // namespace phymul::test
