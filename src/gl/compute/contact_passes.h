// SPDX-License-Identifier: MIT
//
// The passes of a step in which bodies touch, between free_kernel.glsl and the motion: the grid, who meets whom, the
// order in which contacts are pressed, their sweeps, and what they come to. Made where a scene has contacts.
#pragma once

#include "compute_contacts.h"

namespace phymul::gl {

class ContactPasses {
 public:
  /// Compiles.
  ContactPasses(const ShaderLibrary& library, const ComputeTables& tables, const ComputeLimits& limits);

  void set_contacts(const ComputeContacts& contacts);
  void set_step(double dt);

  /// Of the state in a pair; `rows`: of the loads, which the free pass has written.
  void act(const StorageBuffer& rows, int pair);

 private:
  Kernel compiled(const ShaderLibrary& library, ShaderRequest request, int group) const;
  void order(const ComputeContacts::Lists& lists, std::int64_t most);
  int press_dispatches() const;

  const ComputeTables* tables_;
  ComputeLimits limits_;
  int group_, most_turns_;
  Kernel grid_, order_, search_, queue_, press_, part_;
  const ComputeContacts* contacts_ = nullptr;
};

}  // namespace phymul::gl
