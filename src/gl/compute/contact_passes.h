// SPDX-License-Identifier: MIT
//
// The passes of a step in which bodies touch, between free_kernel.glsl and the motion: the grid, who meets whom, the
// order in which contacts are pressed, their sweeps, and what they come to. Made where a scene has contacts.
#pragma once

#include "compute_loads.h"

namespace phymul::gl {

class ContactPasses {
 public:
  /// Compiles.
  ContactPasses(const ShaderLibrary& library, const ComputeTables& tables, const ComputeLimits& limits);

  void set_contacts(const ComputeLoads& loads);
  void set_step(double dt);

  /// Of the state in a pair, once the free pass has written its rows of the loads.
  void act(int pair);

 private:
  void order(const ComputeContacts::Lists& lists, std::int64_t most);
  int press_dispatches() const;

  const ComputeTables* tables_;
  int group_, most_turns_;
  Kernel grid_, order_, search_, queue_, press_, part_;
  const ComputeLoads* loads_ = nullptr;
};

}  // namespace phymul::gl
