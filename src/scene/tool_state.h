// SPDX-License-Identifier: MIT
//
// What every backend derives of a needle from the body it goes into, and from its poses. In double precision.
#pragma once

#include <phymul/model.h>
#include <phymul/state.h>
#include <phymul/thread.h>
#include <phymul/tool.h>

#include <span>
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

/// m: between particles; of cells alone, which have no neighbours to take it from, from the size of the body.
double needle_spacing(const Model& model);
/// m: Needle::spread, or 34 radii, but at least two spacings of the body.
double needle_spread(const Needle& needle, const Model& model);
/// m: of the weights at which a force spreads as far on every mesh.
double needle_support_radius(double spread, const Model& model);
/// Pa, [N]: the push of a tip per squared spread at which the tissue around each particle has reached its limit of
/// stretch; infinite where a particle has no material. `factors`: Scene::stiffness_factors().
void needle_bearing(const Model& model, std::span<const double> factors, std::vector<double>& bearing);
/// rad, about the needle's axis: by how much it turns between two poses. Orientations on the way between two equal ones
/// differ by rounding, which is no turning.
double needle_turn(const ToolPose& start, const ToolPose& end);

}  // namespace phymul
