// SPDX-License-Identifier: MIT
//
// The state of a body on another body of the same shape: one filled anew, finer at another place, say.
#pragma once

#include <phymul/state.h>

namespace phymul {

/// The state of `from` on `to`: displacement and velocity of each particle of `to` are interpolated linearly in the
/// cell of `from` that holds its rest place, or that it is least outside of, as Skin does. A rigid motion and a uniform
/// strain are kept exactly, up to rounding; momentum and energy are not. `state`: of `from`, with [N] positions, m, and
/// velocities, m/s. Tools keep their poses, and the next step moves the particles that they cover out of them without
/// giving them speed (ToolState::placed). Throws Error if the sizes do not agree, as Skin does for a place too far
/// outside, and (not_supported) for what names particles of the old body: a tool that holds particles, a needle in the
/// body, a broken joint.
State transfer_state(const Model& from, const State& state, const Model& to, double most_outside = 1.0);

}  // namespace phymul
