// SPDX-License-Identifier: MIT
//
// Springs of joints in float: the twin of glsl/joints/joint_law.glsl, in its order of operations.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/vector3.h"
#include "device/float_joints.h"
#include "device/float_tools.h"

namespace phymul::cpu {

class MirrorJoints {
 public:
  /// After tools.follow(scene), which must stay where they are.
  void follow(const Scene& scene, const FloatTools& tools);
  bool empty() const { return !rows_ || rows_->empty(); }

  /// One step from displacements u and velocities v. Before: FloatTools::begin_batch() of that step.
  struct Step {
    std::span<const Vector3<float>> u, v;
    float inverse_dt = 0.0f;
    bool tools_at_once = false;
  };
  /// `known`: which springs are broken.
  void act(const Step& step, const JointSet& known);
  /// Of the last act(), as a device tells it.
  std::vector<JointSet::Told> told() const { return told_joints(state_); }
  void add_forces(Index i, Vector3<float>& force) const;

 private:
  struct Way {
    Vector3<float> from{}, speed{};
  };
  struct ToolAnchor {
    Vector3<float> high, low, offset, speed, arm;
  };
  Way mean_way(const Step& step, std::int32_t first, std::int32_t end) const;
  ToolAnchor tool_anchor(const Step& step, int tool, const Vector3<float>& point) const;
  void act(const Step& step, std::size_t s);

  const Scene* scene_ = nullptr;
  const FloatTools* tools_ = nullptr;
  std::optional<FloatJoints> rows_;
  std::vector<Float4> state_;  // [springs * FloatJoints::state_rows]
};

}  // namespace phymul::cpu
