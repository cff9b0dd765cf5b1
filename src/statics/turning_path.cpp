// SPDX-License-Identifier: MIT
#include "turning_path.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace phymul {

TurningPath::TurningPath(const TopologyTextures& topology, const GridLevel& level) : level_(level) {
  for (const Vec3& rest : topology.rest) places_.push_back(level.place_of(rest));
  solver_.compute(level.laplacian().sparse());
}

void TurningPath::bend(std::span<const Mat3> at, std::span<const Mat3> change, Eigen::VectorXd& d) {
  std::vector<Mat3> missing(at.size(), Mat3::Zero());
  for (std::size_t k = 0; k < at.size(); ++k) {
    const Mat3 F = Mat3::Identity() + at[k];
    if (!(F.determinant() > 0.1)) continue;  // a collapsed or inverted domain has no rotation to speak of
    const Mat3 L = change[k] * F.inverse();
    const Vec3 axial(0.5 * (L(2, 1) - L(1, 2)), 0.5 * (L(0, 2) - L(2, 0)), 0.5 * (L(1, 0) - L(0, 1)));
    const double angle = axial.norm();
    if (!(angle > 0.0)) continue;
    const Mat3 turn = Eigen::AngleAxisd(angle, axial / angle).toRotationMatrix();
    const Mat3 strain = 0.5 * (L + L.transpose());
    missing[k] = turn * (F + strain * F) - F - change[k];
  }
  Eigen::VectorXd b;
  level_.sources(missing, b);
  const Eigen::VectorXd added = solver_.solve(b);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Vec3 value = Vec3::Zero();
    for (int a = 0; a < 8; ++a) value += places_[i].weight[a] * added.segment<3>(3 * places_[i].node[a]);
    d.segment<3>(3 * static_cast<Eigen::Index>(i)) += value;
  }
}

}  // namespace phymul
