// SPDX-License-Identifier: MIT
#include "rest_joints.h"

#include <algorithm>

#include "interaction/joint_set.h"
#include "scene/anchor_place.h"

namespace phymul {
namespace {

/// Calls visit(particle, +-weight): how the way from anchor `a` to `b` depends on particles.
template <class Visit>
void for_each_weight(const JointSpring& spring, const Visit& visit) {
  for (const auto& [anchor, sign] : {std::pair{&spring.a, -1.0}, std::pair{&spring.b, 1.0}}) {
    for (std::size_t k = 0; k < anchor->particles.size(); ++k) visit(anchor->particles[k], sign * anchor->weights[k]);
  }
}

}  // namespace

RestJoints::RestJoints(const Scene& scene, const State& state) : scene_(scene) {
  for (const SceneJoint& joint : scene.joints()) {
    const auto known = std::ranges::find(state.joints, joint.name, &JointState::name);
    for (std::size_t row = 0; row < joint.joint.springs.size(); ++row) {
      if (known != state.joints.end() && std::ranges::count(known->broken, static_cast<Index>(row)) > 0) continue;
      if (ends_at_removed(joint.joint.springs[row], scene.model().mass)) continue;
      springs_.push_back({.joint = &joint, .spring = &joint.joint.springs[row]});
    }
  }
}

void RestJoints::mark_held(std::span<char> particles) const {
  for (const Spring& own : springs_) {
    if (!(own.joint->joint.stiffness > 0.0)) continue;
    for_each_weight(*own.spring, [&](Index i, double) { particles[i] = 1; });
  }
}

Vec3 RestJoints::span_of(const JointSpring& spring, std::span<const Vec3> position) const {
  return anchor_place(spring.b, position, scene_.tools()) - anchor_place(spring.a, position, scene_.tools());
}

void RestJoints::add_forces(std::span<const Vec3> position, std::span<Vec3> force) const {
  for (const Spring& own : springs_) {
    const Vec3 on_a = spring_force(own.joint->joint, *own.spring, span_of(*own.spring, position), Vec3::Zero());
    for_each_weight(*own.spring, [&](Index i, double weight) { force[i] -= weight * on_a; });
  }
}

void RestJoints::add_reactions(std::span<const Vec3> position, std::span<ToolForce> tools) const {
  for (const Spring& own : springs_) {
    const Vec3 on_a = spring_force(own.joint->joint, *own.spring, span_of(*own.spring, position), Vec3::Zero());
    for (const auto& [anchor, force] : {std::pair{&own.spring->a, on_a}, std::pair{&own.spring->b, Vec3(-on_a)}}) {
      const auto tool = std::ranges::find(scene_.tools(), anchor->tool, &SceneTool::name);
      if (tool == scene_.tools().end()) continue;  // a tool's name is not empty
      ToolForce& felt = tools[static_cast<std::size_t>(tool - scene_.tools().begin())];
      felt.force += force;
      felt.torque += (anchor_place(*anchor, position, scene_.tools()) - tool->pose.position).cross(force);
    }
  }
}

std::vector<JointReport> RestJoints::reports(std::span<const Vec3> position) const {
  std::vector<JointReport> all;
  for (const SceneJoint& joint : scene_.joints()) {
    JointReport& report = all.emplace_back();
    for (const JointSpring& spring : joint.joint.springs) {
      report.springs.push_back({.length = span_of(spring, position).norm(), .broken = true});
    }
    report.broken = static_cast<int>(report.springs.size());
  }
  for (const Spring& own : springs_) {
    JointReport& report = all[static_cast<std::size_t>(own.joint - scene_.joints().data())];
    SpringReport& spring = report.springs[static_cast<std::size_t>(own.spring - own.joint->joint.springs.data())];
    spring.broken = false;
    spring.force = spring_force(own.joint->joint, *own.spring, span_of(*own.spring, position), Vec3::Zero());
    report.force += spring.force;
    report.largest = std::max(report.largest, spring.force.norm());
    --report.broken;
  }
  return all;
}

double RestJoints::energy(std::span<const Vec3> position) const {
  double energy = 0.0;
  for (const Spring& own : springs_) {
    energy += spring_energy(own.joint->joint, *own.spring, span_of(*own.spring, position).norm());
  }
  return energy;
}

double RestJoints::squared_support(std::span<const Vec3> position) const {
  double sum = 0.0;
  for (const Spring& own : springs_) {
    if (!own.spring->a.particles.empty() && !own.spring->b.particles.empty()) continue;
    sum += spring_force(own.joint->joint, *own.spring, span_of(*own.spring, position), Vec3::Zero()).squaredNorm();
  }
  return sum;
}

void RestJoints::linearise(std::span<const Vec3> position) {
  for (Spring& own : springs_) {
    own.tangent = spring_tangent(own.joint->joint, *own.spring, span_of(*own.spring, position));
  }
}

void RestJoints::add_product(const Eigen::VectorXd& d, Eigen::VectorXd& result) const {
  for (const Spring& own : springs_) {
    Vec3 way = Vec3::Zero();
    for_each_weight(*own.spring, [&](Index i, double weight) { way += weight * d.segment<3>(3 * Eigen::Index{i}); });
    const Vec3 force = own.tangent * way;
    for_each_weight(*own.spring,
                    [&](Index i, double weight) { result.segment<3>(3 * Eigen::Index{i}) += weight * force; });
  }
}

void RestJoints::add_diagonal(std::span<Mat3> blocks) const {
  for (const Spring& own : springs_) {
    for_each_weight(*own.spring, [&](Index i, double weight) { blocks[i] += weight * weight * own.tangent; });
  }
}

std::string RestJoints::overloaded(std::span<const Vec3> position) const {
  for (const Spring& own : springs_) {
    const Vec3 force = spring_force(own.joint->joint, *own.spring, span_of(*own.spring, position), Vec3::Zero());
    if (force.norm() > own.spring->share * own.joint->joint.breaking_force) return own.joint->name;
  }
  return {};
}

}  // namespace phymul
