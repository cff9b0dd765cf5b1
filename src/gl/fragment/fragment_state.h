// SPDX-License-Identifier: MIT
//
// Where the particles are, on the device: three pairs of textures, displacement (m) and velocity (m/s).
#pragma once

#include <phymul/state.h>

#include <array>

#include "gl/objects/pass.h"
#include "gl/solver/state_copies.h"

namespace phymul::gl {

class FragmentState : public StatePairs {
 public:
  explicit FragmentState(Index particles);

  const Texture& displacement() const { return displacement_[current()]; }
  const Texture& velocity() const { return velocity_[current()]; }
  const Texture& measured() const { return measured_; }  ///< written by steps that are drawn with `measuring`

  // Of the free pair.
  const Framebuffer& next(bool measuring) const { return (measuring ? measuring_ : plain_)[free_pair()]; }
  const Texture& next_displacement() const { return displacement_[free_pair()]; }
  const Texture& next_velocity() const { return velocity_[free_pair()]; }

  /// Framebuffer of the current state, to be read: displacement at 0, velocity at 1.
  const Framebuffer& framebuffer() const { return plain_[current()]; }

  void request_copy(StateCopies& copies, const State& header) const;
  void read(const VecList& rest, State& state) const;
  void write(const VecList& rest, const State& state);

 private:
  std::array<Texture, pairs> displacement_, velocity_;
  Texture measured_;  // speed, acceleration, force, displacement
  std::array<Framebuffer, pairs> plain_, measuring_;
};

}  // namespace phymul::gl
