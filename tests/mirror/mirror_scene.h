// SPDX-License-Identifier: MIT
//
// Springs of joints in float: the twin of glsl/joints/joint_law.glsl, in its order of operations. Kept volumes in
// float, plain loops: the twin of the passes glsl/kept_*_pass.glsl, in their order of operations. A particle and the
// tools of a scene in one step, in float: the twin of glsl/tools/touch_tools.glsl, operation by operation.
// root_of_cubic of closed_surface.h in float: the twin of glsl/volume/volume_root.glsl, operation by operation.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "base/vector3.h"
#include "device/float_scene.h"
#include "device/float_tools.h"
#include "interaction/contact_tool.h"
#include "mirror_forces.h"

namespace phymul::cpu {

struct VolumeRoot {
  bool found = false;
  float s = 0.0f;
};

/// Where a cubic that grows at 0 ceases to, ahead; 0: it never does.
inline float growing_end(float c1, float c2, float c3) {
  const float under = c2 * c2 - 3.0f * (c3 * c1);
  if (under < 0.0f || (c2 >= 0.0f && c3 >= 0.0f)) return 0.0f;
  const float root = std::sqrt(std::max(under, 0.0f));
  return c2 < 0.0f ? c1 * (1.0f / (root - c2)) : (c2 + root) * (1.0f / (-3.0f * c3));
}

/// The s nearest to 0 with c1 s + c2 s^2 + c3 s^3 = wanted, on the branch through 0 on which the cubic grows. Computed
/// as a way t = |s| ahead.
inline VolumeRoot root_of_cubic(float c1, float c2, float c3, float wanted) {
  const float total = std::abs(wanted) + c1 + std::abs(c2) + std::abs(c3);
  if (!(c1 > 0.0f) || !std::isfinite(total)) return {};
  if (wanted == 0.0f) return {true, 0.0f};
  const float W = std::abs(wanted);
  if (wanted < 0.0f) c2 = -c2;
  const float end = growing_end(c1, c2, c3);
  const bool ends = end > 0.0f;
  const float straight = W * (1.0f / c1);
  float high = ends ? std::min(straight, end) : straight;
  for (int k = 0; k < 64; ++k) {
    if (((c3 * high + c2) * high + c1) * high >= W) break;
    if (k == 63 || (ends && high >= end)) return {};
    high = ends ? std::min(2.0f * high, end) : 2.0f * high;
  }
  // Newton's iteration, kept in between by halving.
  float low = 0.0f, t = std::min(straight, high);
  for (int k = 0; k < 64; ++k) {
    const float ahead = ((c3 * t + c2) * t + c1) * t - W;
    const float slope = (3.0f * c3 * t + 2.0f * c2) * t + c1;
    (ahead < 0.0f ? low : high) = t;
    const float newton = t - ahead * (1.0f / slope);
    const float next = newton > low && newton < high ? newton : 0.5f * (low + high);
    if (ahead == 0.0f || next == t || next == low || next == high) break;
    t = next;
  }
  return {true, wanted < 0.0f ? -t : t};
}

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

struct FloatFrame {  // axes in the world, place as a sum
  Float3 x, y, z, high, low;
};

struct FloatTurn {  // from the step's start to its end: what the axes and the place gain
  Float3 x, y, z, gone;
};

struct TouchedParticle {
  Float3 high, low;  // at rest, as a sum
  Float3 u, v;       // at the step's start; the velocity with which it would go on, with the impulses so far
  float mass = 0.0f, inverse_mass = 0.0f;
  int fixed_at = 0;  // bit a: coordinate a is imposed
  Float3 impulse{}, shift{};
  Float3 withheld{};  // N, PredictedStep::withheld()

