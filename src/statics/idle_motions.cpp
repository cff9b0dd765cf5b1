// SPDX-License-Identifier: MIT
#include "idle_motions.h"

#include <algorithm>
#include <cmath>

#include "base/symmetric_modes.h"

namespace phymul {
namespace {

/// Of the largest resistance that supports give to a rigid motion: less is none.
constexpr double unsupported = 1e-9;

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Of what terms resist a rigid motion with at most: less is rounding.
constexpr double unresisted_share = 1e-9;

/// Those of these particles.
Vector part_of(const Vector& v, std::span<const Index> particles) {
  Vector part(3 * static_cast<Eigen::Index>(particles.size()));
  for (std::size_t k = 0; k < particles.size(); ++k) {
    part.segment<3>(3 * static_cast<Eigen::Index>(k)) = v.segment<3>(3 * static_cast<Eigen::Index>(particles[k]));
  }
  return part;
}

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

/// Of the motions that no imposed coordinate resists, combinations that no term resists. [3 particles, motions]
Matrix IdleMotions::unresisted(const ConnectedBody& body, std::span<const Vec3> position, const Vector& free) const {
  const std::vector<RigidMotion> motions = free_motions(body.particles, position, loads_.fixed);
  Matrix along(3 * static_cast<Eigen::Index>(body.particles.size()), static_cast<Eigen::Index>(motions.size()));
  Matrix resisted = along;
  Vector d, force;
  for (Eigen::Index m = 0; m < along.cols(); ++m) {
    d = force = Vector::Zero(free.size());
    for (const Index i : body.particles) {
      d.segment<3>(3 * static_cast<Eigen::Index>(i)) = motions[static_cast<std::size_t>(m)].at(position[i]);
    }
    d.array() *= free.array();
    for (const RestTerm* term : terms_) term->add_product(d, force);
    along.col(m) = part_of(d, body.particles);
    resisted.col(m) = part_of(force, body.particles);
  }
  if (along.cols() == 0) return along;
  const SymmetricModes modes = symmetric_modes(along.transpose().lazyProduct(resisted));
  const Vector& resistance = modes.values;
  Eigen::Index count = 0;
  while (count < resistance.size() && !(resistance[count] > unresisted_share * resistance[resistance.size() - 1])) {
    ++count;
  }
  return along.lazyProduct(modes.vectors.leftCols(count));
}

void IdleMotions::find(std::span<const Vec3> position, const Vector& free, const Vector& residual, double idle) {
  idle_.clear();
  for (const ConnectedBody& body : loose_) {
    const Matrix motions = unresisted(body, position, free);
    const Vector own = part_of(residual, body.particles);
    OfBody found{body.particles, Matrix(motions.rows(), 0)};
    for (Eigen::Index m = 0; m < motions.cols(); ++m) {
      Vector along = motions.col(m);
      along -= found.along * (found.along.transpose() * along).eval();
      along.normalize();
      if (std::abs(along.dot(own)) > idle) continue;
      found.along.conservativeResize(Eigen::NoChange, found.along.cols() + 1);
      found.along.rightCols<1>() = along;
    }
    if (found.along.cols() > 0) idle_.push_back(std::move(found));
  }
}

void IdleMotions::remove(Vector& v) const {
  for (const OfBody& body : idle_) {
    const Vector part = body.along * (body.along.transpose() * part_of(v, body.particles)).eval();
    for (std::size_t k = 0; k < body.particles.size(); ++k) {
      v.segment<3>(3 * static_cast<Eigen::Index>(body.particles[k])) -=
          part.segment<3>(3 * static_cast<Eigen::Index>(k));
    }
  }
}

}  // namespace phymul
