// SPDX-License-Identifier: MIT
#include "stiff_joints.h"

#include <algorithm>
#include <cmath>

namespace phymul {
namespace {

/// Solved together: their work in a step grows with the cube of their number.
constexpr std::size_t most_springs = 48;
/// Inertia that a stretched spring must add sideways, over the masses, to be counted.
constexpr double least_sideways = 0.05;

template <class Visit>
void for_each_end(const JointSpring& spring, const Visit& visit) {
  for (std::size_t k = 0; k < spring.a.particles.size(); ++k) visit(spring.a.particles[k], -spring.a.weights[k]);
  for (std::size_t k = 0; k < spring.b.particles.size(); ++k) visit(spring.b.particles[k], spring.b.weights[k]);
}

}  // namespace

std::vector<bool> solved_joints(const Scene& scene, const LocalSteps* steps) {
  std::vector<bool> solved;
  std::size_t left = most_springs;
  for (const SceneJoint& it : scene.joints()) {
    bool takes = !it.joint.slack && it.joint.springs.size() <= left;
    for (const JointSpring& spring : it.joint.springs) {
      if (!takes || steps == nullptr) break;
      for_each_end(spring, [&](Index i, double) {
        if (std::ranges::binary_search(steps->stiff.particle, i)) takes = false;
      });
    }
    if (takes) left -= it.joint.springs.size();
    solved.push_back(takes);
  }
  return solved;
}

std::size_t StiffJoints::row_of(Index particle) {
  const auto known = std::ranges::find(reached_, particle, &Reached::particle);
  if (known == reached_.end()) reached_.push_back({.particle = particle});
  return static_cast<std::size_t>(std::ranges::find(reached_, particle, &Reached::particle) - reached_.begin());
}

void StiffJoints::follow(const Scene& scene, const TopologyTextures& topology, std::span<const std::uint8_t> fixed,
                         const LocalSteps* steps) {
  dimension_ = topology.dimension;
  springs_.clear();
  reached_.clear();
  const std::vector<bool> solved = solved_joints(scene, steps);
  const FineParts none_fine, &fine = steps == nullptr ? none_fine : steps->fine;
  VecList f(fine.particle.size()), change(f.size()), nodes(fine.nodes());
  const auto free_part = [&](Index i, Vec3 of) {
    for (int axis = 0; axis < 3; ++axis) {
      if (axis >= dimension_ || (!fixed.empty() && (fixed[i] >> axis & 1) != 0)) of[axis] = 0.0;
    }
    return of;
  };
  for (std::size_t j = 0; j < solved.size(); ++j) {
    const std::vector<JointSpring>& all = scene.joints()[j].joint.springs;
    for (std::size_t k = 0; solved[j] && k < all.size(); ++k) {
      bool is_removed = false;  // and broken
      for_each_end(all[k], [&](Index i, double) { is_removed = is_removed || topology.mass[i] == 0.0; });
      if (is_removed) continue;
      Spring spring{.joint = j, .row = k, .weights = {}, .motion = {}};
      std::ranges::fill(f, Vec3::Zero());
      bool has_fine = false;
      for_each_end(all[k], [&](Index i, double weight) {
        const Vec3 forces = free_part(i, Vec3::Constant(weight));
        spring.weights.push_back({row_of(i), Vec3::Constant(weight)});
        spring.motion.push_back({row_of(i), forces});
        const auto own = std::ranges::lower_bound(fine.particle, i);
        if (own == fine.particle.end() || *own != i) return;
        has_fine = true;
        f[own - fine.particle.begin()] += forces;
      });
      if (has_fine) fine.changes<Vec3>(f, change, nodes);
      for (std::size_t r = 0; has_fine && r < f.size(); ++r) {
        const Vec3 moved = free_part(fine.particle[r], change[r]);
        if (!moved.isZero(0.0)) spring.motion.push_back({row_of(fine.particle[r]), moved});
      }
      springs_.push_back(std::move(spring));
    }
  }
  const std::size_t n = springs_.size();
  compliance_.assign(n * n, Vec3::Zero());
  VecList moved(reached_.size());
  for (std::size_t s = 0; s < n; ++s) {
    std::ranges::fill(moved, Vec3::Zero());
    for (const auto& [row, force] : springs_[s].motion) moved[row] += force / topology.mass[reached_[row].particle];
    for (std::size_t other = 0; other < n; ++other) {
      for (const auto& [row, weight] : springs_[other].weights) {
        compliance_[n * other + s] += weight.cwiseProduct(moved[row]);
      }
    }
  }
  coupled_.clear();
  for (const Vec3& between : compliance_) coupled_.push_back(between.isZero(0.0) ? 0 : 1);
  rows_.reserve(3 * n);
  begin_.reserve(3 * n);
  value_.reserve(3 * n);
  matrix_.resize(9 * n * n);
}

void StiffJoints::list_rows(const Scene& scene, const JointSet& joints, double dt, double d) {
  const std::size_t n = springs_.size();
  const auto inertia = [&](const Spring& of) {
    const Joint& joint = scene.joints()[of.joint].joint;
    const double whole = joint.springs[of.row].share * (dt * dt * joint.stiffness + 2.0 * dt * joint.damping);
    return joints.now(of.joint, of.row).was_broken ? 0.0 : whole / (2.0 * (1.0 + d));
  };
  const auto length = [&](const Spring& of) { return scene.joints()[of.joint].joint.springs[of.row].rest_length; };
  rows_.clear();
  // Axis by axis, so that the matrix has blocks.
  for (int axis = 0; axis < dimension_; ++axis) {
    for (std::size_t s = 0; s < n; ++s) {
      if (length(springs_[s]) == 0.0) rows_.push_back({s, std::sqrt(inertia(springs_[s])) * Vec3::Unit(axis)});
    }
  }
  for (std::size_t s = 0; s < n; ++s) {
    const double rest = length(springs_[s]), own = inertia(springs_[s]);
    const Vec3& reach = joints.now(springs_[s].joint, springs_[s].row).reach;
    const double now = reach.norm();
    if (rest == 0.0 || now == 0.0) continue;
    const Vec3 along = reach / now;
    rows_.push_back({s, std::sqrt(own) * along});
    const double sideways = own * std::max(0.0, 1.0 - rest / now);
    if (sideways * compliance_[n * s + s].maxCoeff() < least_sideways) continue;
    const Vec3 other = dimension_ == 2 ? Vec3(Vec3::UnitZ()) : along.unitOrthogonal();
    for (const Vec3& direction : {Vec3(along.cross(other)), other}) {
      rows_.push_back({s, std::sqrt(sideways) * direction});
    }
  }
}

/// By Cholesky's method: value = matrix^-1 value. Entries before begin_ stay 0.
void StiffJoints::solve() {
  const std::size_t n = rows_.size();
  for (std::size_t i = 0; i < n; ++i) {
    double* const own = &matrix_[n * i];
    for (std::size_t j = begin_[i]; j <= i; ++j) {
      const double* const other = &matrix_[n * j];
      double sum = own[j];
      for (std::size_t k = std::max(begin_[i], begin_[j]); k < j; ++k) sum -= own[k] * other[k];
      own[j] = j < i ? sum / other[j] : std::sqrt(sum);
    }
    for (std::size_t k = begin_[i]; k < i; ++k) value_[i] -= own[k] * value_[k];
    value_[i] /= own[i];
  }
  for (std::size_t i = n; i-- > 0;) {
    const double* const own = &matrix_[n * i];
    value_[i] /= own[i];
    for (std::size_t k = begin_[i]; k < i; ++k) value_[k] -= own[k] * value_[i];
  }
}

void StiffJoints::act(const Scene& scene, const JointSet& joints, double dt, double d, bool later) {
  list_rows(scene, joints, dt, d);
  for (Spring& spring : springs_) {
    const JointSet::Now now = joints.now(spring.joint, spring.row);
    spring.force = now.left_out && !later ? Vec3(-now.force) : Vec3(Vec3::Zero());
  }
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    Vec3& between = springs_[s].acceleration;
    between.setZero();
    for (const auto& [row, weight] : springs_[s].weights) between += weight.cwiseProduct(reached_[row].acceleration);
    for (std::size_t other = 0; other < springs_.size(); ++other) {
      const std::size_t pair = springs_.size() * s + other;
      if (coupled_[pair] != 0) between += compliance_[pair].cwiseProduct(springs_[other].force);
    }
  }
  const std::size_t n = rows_.size();
  begin_.clear();
  value_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const auto& [spring, direction] = rows_[i];
    std::size_t begin = i;
    for (std::size_t j = i + 1; j-- > 0;) {
      double& entry = matrix_[n * i + j] = i == j ? 1.0 : 0.0;
      const std::size_t pair = springs_.size() * spring + rows_[j].spring;
      if (coupled_[pair] == 0) continue;
      entry += direction.dot(compliance_[pair].cwiseProduct(rows_[j].direction));
      if (entry != 0.0) begin = j;
    }
    begin_.push_back(begin);
    value_.push_back(direction.dot(springs_[spring].acceleration));
  }
  solve();
  for (std::size_t i = 0; i < n; ++i) springs_[rows_[i].spring].force -= value_[i] * rows_[i].direction;
  for (Reached& reached : reached_) reached.force.setZero();
  for (Spring& spring : springs_) {
    spring.whole = later ? Vec3(spring.whole + spring.force) : spring.force;
    for (const auto& [row, motion] : spring.motion) reached_[row].force += motion.cwiseProduct(spring.force);
  }
}

void StiffJoints::tell(JointSet& joints) const {
  for (const Spring& spring : springs_) joints.set_force(spring.joint, spring.row, -spring.whole);
}

double StiffJoints::added_energy(std::span<const Vec3> v, std::span<const Vec3> next) const {
  double sum = 0.0;
  for (const auto& [spring, direction] : rows_) {
    double own = 0.0, later = 0.0;
    for (const auto& [row, weight] : springs_[spring].weights) {
      own += direction.dot(weight.cwiseProduct(v[reached_[row].particle]));
      later += direction.dot(weight.cwiseProduct(next[reached_[row].particle]));
    }
    sum += 0.5 * own * later;
  }
  return sum;
}

StiffJointsNow::StiffJointsNow(const Scene& scene, const State& state, const TopologyTextures& topology,
                               std::span<const std::uint8_t> fixed, const LocalSteps* steps, double dt, double d,
                               std::span<const Vec3> acceleration) {
  joints.follow(scene, topology, fixed, steps);
  for (StiffJoints::Reached& reached : joints.reached()) reached.acceleration = acceleration[reached.particle];
  joints.act(scene, joints_of(scene, state), dt, d);
}

}  // namespace phymul
