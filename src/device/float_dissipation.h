// SPDX-License-Identifier: MIT
//
// Materials that dissipate, in single precision: the constants of a step and the strains that domains keep, in the rows
// of a device's domains.
#pragma once

#include <phymul/topology_textures.h>

#include <span>
#include <vector>

#include "elastic/dissipation.h"
#include "table_rows.h"

namespace phymul {

class FloatDissipation {
 public:
  /// Texels of a row of strains. Those behind the strains that the body keeps are 0.
  static constexpr std::size_t strain_texels = 4;

  /// `source`: FloatDomains::source. Keeps a reference to `topology`. Throws Error if a constant is beyond single
  /// precision.
  FloatDissipation(const TopologyTextures& topology, std::vector<Index> source);

  /// Two texels per domain, of steps of `dt`, s: 2 mu T, lambda T, 2 mu b, lambda b, with T the retardation time and b
  /// the relaxation strength over the middle of the step; 1 - exp(-dt / tau), 0, 0, 0. Valid until the next call.
  const std::vector<Float4>& constants(double dt);

  /// [domains * strain_texels]: xx, yy, zz, 0, yz, zx, xy, 0 of the rate's strain, then of the branch's.
  std::vector<Float4> rows(const StrainMemory& memory) const;
  StrainMemory memory(std::span<const Float4> rows) const;

 private:
  const TopologyTextures& topology_;
  const std::vector<Index> source_;
  const std::size_t kinds_;
  std::vector<Float4> constants_;
};

}  // namespace phymul
