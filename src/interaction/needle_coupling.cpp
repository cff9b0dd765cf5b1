// SPDX-License-Identifier: MIT
//
// What a needle's nodes are to each other in a step, before any impulse: who rubs over which length, and whom an
// impulse on one of them moves.
#include <Eigen/Cholesky>
#include <algorithm>

#include "needle_path.h"

namespace phymul {
namespace {

// Where a needle goes that was let go: as a rigid body of no mass, so that what it gives to the tissue has no sum.

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

/// All nodes but the one ahead of the tip.
bool NeedlePath::on_shaft(std::size_t node) const {
  const bool end = node + 1 == state_.hole.size() && !state_.through;
  return !end && coupled_[node].along > 0.0;
}

/// Each node on the shaft rubs over half of the way to the next ones of its hole; the first up to the surface, the last
/// to the tip or to where the shaft comes out.
void NeedlePath::share_out_length() {
  double above = -1.0;  // along, of the border to the node before
  for (std::size_t k = 0; k < state_.hole.size(); ++k) {
    Coupled& node = coupled_[k];
    node.length = 0.0;
    if (!on_shaft(k)) continue;
    if (above < 0.0) above = node.along;
    const bool last = k + 1 == state_.hole.size() || !on_shaft(k + 1), out = state_.hole[k].out;
    const double inside = last ? 0.0 : 0.5 * (node.along + coupled_[k + 1].along);
    const double below = out ? node.along : inside;
    node.length = std::max(0.0, above - below);
    above = out ? -1.0 : below;
  }
}

void NeedlePath::couple(TouchedParticles& touched, const ShaftLine& start) {
  const std::size_t count = state_.hole.size();
  if (coupled_.size() < count) coupled_.resize(2 * count);
  for (std::size_t k = 0; k < count; ++k) {
    const NeedleNode& node = state_.hole[k];
    Coupled& coupled = coupled_[k];
    coupled.slots.clear();
    coupled.rubbed = coupled.pushed = 0.0;
    coupled.sideways.setZero();
    coupled.slides = node.slides;
    Vec3 x = Vec3::Zero();
    for (std::size_t j = 0; j < node.particles.size(); ++j) {
      coupled.slots.push_back(touched.slot(node.particles[j]));
      x += node.weights[j] * touched[coupled.slots[j]].position;
    }
    coupled.along = start.along(x);
  }
  couple_nodes(touched);
  share_out_length();
}

/// Of friction and of the tip. What is within a spread of the tip loads the same tissue, so that together they get no
/// more than that bears.
void NeedlePath::limit(double turned, double dt) {
  const double tip_bears = bears(state_.hole.back());
  double beside_tip = 0.0;  // N
  for (std::size_t k = 0; k < state_.hole.size(); ++k) {
    Coupled& node = coupled_[k];
    const bool slides = state_.hole[k].slides || turned != 0.0;
    const double friction = (slides ? needle_.kinetic_friction : needle_.static_friction) * node.length;
    const double most = std::min(friction, 0.75 * bears(state_.hole[k]));
    node.limit = most * dt;
    if (node.along - coupled_[state_.hole.size() - 1].along < spread_) beside_tip += most;
  }
  const double rest = tip_bears - std::min(beside_tip, 0.75 * tip_bears);
  const double inside = state_.hole.back().out ? std::max(needle_.leaving, needle_.cutting) : needle_.cutting;
  most_push_ = std::min(state_.punctured ? inside : needle_.puncture, rest);
}

/// Which nodes an impulse on each of them moves. Sweeps then go from node to node, not over the particles of each, of
/// which there are dozens.
void NeedlePath::couple_nodes(TouchedParticles& touched) {
  const std::size_t count = state_.hole.size();
  share_of_.assign(touched.count(), 0.0);
  for (std::size_t k = 0; k < count; ++k) {
    coupled_[k].reached.clear();
    coupled_[k].inverse_mass = 0.0;
  }
  for (std::size_t k = 0; k < count; ++k) {
    Coupled& node = coupled_[k];
    for (std::size_t j = 0; j < node.slots.size(); ++j) {
      const TouchedParticles::Touched& particle = touched[node.slots[j]];
      const bool rounds =
          std::abs(state_.hole[k].weights[j]) < 1e-12;  // else it would decide whether the node can move
      if (particle.fixed != 7 && !particle.held && !rounds) {
        share_of_[node.slots[j]] = state_.hole[k].weights[j] * particle.inverse_mass;
      }
    }
    for (std::size_t l = k; l < count; ++l) {
      Coupled& other = coupled_[l];
      Reached reached{.node = l};
      bool any = false;
      Vec3 fixed = Vec3::Zero();  // 1/kg along coordinates that are not free
      for (std::size_t j = 0; j < other.slots.size(); ++j) {
        const double share = share_of_[other.slots[j]];
        if (share == 0.0) continue;
        any = true;
        const double both = state_.hole[l].weights[j] * share;
        reached.inverse_mass += both;
        const std::uint8_t at = touched[other.slots[j]].fixed;
        for (int a = 0; at != 0 && a < 3; ++a) fixed[a] += (at >> a & 1) != 0 ? both : 0.0;
      }
      if (!any) continue;
      reached.along_axes = Vec3::Constant(reached.inverse_mass) - fixed;
      node.reached.push_back(reached);
      reached.node = k;
      if (l != k) other.reached.push_back(reached);
      if (l == k) node.inverse_mass = reached.inverse_mass;
    }
    for (const std::size_t slot : node.slots) share_of_[slot] = 0.0;
  }
}

/// Which nodes a shaft that bends holds, and how each moves under an impulse on each: by the tissue's inertia and by
/// the shaft giving way. Held are those on the shaft and the one at the tip, but no two closer than half a spread:
/// closer ones move as one, and forces against each other would only turn the tissue.
void NeedlePath::couple_sideways(double dt) {
  held_.clear();
  for (std::size_t k = 0; k < state_.hole.size(); ++k) {
    const Coupled& node = coupled_[k];
    const bool at_tip =
        k + 1 == state_.hole.size() && !state_.through && (!state_.punctured || !is_ahead_of_tip(needle_, node.along));
    if (!on_shaft(k) && !at_tip) continue;
    if (node.inverse_mass == 0.0 && shaft_compliance(needle_, node.along, node.along) == 0.0) continue;
    if (!held_.empty() && coupled_[held_.back()].along - node.along < 0.5 * spread_) continue;
    held_.push_back(k);
  }
  const auto count = static_cast<Eigen::Index>(held_.size());
  if (gives_.rows() < count) {  // more than it takes now: it changes from step to step
    gives_.resize(2 * count, 2 * count);
    compliance_.resize(2 * count, 2 * count);
    off_.resize(2 * count, 3);
  }
  for (Eigen::Index row = 0; row < count; ++row) {
    const Coupled& node = coupled_[held_[row]];
    for (Eigen::Index column = 0; column < count; ++column) {
      compliance_(row, column) = shaft_compliance(needle_, node.along, coupled_[held_[column]].along);
      gives_(row, column) = compliance_(row, column) / dt;
    }
    for (const Reached& reached : node.reached) {
      const auto column = std::ranges::lower_bound(held_, reached.node);
      if (column == held_.end() || *column != reached.node) continue;
      gives_(row, column - held_.begin()) += dt * reached.inverse_mass;
    }
  }
  auto gives = gives_.topLeftCorner(count, count);
  gives.diagonal() *= 1.0 + slack;
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> in_place(gives);
  if (in_place.info() != Eigen::Success) held_.clear();
}

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
