// SPDX-License-Identifier: MIT
#include "float_joints.h"

#include <algorithm>
#include <bit>

#include "scene/anchor_place.h"

namespace phymul {
namespace {

Int4 weighed(Index row, double weight) {
  return {row, std::bit_cast<std::int32_t>(static_cast<float>(weight)), 0, 0};
}

}  // namespace

FloatJoints::FloatJoints(const Scene& scene, const Vec3& middle) : scene_(&scene), middle_(middle) {
  for (const SceneJoint& joint : scene.joints()) {
    for (const JointSpring& spring : joint.joint.springs) add(spring);
  }
  if (empty()) return;
  gather();
  laws_.resize(law_rows * springs_.size());
  follow();
}

void FloatJoints::add_anchor(const Anchor& anchor) {
  for (std::size_t k = 0; k < anchor.particles.size(); ++k) {
    anchors_.push_back(weighed(anchor.particles[k], anchor.weights[k]));
  }
}

void FloatJoints::add(const JointSpring& spring) {
  Int4& row = springs_.emplace_back();
  const auto end = [this] { return static_cast<Index>(anchors_.size()); };
  row[0] = end();
  add_anchor(spring.a);
  row[1] = end();
  add_anchor(spring.b);
  row[2] = end();
  const auto at_rest = [this](const Anchor& anchor) {
    return anchor_place(anchor, scene_->model().rest, scene_->tools());
  };
  const bool on_a = !spring.a.tool.empty();
  const Anchor& on_tool = on_a ? spring.a : spring.b;
  if (on_tool.tool.empty()) {
    const Vec3 R = at_rest(spring.b) - at_rest(spring.a);
    rest_distance_.push_back(R.norm());
    places_.insert(places_.end(), {float4(R), Float4{}, Float4{}});
    return;
  }
  any_tool_ = true;
  const auto tool = std::ranges::find(scene_->tools(), on_tool.tool, &SceneTool::name);
  row[3] = static_cast<Index>(tool - scene_->tools().begin()) + 1;
  if (on_a) row[3] = -row[3];
  const auto [high, low] = halves(at_rest(on_a ? spring.b : spring.a) - middle_);
  rest_distance_.push_back(0.0);
  places_.insert(places_.end(), {high, low, float4(on_tool.point)});
}

/// Ends in the order of the springs, so that sums over them are in that of JointSet.
void FloatJoints::gather() {
  const VecList& rest = scene_->model().rest;
  std::vector<std::vector<Int4>> of_particle(rest.size());
  for (Index s = 0; s < count(); ++s) {
    const Int4& row = springs_[s];
    for (Index at = row[0]; at < row[2]; ++at) {
      const float weight = std::bit_cast<float>(anchors_[at][1]);
      of_particle[anchors_[at][0]].push_back(weighed(s, at < row[1] ? weight : -weight));
    }
  }
  for (const std::vector<Int4>& own : of_particle) {
    const auto first = static_cast<Index>(ends_.size());
    ends_.insert(ends_.end(), own.begin(), own.end());
    ranges_.push_back({first, static_cast<Index>(ends_.size()), 0, 0});
  }
}

bool FloatJoints::follow() {
  if (empty() || seen_ == scene_->values_version() + 1) return false;
  seen_ = scene_->values_version() + 1;
  std::size_t row = 0;
  for (const SceneJoint& joint : scene_->joints()) {
    for (const JointSpring& spring : joint.joint.springs) {
      const double share = spring.share;
      laws_[law_rows * row] = {to_float(share * joint.joint.stiffness), to_float(share * joint.joint.damping),
                               to_float(share * joint.joint.breaking_force), joint.joint.slack ? 1.0f : 0.0f};
      laws_[law_rows * row + 1] = {to_float(spring.rest_length),
                                   static_cast<float>(rest_distance_[row] - spring.rest_length), 0.0f, 0.0f};
      ++row;
    }
  }
  return true;
}

std::vector<JointSet::Told> told_joints(std::span<const Float4> rows) {
  std::vector<JointSet::Told> told;
  for (std::size_t at = 0; at < rows.size(); at += FloatJoints::state_rows) {
    told.push_back({.spring = {.force = widened(rows[at]), .length = rows[at + 1][3], .broken = rows[at][3] > 0.0f},
                    .torque = widened(rows[at + 1]),
                    .sum_force = widened(rows[at + 2]),
                    .sum_torque = widened(rows[at + 3])});
  }
  return told;
}

std::vector<Float4> joint_rows(const std::vector<SceneJoint>& joints, const JointSet& known) {
  std::vector<Float4> rows;
  for (const SceneJoint& joint : joints) {
    for (const SpringReport& spring : known.report(joint).springs) {
      rows.push_back({0.0f, 0.0f, 0.0f, spring.broken ? 1.0f : 0.0f});
      rows.insert(rows.end(), FloatJoints::state_rows - 1, Float4{});
    }
  }
  return rows;
}

}  // namespace phymul
