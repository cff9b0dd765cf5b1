// SPDX-License-Identifier: MIT
//
// Energy and momentum of the present state: sums a group on the device, the sum of those here. Compiled at the first
// call.
#pragma once

#include <array>
#include <deque>

#include "compute_passes.h"

namespace phymul::gl {

class ComputeSums {
 public:
  ComputeSums(ComputePasses& passes, const ComputeLimits& limits) : passes_(&passes), limits_(limits) {}

  /// `loads` with one instant evaluated, the state's; dt: of the last step, or 0. Overwrites what passes.evaluate()
  /// writes.
  Energy energy(const ComputeState& state, const ComputeLoads& loads, double dt);

  /// Linear and angular momentum about `about`.
  Momentum momentum(const ComputeState& state, const VecList& rest, const Vec3& about);

 private:
  using Sums = std::array<std::array<double, 4>, 2>;
  struct ParticleEnergy {
    LoadKind loads;
    Kernel kernel;
  };
  Kernel compiled(ShaderRequest request, const char* pass, const char* what, const ComputeState& state) const;
  Kernel& energy_of_particles(const LoadKind& loads, const ComputeState& state);
  Sums total(Kernel& kernel, int rows, const ComputeState& state) const;
  void compile_momenta(const VecList& rest, const ComputeState& state);

  ComputePasses* passes_;
  ComputeLimits limits_;
  std::deque<ParticleEnergy> energies_;
  Kernel volumes_, domains_, momenta_;
  StorageBuffer rest_;
  Vec3 middle_{0, 0, 0};
};

}  // namespace phymul::gl
