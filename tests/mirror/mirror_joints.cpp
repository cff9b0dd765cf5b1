// SPDX-License-Identifier: MIT
#include "mirror_joints.h"

#include <cmath>
#include <cstdlib>

#include "kernels.h"
#include "texels.h"

namespace phymul::cpu {
namespace {

using Law = Kernels<float>;

Float4 texel(const Float3& v, float w) {
  return {v.x, v.y, v.z, w};
}

}  // namespace

void MirrorJoints::follow(const Scene& scene, const FloatTools& tools) {
  scene_ = &scene;
  tools_ = &tools;
  rows_.emplace(scene, tools.middle());
}

MirrorJoints::Way MirrorJoints::mean_way(const Step& step, std::int32_t first, std::int32_t end) const {
  Way way;
  for (std::int32_t row = first; row < end; ++row) {
    const Int4& anchor = rows_->anchors()[row];
    const float weight = as_float(anchor[1]);
    way.from += weight * step.u[anchor[0]];
    way.speed += weight * step.v[anchor[0]];
  }
  return way;
}

MirrorJoints::ToolAnchor MirrorJoints::tool_anchor(const Step& step, int tool, const Float3& point) const {
  const Float4* const rows = &tools_->frames()[FloatTools::frame_rows * static_cast<std::size_t>(tool)];
  const auto turned = [&](int first) {
    return point.x * xyz(rows[first]) + point.y * xyz(rows[first + 1]) + point.z * xyz(rows[first + 2]);
  };
  const Float3 gone{rows[4][3], rows[5][3], rows[6][3]};
  const Float3 moved = gone + turned(4);
  Float3 offset = turned(0), speed = step.inverse_dt * moved;
  if (step.tools_at_once) {
    offset += moved;
    speed = {};
  }
  return {{rows[0][3], rows[1][3], rows[2][3]}, xyz(rows[3]), offset, speed, offset - gone};
}

void MirrorJoints::act(const Step& step, std::size_t s) {
  const Int4& ends = rows_->springs()[s];
  const Float4 &law = rows_->laws()[FloatJoints::law_rows * s], &lengths = rows_->laws()[FloatJoints::law_rows * s + 1];
  const Float4* const places = &rows_->places()[FloatJoints::place_rows * s];
  const Float3 R = xyz(places[0]);
  const Way a = mean_way(step, ends[0], ends[1]), b = mean_way(step, ends[1], ends[2]);
  const Float3 d = b.from - a.from;
  Float3 r = R + d, v = b.speed - a.speed, arm;
  if (ends[3] != 0) {
    const ToolAnchor at = tool_anchor(step, std::abs(ends[3]) - 1, xyz(places[2]));
    r = ((at.high - R) + (at.low - xyz(places[1]))) + (at.offset - (a.from + b.from));
    v = at.speed - (a.speed + b.speed);
    arm = at.arm;
    if (ends[3] < 0) {
      r = -r;
      v = -v;
    }
  }
  if (scene_->model().dimension == 2) r.z = v.z = 0.0f;
  const float length = std::sqrt(inner_product(r, r));
  const float stretch = ends[3] != 0 ? length - lengths[0] : Law::spring_stretch(R, d, r, length) + lengths[1];
  Float4* const state = &state_[FloatJoints::state_rows * s];
  const bool broken = state[0][3] > 0.0f;
  Float3 f;
  if (!broken) f = Law::joint_pull(r, v, length, stretch, law[0], law[1], lengths[0] == 0.0f, law[3] > 0.0f);
  const bool breaks = inner_product(f, f) > law[2] * law[2];
  const Float3 torque = ends[3] != 0 ? cross_product(arm, ends[3] > 0 ? -f : f) : Float3{};
  state[0] = texel(f, broken || breaks ? 1.0f : 0.0f);
  state[1] = texel(torque, length);
  state[2] = texel(f, 0.0f);
  state[3] = texel(torque, 0.0f);
}

void MirrorJoints::act(const Step& step, const JointSet& known) {
  rows_->follow();
  state_ = joint_rows(scene_->joints(), known);
  for (std::size_t s = 0; s < rows_->springs().size(); ++s) act(step, s);
}

void MirrorJoints::add_forces(Index i, Float3& force) const {
  const Int4& range = rows_->ranges()[i];
  for (std::int32_t row = range[0]; row < range[1]; ++row) {
    const Int4& end = rows_->ends()[row];
    force += as_float(end[1]) * xyz(state_[FloatJoints::state_rows * end[0]]);
  }
}

}  // namespace phymul::cpu
