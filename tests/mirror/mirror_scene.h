// SPDX-License-Identifier: MIT
//
// Springs of joints in float: the twin of glsl/joints/joint_law.glsl, in its order of operations. Kept volumes in
// float, plain loops: the twin of the passes glsl/kept_*_pass.glsl, in their order of operations.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/vector3.h"
#include "device/float_joints.h"
#include "device/float_tools.h"
#include "device/float_volumes.h"

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

class MirrorVolumes {
 public:
  void follow(const Scene& scene) { tables_ = pack_volumes(scene); }
  bool empty() const { return tables_.empty(); }

  /// Which way each particle goes. u: displacements at the step's start; inertia: FloatTables::particle; fixed(i): bit
  /// a where coordinate a takes no push, 7 where a tool holds it.
  template <class Fixed>
  void follow_gradient(std::span<const Vector3<float>> u, std::span<const Float4> inertia, Fixed&& fixed) {
    along_.assign(u.size(), {});
    for (Index i = 0; i < static_cast<Index>(u.size()); ++i) {
      if (moves(i)) along_[at(i)] = free_part(direction(at(i), u, inertia[at(i)][0]), fixed(i));
    }
  }

  /// How far: brings the volumes of displacements u, those at the step's end, to what is wanted. The row of one that
  /// cannot be; -1: none.
  int find_roots(std::span<const Vector3<float>> u);

  struct Way {
    float way = 0.0f;  // m
    Vector3<float> along{};
  };
  /// Of a particle that moves() says is of a volume.
  Way way(Index i) const { return {roots_[at(tables_.ranges[at(i)][2])], along_[at(i)]}; }
  bool moves(Index i) const { return !empty() && tables_.ranges[at(i)][2] >= 0; }

 private:
  static std::size_t at(std::int32_t row) { return static_cast<std::size_t>(row); }
  static Vector3<float> free_part(const Vector3<float>& v, int fixed_at) {
    return {(fixed_at & 1) != 0 ? 0.0f : v.x, (fixed_at & 2) != 0 ? 0.0f : v.y, (fixed_at & 4) != 0 ? 0.0f : v.z};
  }
  Vector3<float> direction(std::size_t i, std::span<const Vector3<float>> u, float inverse_mass) const;
  Float4 facet(std::size_t row, std::span<const Vector3<float>> u, float inverse_unit) const;
  Float4 sum_of(const Int4& node, bool of_facets, std::span<const Vector3<float>> u) const;
  const Float4& law(std::int32_t volume, std::size_t row) const {
    return tables_.laws[FloatVolumes::law_rows * at(volume) + row];
  }
  Vector3<float> edge(std::size_t row, std::size_t k) const {
    const Float4& edge = tables_.edges[FloatVolumes::edge_rows * row + k];
    return {edge[0], edge[1], edge[2]};
  }

  FloatVolumes tables_;
  std::vector<Vector3<float>> along_;  // [particles]
  std::vector<Float4> sums_;           // [nodes]
  std::vector<float> roots_;           // [volumes] m
};

}  // namespace phymul::cpu
