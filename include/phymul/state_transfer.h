// SPDX-License-Identifier: MIT
//
// The state of a body on another body of the same shape, for example one that is fine at another place.
#pragma once

#include <phymul/skin.h>
#include <phymul/state.h>

namespace phymul {

/// Binds one body to another once, for example in the thread that makes the new body, and then transfers states
/// quickly, between two ticks. Displacement and velocity of each particle of the new body are interpolated linearly in
/// the cell of the old body that holds its rest place, or that it is least outside of, as Skin does; beside a cut of
/// the new body, in the cell that holds its tissue. Particles without mass stay at rest. A rigid motion and a uniform
/// strain are kept exactly, up to rounding; momentum and energy are not. The models are not needed afterwards.
class StateTransfer {
 public:
  /// `most_outside`: as of Skin. Throws Error as Skin does for a rest place too far outside the old body.
  StateTransfer(const Model& from, const Model& to, double most_outside = 1.0);

  /// `state`: of the old body, with [N] positions, m, and velocities, m/s. Returns that of the new body at the same
  /// time. Tools keep their poses, and the next step moves the particles that they cover out of them without giving
  /// them speed (ToolState::placed; false in its place keeps a tool's force where both bodies are alike below it).
  /// Threads and fluids stay as they are: the new scene must have the same threads,
  /// sewn through the same places. Throws Error if the sizes do not agree, and (not_supported) for what names particles
  /// of the old body: a tool that holds particles, a needle or a blade in the body, passages that a needle has made, a
  /// broken joint.
  State operator()(const State& state) const;

 private:
  Skin skin_;
  VecList from_, to_;  // rest places
};

}  // namespace phymul
