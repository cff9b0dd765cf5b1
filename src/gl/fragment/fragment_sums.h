// SPDX-License-Identifier: MIT
//
// Energy and momentum of the present state, summed up on the device. Compiled at the first call.
#pragma once

#include <phymul/solver.h>

#include <array>
#include <deque>
#include <optional>
#include <vector>

#include "fragment_passes.h"

namespace phymul::gl {

class FragmentSums {
 public:
  FragmentSums(const ShaderLibrary& library, FragmentPasses& passes) : library_(&library), passes_(&passes) {}

  /// `loads` with one instant evaluated, the state's; dt: of the last step, or 0. Overwrites what passes.evaluate()
  /// writes.
  Energy energy(const FragmentState& state, const FragmentLoads& loads, double dt);

  /// Linear and angular momentum about `about`.
  Momentum momentum(const FragmentState& state, const VecList& rest, const Vec3& about);

 private:
  using Sum = std::array<double, 4>;
  struct Terms {  // of one kind: a row each, written by a pass and summed
    Terms(Pass writing, int row_count, int targets);
    Pass pass;
    std::vector<Texture> texels;  // per target
    Framebuffer target;
    int rows = 0;
  };
  struct ParticleEnergy {
    LoadKind loads;
    Terms terms;
  };

  Sum total(const Texture& terms, int rows);
  Terms& particle_energy(const LoadKind& loads);
  void compile_shared_terms();

  const ShaderLibrary* library_;
  FragmentPasses* passes_;
  std::optional<Pass> added_;
  std::deque<ParticleEnergy> particle_energies_;
  std::deque<Terms> shared_;  // volumes, domains
  std::optional<Terms> momentum_;
  Texture rest_;
  Vec3 middle_{0, 0, 0};
};

}  // namespace phymul::gl