  Float3 free_part(const Float3& a) const {
    return {(fixed_at & 1) != 0 ? 0.0f : a.x, (fixed_at & 2) != 0 ? 0.0f : a.y, (fixed_at & 4) != 0 ? 0.0f : a.z};
  }
  Float3 push(const Float3& given) {
    const Float3 taken = free_part(given);
    impulse += taken;
    v += inverse_mass * taken;
    return taken;
  }
  Float3 borne(const Float3& given) {
    const float squared = inner_product(given, given);
    if (!(squared > 0.0f)) return {};
    const Float3 force = (std::max(0.0f, -inner_product(withheld, given)) / squared) * given;
    withheld += force;
    return force;
  }
};

struct FloatReaction {
  bool touches = false;
  Float3 force{}, torque{};
};

inline Float3 place_from(const FloatFrame& frame, const TouchedParticle& p, const Float3& u) {
  return ((p.high - frame.high) + (p.low - frame.low)) + u;
}
inline Float3 inside(const FloatFrame& frame, const Float3& r) {
  return {inner_product(frame.x, r), inner_product(frame.y, r), inner_product(frame.z, r)};
}
inline Float3 turned(const FloatFrame& frame, const Float3& q) {
  return q.x * frame.x + q.y * frame.y + q.z * frame.z;
}

inline FloatReaction react(const FloatFrame& end, const TouchedParticle& p, const Float3& force) {
  return {true, -force, -cross_product(place_from(end, p, p.u), force)};
}

inline FloatReaction hold(const FloatFrame& end, const Float3& held_at, TouchedParticle& p, float inverse_dt) {
  const Float3 target = ((end.high - p.high) + (end.low - p.low)) + turned(end, held_at);
  const Float3 velocity = inverse_dt * (target - p.u);
  const Float3 force = inverse_dt * p.push(p.mass * (velocity - p.v)) - p.free_part(p.withheld);
  p.withheld = {};
  return react(end, p, force);
}

struct Passage {  // of a particle in a step, in the tool's frame, m
  Float3 start, end, way;
};

inline Passage passage(const FloatFrame& start, const FloatFrame& end, const FloatTurn& turn, const TouchedParticle& p,
                       float dt) {
  const Float3 r0 = place_from(start, p, p.u);
  const Float3 passed = dt * p.v - turn.gone;
  const Float3 way{inner_product(end.x, passed) + inner_product(turn.x, r0),
                   inner_product(end.y, passed) + inner_product(turn.y, r0),
                   inner_product(end.z, passed) + inner_product(turn.z, r0)};
  const Float3 q1 = inside(end, place_from(end, p, p.u + dt * p.v));
  return {inside(start, r0), q1, way};
}

inline FloatReaction press(const ShapeIn<float>& shape, const ContactLaw<float>& law, const FloatFrame& start,
                           const FloatFrame& end, const FloatTurn& turn, TouchedParticle& p, float dt,
                           float inverse_dt) {
  const Passage own = passage(start, end, turn, p, dt);
  const Touch<float> touch = touch_in_step(shape, law, own.start, own.end, own.way, p.inverse_mass, dt);
  if (!touch.touches) return {};
  p.shift += p.free_part(turned(end, touch.shift));
  const Float3 given = p.push(turned(end, touch.impulse));
  return react(end, p, inverse_dt * given + p.borne(given));
}

/// The rows of FloatTools, of a batch of one step.
class ToolRows {
 public:
  explicit ToolRows(const FloatTools& tools) : tools_(tools) {}

  TouchedParticle untouched(Index i, const Float3& u, const Float3& v, const Float4& inertia, int fixed_at) const {
    const Float4* const rest = &tools_.rest()[FloatTools::rest_rows * static_cast<std::size_t>(i)];
    return {.high = xyz(rest[0]),
            .low = xyz(rest[1]),
            .u = u,
            .v = v,
            .mass = inertia[2],
            .inverse_mass = inertia[0],
            .fixed_at = fixed_at};
  }

  FloatReaction touch(int tool, Index i, TouchedParticle& p, float dt, float inverse_dt) const {
    const Float4& held = tools_.held()[static_cast<std::size_t>(i)];
    const int holder = static_cast<int>(held[3]);
    if (holder >= 0 && holder != tool) return {};
    if (holder == tool) return hold(frame(tool, 1), xyz(held), p, inverse_dt);
    if (p.fixed_at == 7) return {};
    const Float4* const rows = frame_rows(tool, 0);
    const Float4& law = tools_.laws()[FloatTools::law_rows * static_cast<std::size_t>(tool) + 1];
    return press(shape(tool), {law[2], law[3], rows[3][3] > 0.0f}, frame(tool, 0), frame(tool, 1),
                 {xyz(rows[4]), xyz(rows[5]), xyz(rows[6]), {rows[4][3], rows[5][3], rows[6][3]}}, p, dt, inverse_dt);
  }

 private:
  const Float4* frame_rows(int tool, int at) const {
    return &tools_.frames()[FloatTools::frame_rows * static_cast<std::size_t>(at * tools_.count() + tool)];
  }
  FloatFrame frame(int tool, int at) const {
    const Float4* const rows = frame_rows(tool, at);
    return {xyz(rows[0]), xyz(rows[1]), xyz(rows[2]), {rows[0][3], rows[1][3], rows[2][3]}, xyz(rows[3])};
  }
  ShapeIn<float> shape(int tool) const {
    const Float4* const law = &tools_.laws()[FloatTools::law_rows * static_cast<std::size_t>(tool)];
    ShapeIn<float> own{.kind = static_cast<ShapeKind>(static_cast<int>(law[0][3])),
                       .size = xyz(law[0]),
                       .margin = law[1][0],
                       .thickness = law[1][1]};
    if (own.kind != ShapeKind::grid) return own;
    own.grid = {&tools_.grid_values()[FloatTools::grid_unit * static_cast<std::size_t>(law[3][3])],
                static_cast<int>(law[3][0]),
                static_cast<int>(law[3][1]),
                static_cast<int>(law[3][2]),
                xyz(law[2]),
                law[2][3]};
    return own;
  }

  const FloatTools& tools_;
};

}  // namespace phymul::cpu
