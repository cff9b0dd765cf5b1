// SPDX-License-Identifier: MIT
#include "float_dissipation.h"

#include <cmath>
#include <utility>

#include "float_range.h"

namespace phymul {

FloatDissipation::FloatDissipation(const TopologyTextures& topology, std::vector<Index> source)
    : topology_(topology),
      source_(std::move(source)),
      kinds_(kept_strains(topology).count()),
      constants_(2 * source_.size(), Float4{}) {
  constants(0.0);  // those of any step are not larger
}

const std::vector<Float4>& FloatDissipation::constants(double dt) {
  for (std::size_t row = 0; row < source_.size(); ++row) {
    if (source_[row] == none) continue;
    const DissipationTexel& of = topology_.dissipation[source_[row]];
    const double e = of.relaxation_strength > 0.0 ? std::exp(-dt / of.relaxation_time) : 1.0;
    const double branch = of.relaxation_strength * std::sqrt(e);
    constants_[2 * row] = {narrow(2.0 * of.mu * of.retardation_time), narrow(of.lambda * of.retardation_time),
                           narrow(2.0 * of.mu * branch), narrow(of.lambda * branch)};
    constants_[2 * row + 1][0] = static_cast<float>(1.0 - e);
  }
  return constants_;
}

std::vector<Float4> FloatDissipation::rows(const StrainMemory& memory) const {
  std::vector<Float4> rows(strain_texels * source_.size(), Float4{});
  for (std::size_t row = 0; row < source_.size(); ++row) {
    if (source_[row] == none) continue;
    for (std::size_t k = 0; k < 6 * kinds_; ++k) {
      const Strain& strain = memory[static_cast<std::size_t>(source_[row]) * kinds_ + k / 6];
      rows[strain_texels * row + k / 3][k % 3] = static_cast<float>(strain[k % 6]);
    }
  }
  return rows;
}

StrainMemory FloatDissipation::memory(std::span<const Float4> rows) const {
  StrainMemory memory(topology_.dissipation.size() * kinds_);
  for (std::size_t row = 0; row < source_.size(); ++row) {
    if (source_[row] == none) continue;
    for (std::size_t k = 0; k < 6 * kinds_; ++k) {
      Strain& strain = memory[static_cast<std::size_t>(source_[row]) * kinds_ + k / 6];
      strain[k % 6] = rows[strain_texels * row + k / 3][k % 3];
    }
  }
  return memory;
}

}  // namespace phymul
