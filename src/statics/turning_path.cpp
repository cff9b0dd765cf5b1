// SPDX-License-Identifier: MIT
#include "turning_path.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

namespace phymul {

TurningPath::TurningPath(const TopologyTextures& topology, const GridLevel& level) : level_(level) {
  for (const Vec3& rest : topology.rest) places_.push_back(level.place_of(rest));
  Eigen::SparseMatrix<double> last;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::SparseMatrix<double> matrix = level.laplacian(axis);
    const bool same = axis > 0 && std::equal(matrix.valuePtr(), matrix.valuePtr() + matrix.nonZeros(), last.valuePtr());
    if (!same) solvers_[axis] = std::make_unique<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>(matrix);
    last.swap(matrix);
  }
}

void TurningPath::bend(std::span<const Mat3> at, std::span<const Mat3> change, double share, Eigen::VectorXd& added) {
  missing_.assign(at.size(), Mat3::Zero());
  for (std::size_t k = 0; k < at.size(); ++k) {
    const Mat3 F = Mat3::Identity() + at[k];
    if (!(F.determinant() > 0.1)) continue;  // a collapsed or inverted domain has no rotation to speak of
    const Mat3 L = share * change[k] * F.inverse();
    const Vec3 axial(0.5 * (L(2, 1) - L(1, 2)), 0.5 * (L(0, 2) - L(2, 0)), 0.5 * (L(1, 0) - L(0, 1)));
    const double angle = axial.norm();
    if (!(angle > 0.0)) continue;
    const Mat3 turn = Eigen::AngleAxisd(angle, axial / angle).toRotationMatrix();
    const Mat3 strain = 0.5 * (L + L.transpose());
    missing_[k] = turn * (F + strain * F) - F - share * change[k];
  }
  Eigen::VectorXd b;
  level_.sources(missing_, b);
  Eigen::VectorXd at_nodes(b.size());
  const auto* solver = solvers_.front().get();
  for (int axis = 0; axis < 3; ++axis) {
    if (solvers_[axis] != nullptr) solver = solvers_[axis].get();
    const Eigen::VectorXd along = b(Eigen::seqN(axis, level_.nodes(), 3));
    at_nodes(Eigen::seqN(axis, level_.nodes(), 3)) = solver->solve(along).eval();
  }
  added.resize(3 * static_cast<Eigen::Index>(places_.size()));
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Vec3 value = Vec3::Zero();
    for (int a = 0; a < 8; ++a)
      value += static_cast<double>(places_[i].weight[a]) * at_nodes.segment<3>(3 * places_[i].node[a]);
    added.segment<3>(3 * static_cast<Eigen::Index>(i)) = value;
  }
}

}  // namespace phymul
