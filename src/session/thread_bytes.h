// SPDX-License-Identifier: MIT
//
// The threads of a scene in bytes, and their states.
#pragma once

#include <phymul/scene.h>

#include "base/checked_file.h"

namespace phymul {

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
