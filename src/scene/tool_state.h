// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/state.h>
#include <phymul/thread.h>

#include <vector>

namespace phymul {

/// Which fewer backends take than rigid tools.
bool has_needle(const std::vector<SceneTool>& tools);
/// Whether a tool has ToolContact::surface.
bool touches_surface(const std::vector<SceneTool>& tools);

/// Throws Error where a tool's part of a state does not fit a model of so many particles, or is one that the shape of
/// the scene's tool of that name cannot have.
void require_tool_states(const State& state, Index particle_count, const std::vector<SceneTool>& tools);

bool fits(const ThreadState& state, const SceneThread& thread);

/// Throws Error where a thread's part of a state does not fit the scene's thread of that name.
void require_thread_states(const State& state, const std::vector<SceneThread>& threads);

}  // namespace phymul
