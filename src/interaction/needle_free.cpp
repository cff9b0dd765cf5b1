// SPDX-License-Identifier: MIT
//
// Where a needle goes that was let go: as a rigid body of no mass, so that what it gives to the tissue has no sum.
#include <Eigen/Cholesky>
#include <algorithm>

#include "needle_path.h"

namespace phymul {
namespace {

constexpr double least_inverse_mass = 1e-9;  // 1/kg, of a node that nothing moves
constexpr double of_newton = 0.5;            // step, where impulses have not settled between two of them

/// Velocity of the point at `arm`, by that of the centre and the turning.
Eigen::Matrix<double, 3, 6> motion_at(const Vec3& arm) {
  Eigen::Matrix<double, 3, 6> motion;
  const Mat3 turning = (Mat3() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0).finished();
  motion << Mat3::Identity(), turning;
  return motion;
}

ToolPose moved_by(const ToolPose& from, const Vec3& centre, const Eigen::Vector<double, 6>& way) {
  const Vec3 turn = way.tail<3>();
  const double angle = turn.norm();
  const Eigen::Quaterniond by(Eigen::AngleAxisd(angle, angle > 0.0 ? Vec3(turn / angle) : Vec3(Vec3::UnitX())));
  return {.position = centre + way.head<3>() + by * (from.position - centre),
          .orientation = Quaternion(by * Eigen::Quaterniond(from.orientation)).normalized()};
}

}  // namespace

/// The rigid motion that comes nearest to that of the tissue by itself, weighted by what the nodes resist together.
/// Nodes are patches of the size of the spread, which resist a needle that turns about the line between them.
ToolPose NeedlePath::carried(TouchedParticles& touched, const ToolPose& start) {
  const ShaftLine line(needle_, start);
  held_.clear();
  VecList way;  // m
  centre_.setZero();
  for (std::size_t k = 0; k < state_.hole.size(); ++k) {
    coupled_[k].arm = line.place(coupled_[k].along);
    if (is_ahead_of_tip(needle_, coupled_[k].along)) continue;
    held_.push_back(k);
    way.push_back(place_at_end(k, touched) - coupled_[k].arm);
    centre_ += coupled_[k].arm;
  }
  const auto count = static_cast<Eigen::Index>(held_.size());
  if (count > 0) centre_ /= static_cast<double>(count);
  for (std::size_t k = 0; k < state_.hole.size(); ++k) coupled_[k].arm -= centre_;
  Eigen::MatrixXd gives = Eigen::MatrixXd::Zero(count, count);  // 1/kg
  for (Eigen::Index row = 0; row < count; ++row) {
    for (const Reached& reached : coupled_[held_[row]].reached) {
      const auto column = std::ranges::lower_bound(held_, reached.node);
      if (column != held_.end() && *column == reached.node) gives(row, column - held_.begin()) = reached.inverse_mass;
    }
    gives(row, row) += slack * gives(row, row) + least_inverse_mass;
  }
  const Eigen::MatrixXd resists = gives.llt().solve(Eigen::MatrixXd::Identity(count, count));  // kg
  rigid_.setZero();
  Eigen::Vector<double, 6> value = Eigen::Vector<double, 6>::Zero();
  for (Eigen::Index row = 0; row < count; ++row) {
    const Eigen::Matrix<double, 6, 3> own = motion_at(coupled_[held_[row]].arm).transpose();
    for (Eigen::Index column = 0; column < count; ++column) {
      rigid_ += resists(row, column) * own * motion_at(coupled_[held_[column]].arm);
      value += resists(row, column) * own * way[column];
    }
  }
  if (count == 0) return {.position = start.position, .orientation = start.orientation};
  rigid_.diagonal().tail<3>().array() += 0.25 * spread_ * spread_ * resists.sum();
  return moved_by(start, centre_, rigid_.ldlt().solve(value));
}

/// A pose at which the impulses so far would have less of a sum.
ToolPose NeedlePath::balanced(const ToolPose& end, double dt) const {
  if (held_.empty()) return end;
  Eigen::Vector<double, 6> given = Eigen::Vector<double, 6>::Zero();
  for (std::size_t k = 0; k < state_.hole.size(); ++k) {
    const Coupled& node = coupled_[k];
    given += motion_at(node.arm).transpose() * (node.sideways + (node.rubbed - node.pushed) * node.axis);
  }
  return moved_by(end, centre_, rigid_.ldlt().solve(-of_newton * dt * given));
}

}  // namespace phymul
