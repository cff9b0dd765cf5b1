// SPDX-License-Identifier: MIT
//
// The passes of a step in which needles act, between free_kernel.glsl and what presses after them: for each needle its
// hole as it goes on, then its forces, by one group. Made where a scene has needles.
#pragma once

#include "compute_loads.h"

namespace phymul::gl {

class NeedlePasses {
 public:
  static constexpr int team = 16;  ///< lanes of a group that sum over one node
  static int group(const ComputeLimits& limits);

  /// Compiles. `bending`: some needle bends.
  NeedlePasses(const ShaderLibrary& library, const ComputeTables& tables, const ComputeLimits& limits, bool bending);

  bool bending() const { return bending_; }
  void set_needles(const ComputeLoads& loads);
  void set_step(double dt);

  /// Step `number` of a batch, from the state in a pair.
  void act(int number, int pair);

 private:
  Kernel compiled(const ShaderLibrary& library, ShaderFiles files, int group) const;

  const ComputeTables* tables_;
  ComputeLimits limits_;
  bool bending_;
  Kernel follow_, force_;
  const ComputeNeedles* needles_ = nullptr;
};

}  // namespace phymul::gl
