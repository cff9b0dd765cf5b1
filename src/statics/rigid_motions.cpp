// SPDX-License-Identifier: MIT
#include "rigid_motions.h"

#include <algorithm>

#include "base/symmetric_modes.h"

namespace phymul {
namespace {

/// Of the largest resistance that supports give to a rigid motion: less is none.
constexpr double unsupported = 1e-9;

}  // namespace

std::vector<RigidMotion> free_motions(std::span<const Index> particles, std::span<const Vec3> position,
                                      std::span<const std::uint8_t> fixed) {
  Vec3 centre = Vec3::Zero();
  for (const Index i : particles) centre += position[i] / static_cast<double>(particles.size());
  double size = 1e-300;  // of a single particle
  for (const Index i : particles) size = std::max(size, (position[i] - centre).norm());
  Eigen::MatrixXd support = Eigen::MatrixXd::Zero(6, 6);
  for (const Index i : particles) {
    for (int axis = 0; axis < 3 && !fixed.empty(); ++axis) {
      if ((fixed[i] >> axis & 1) == 0) continue;
      Eigen::Matrix<double, 6, 1> along;  // how far shift and turn * size displace the particle along the axis
      along << Vec3::Unit(axis), (position[i] - centre).cross(Vec3::Unit(axis)) / size;
      support += along * along.transpose();
    }
  }
  const SymmetricModes modes = symmetric_modes(support);
  const double largest = std::max(1.0, modes.values[5]);
  std::vector<RigidMotion> motions;
  for (int k = 0; k < 6; ++k) {
    if (modes.values[k] > unsupported * largest) continue;
    const auto mode = modes.vectors.col(k);
    motions.push_back({centre, mode.head<3>(), mode.tail<3>() / size});
  }
  return motions;
}

}  // namespace phymul
