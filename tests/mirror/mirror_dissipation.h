// SPDX-License-Identifier: MIT
//
// Materials that dissipate, as glsl/step/dissipation.glsl computes their stresses and the strains that domains keep.
#pragma once

#include <array>
#include <vector>

#include "device/float_dissipation.h"
#include "kernels.h"

namespace phymul::cpu {

class MirrorDissipation {
 public:
  using Of = GreenStrain<float>;

  MirrorDissipation(const TopologyTextures& topology, const std::vector<Index>& source);

  bool empty() const { return kept_.count() == 0; }
  /// From now on the strains of a domain are its own, until a step is accepted.
  void reset() { fresh_ = true; }

  /// Of `dt`, s, after one of `last_dt`, 0: there was none.
  void begin_step(double dt, double last_dt);
  /// First Piola stress of a domain. Keeps its strains for the step after this one.
  Columns<float> stress(Index d, const Columns<float>& H);
  void accept();

 private:
  using Kept = std::array<Of::Symmetric, 2>;  // of the rate, of the branch

  FloatDissipation rows_;
  const KeptStrains kept_;
  std::vector<Float4> constants_;
  double packed_dt_ = 0.0;
  float inverse_last_dt_ = 0.0f;
  bool fresh_ = true;
  std::vector<Kept> strains_, next_;
};

}  // namespace phymul::cpu
