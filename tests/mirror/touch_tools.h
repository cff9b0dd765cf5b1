// SPDX-License-Identifier: MIT
//
// A particle and the tools of a scene in one step, in float: the twin of glsl/tools/touch_tools.glsl, operation by
// operation.
#pragma once

#include <algorithm>

#include "device/float_tools.h"
#include "interaction/contact_tool.h"
#include "texels.h"

namespace phymul::cpu {

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
