// SPDX-License-Identifier: MIT
#include <algorithm>
#include <memory>

#include "base/union_find.h"
#include "dissipation.h"
#include "local_steps.h"
#include "rotation.h"
#include "scaled_tables.h"
#include "substep_loop.h"

namespace phymul {
namespace {

constexpr const char* pushes_part = "pushes";

/// All numbers of vectors, [3 n].
template <class Numbers, class Vector>
Eigen::Map<Numbers> numbers_of(std::span<Vector> vectors) {
  return {vectors.front().data(), 3 * static_cast<Eigen::Index>(vectors.size())};
}

LocalForces::Loop in_double_precision(const LocalSteps& steps) {
  const TopologyTextures& t = steps.stiff.tables;
  Eigen::VectorXd inverse_mass(3 * t.particle_count);
  for (Index i = 0; i < t.particle_count; ++i) inverse_mass.segment<3>(3 * i).setConstant(1.0 / t.mass[i]);
  using Loop = SubstepLoop<Eigen::VectorXd>;
  const auto loop = std::make_shared<Loop>(
      steps.substeps, inverse_mass,
      [K = AveragedStiffness(t)](const Eigen::VectorXd& d, Eigen::VectorXd& result) { K.apply_alone(d, result); });
  return [loop, f = inverse_mass](std::span<const Vec3> still, std::span<const LocalForces::Held> held, double dt,
                                  double factor, std::span<Vec3> sum) mutable {
    f = numbers_of<const Eigen::VectorXd>(still);
    numbers_of<Eigen::VectorXd>(sum) = loop->run(f, dt, factor, held);
  };
}

}  // namespace

LocalForces::LocalForces(const LocalSteps& steps, Loop loop)
    : steps_(steps),
      loop_(std::move(loop)),
      imposed_(steps.particle.size(), 0),
      still_(steps.particle.size()),
      change_(still_.size()),
      nodes_(steps.fine.nodes()) {
  reset();
  const TopologyTextures& t = steps.stiff.tables;
  if (t.domains.empty()) return;
  held_.reserve(t.rest.size());
  if (!loop_) loop_ = in_double_precision(steps);
  UnionFind joined(t.rest.size());
  for (Index d = 0; d < static_cast<Index>(t.domains.size()); ++d) {
    for (const LinkTexel& link : t.links_of(d)) {
      joined.join(t.domains[d].particle, t.domains[d + link.offset].particle);
    }
  }
  std::vector<std::size_t> piece_of_root(t.rest.size());
  for (Index i = 0; i < t.particle_count; ++i) {
    const Index root = joined.root(i);  // the smallest number of its set
    if (root == i) {
      piece_of_root[i] = pieces_.size();
      pieces_.emplace_back();
    }
    piece_of_.push_back(piece_of_root[root]);
    Piece& piece = pieces_[piece_of_.back()];
    piece.mass += t.mass[i];
    piece.centre += t.mass[i] * t.rest[i];
  }
  for (Piece& piece : pieces_) piece.centre /= piece.mass;
}

void LocalForces::turn_pieces(std::span<const Vec3> x) {
  const TopologyTextures& t = steps_.stiff.tables;
  for (Piece& piece : pieces_) {
    piece.now.setZero();
    piece.turn.setZero();
  }
  for (std::size_t i = 0; i < piece_of_.size(); ++i) pieces_[piece_of_[i]].now += t.mass[i] * x[i];
  for (Piece& piece : pieces_) piece.now /= piece.mass;
  for (std::size_t i = 0; i < piece_of_.size(); ++i) {
    Piece& piece = pieces_[piece_of_[i]];
    piece.turn += t.mass[i] * (x[i] - piece.now) * (t.rest[i] - piece.centre).transpose();
  }
  for (Piece& piece : pieces_) {
    // Of a flat body, whose normal has no length here.
    if (t.dimension == 2) piece.turn(2, 2) = piece.turn.topLeftCorner<2, 2>().norm();
    piece.turn = rotation_of(piece.turn);
  }
}

/// Needs the turns of the pieces.
void LocalForces::find_held() {
  held_.clear();
  for (std::size_t row = 0; row < piece_of_.size(); ++row) {
    if (imposed_[row] == 0) continue;
    const Mat3& turn = pieces_[piece_of_[row]].turn;
    Mat3 free = turn;
    for (int axis = 0; axis < 3; ++axis) {
      if (imposed_[row] >> axis & 1) free.row(axis).setZero();
    }
    held_.push_back({row, turn.transpose() * free});
  }
}

std::span<const Vec3> LocalForces::changes(std::span<const Vec3> x, std::span<const Vec3> acceleration, double dt,
                                           double factor) {
  const std::size_t stiff = piece_of_.size(), fine = x.size() - stiff;
  for (std::size_t i = 0; i < x.size(); ++i) {
    still_[i] = acceleration[i];
    if (pushed_) still_[i] += pushes_[i] / steps_.mass[i];
    for (int axis = 0; axis < 3; ++axis) {
      if (imposed_[i] >> axis & 1) still_[i][axis] = 0.0;
    }
  }
  const std::span<Vec3> change(change_.data(), x.size());
  if (stiff > 0) {
    turn_pieces(x);
    find_held();
    for (std::size_t i = 0; i < stiff; ++i) still_[i] = pieces_[piece_of_[i]].turn.transpose() * still_[i];
    loop_(std::span(still_).first(stiff), held_, dt, factor, change.first(stiff));
    for (std::size_t i = 0; i < stiff; ++i) change[i] = pieces_[piece_of_[i]].turn * change[i];
  }
  if (fine > 0) {
    for (std::size_t i = stiff; i < x.size(); ++i) still_[i] *= steps_.mass[i];
    steps_.fine.changes<Vec3>(std::span(still_).last(fine), change.last(fine), nodes_);
  }
  return change;
}

void LocalForces::reset(const VecList& pushes) {
  pushed_ = !pushes.empty();
  next_pushed_ = false;
  next_pushes_.assign(steps_.particle.size(), Vec3::Zero());
  pushes_ = pushed_ ? pushes : next_pushes_;
}

void LocalForces::put(Snapshot& snapshot) const {
  if (std::ranges::all_of(acting(), [](const Vec3& push) { return push == Vec3::Zero(); })) return;
  put_numbers(pushes_part, {pushes_.front().data(), 3 * pushes_.size()}, snapshot);
}

bool LocalForces::has(const Snapshot& snapshot) {
  return has_part(pushes_part, snapshot);
}

VecList LocalForces::pushes_of(const Snapshot& snapshot) const {
  const std::vector<double> numbers = numbers_of(pushes_part, 3 * steps_.particle.size(), snapshot);
  VecList pushes;
  for (std::size_t k = 0; k < numbers.size(); k += 3) pushes.emplace_back(&numbers[k]);
  return pushes;
}

}  // namespace phymul
