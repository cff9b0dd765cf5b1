// SPDX-License-Identifier: MIT
//
// FloatJoints: the springs of a scene's joints in single precision, joint by joint, and which particles they pull.
#pragma once

#include <phymul/scene.h>

#include <vector>

#include "interaction/joint_set.h"
#include "table_rows.h"

namespace phymul {

class FloatJoints {
 public:
  static constexpr std::size_t place_rows = 3, law_rows = 2;
  /// Rows of a spring's state, as joint_law.glsl gives it: force on anchor a (N), 1 if broken; torque on its tool (N
  /// m), length (m); force and torque summed over the steps of a batch.
  static constexpr std::size_t state_rows = 4;

  /// `middle`: FloatTools::middle(). The scene must stay where it is.
  FloatJoints(const Scene& scene, const Vec3& middle);

  bool empty() const { return springs_.empty(); }
  Index count() const { return static_cast<Index>(springs_.size()); }
  bool any_tool() const { return any_tool_; }

  /// Per spring: first row of anchor a in anchors(), of anchor b, their end; row + 1 of the tool that anchor b is on,
  /// below 0 if anchor a is, 0: neither.
  const std::vector<Int4>& springs() const { return springs_; }
  const std::vector<Int4>& anchors() const { return anchors_; }  ///< particle, bits of its weight
  /// Per spring: from anchor a to b at rest, m; two rows that mean nothing. On a tool: where the particles are at rest,
  /// from the middle, as a sum of two; the anchor in the tool's frame.
  const std::vector<Float4>& places() const { return places_; }
  /// Per particle: first row and end of its ends().
  const std::vector<Int4>& ranges() const { return ranges_; }
  const std::vector<Int4>& ends() const { return ends_; }  ///< spring, bits of the share of its force

  /// Takes over stiffness, damping and rest lengths of the scene. True where they may have changed.
  bool follow();
  /// Per spring: k (N/m), c (N s/m), breaking force (N), 1 if slack; L, |R| - L (m).
  const std::vector<Float4>& laws() const { return laws_; }

 private:
  void add(const JointSpring& spring);
  void add_anchor(const Anchor& anchor);
  void gather();

  const Scene* scene_;
  Vec3 middle_;
  std::uint64_t seen_ = 0;  // Scene::values_version() + 1
  bool any_tool_ = false;
  std::vector<Int4> springs_, anchors_, ranges_, ends_;
  std::vector<Float4> places_, laws_;
  std::vector<double> rest_distance_;  // |R|
};

/// A step that a device has done, and the sums over a batch, [springs * state_rows], joint by joint.
std::vector<JointSet::Told> told_joints(std::span<const Float4> rows);
/// State rows to begin with: of each spring only whether it is broken.
std::vector<Float4> joint_rows(const std::vector<SceneJoint>& joints, const JointSet& known);

}  // namespace phymul
