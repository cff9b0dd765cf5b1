// SPDX-License-Identifier: MIT
//
// The constants and strains of a body whose material dissipates, packed for the kernels (simd::Dissipation).
#pragma once

#include "cpu/simd/job.h"
#include "elastic/dissipation.h"
#include "packed_averages.h"

namespace phymul::cpu {

class PackedDissipation {
 public:
  /// Keeps references to both.
  PackedDissipation(const TopologyTextures& topology, const PackedAverages& averages);

  void reset(const StrainMemory& memory);
  StrainMemory memory() const;

  /// For a step of `dt` s after one of `last_dt` s, 0: there was none. Valid until the next call.
  const simd::Dissipation* job(double dt, double last_dt);
  /// The step counts: the next one starts from its strains.
  void accept();

 private:
  template <class Each>
  void for_each_domain(const Each& each) const;
  float* at(Floats& rows, std::size_t columns, std::size_t place) const;
  void pack_constants(double dt);

  const TopologyTextures& topology_;
  const PackedAverages& averages_;
  const KeptStrains kept_;
  const std::size_t columns_;  // of strains
  Floats constants_, strains_, next_strains_;
  simd::Dissipation job_;
  double packed_dt_ = 0.0;
  bool fresh_ = true;
};

}  // namespace phymul::cpu
