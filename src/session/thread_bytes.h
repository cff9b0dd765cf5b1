// SPDX-License-Identifier: MIT
//
// The joints and the threads of a scene in bytes, and the states of threads.
#pragma once

#include <phymul/scene.h>

#include "base/checked_file.h"

namespace phymul {

// Joints. For a ByteWriter and a thing that is const, or a ByteReader and one that is not; the scene checks a joint.

template <class Bytes, class Any>
void anchor_fields(Bytes& bytes, Any& anchor) {
  bytes.field(anchor.particles, "an anchor's particles");
  bytes.list(anchor.weights, 8, "a number of weights", [&](auto& weight) { bytes.field(weight, "a weight"); });
  bytes.field(anchor.tool, "an anchor's tool");
  bytes.field(anchor.point, "an anchor's point");
}

template <class Bytes, class Any>
void joint_fields(Bytes& bytes, Any& joint) {
  bytes.list(joint.springs, 104, "a number of springs", [&](auto& spring) {
    anchor_fields(bytes, spring.a);
    anchor_fields(bytes, spring.b);
    bytes.field(spring.rest_length, "a rest length");
    bytes.field(spring.share, "a spring's share");
  });
  bytes.field(joint.stiffness, "a joint's stiffness");
  bytes.field(joint.damping, "a joint's damping");
  bytes.field(joint.slack, "whether a joint is slack");
  bytes.field(joint.breaking_force, "a breaking force");
}

void put_threads(ByteWriter& out, const std::vector<SceneThread>& threads);
std::vector<SceneThread> take_threads(ByteReader& in);
void add_threads(ByteReader& in, Scene& scene);  ///< throws Error for bytes that the scene refuses

/// What a ThreadHandle changed. `in`: of a thread that the scene has.
void put_control(ByteWriter& out, const ThreadControl& control);
void change_control(ByteReader& in, const ThreadHandle& thread);

/// ThreadState::sewn of each, apart from the rest: files written before have none.
void put_sewn(ByteWriter& out, const std::vector<ThreadState>& threads);
void take_sewn(ByteReader& in, std::vector<ThreadState>& threads);
void put_thread_states(ByteWriter& out, const std::vector<ThreadState>& threads);
std::vector<ThreadState> take_thread_states(ByteReader& in);

}  // namespace phymul
