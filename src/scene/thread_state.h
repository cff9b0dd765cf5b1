// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/state.h>
#include <phymul/thread.h>

#include <vector>

namespace phymul {

bool fits(const ThreadState& state, const SceneThread& thread);

/// Throws Error where a thread's part of a state does not fit the scene's thread of that name.
void require_thread_states(const State& state, const std::vector<SceneThread>& threads);

}  // namespace phymul
