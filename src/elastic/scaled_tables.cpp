// SPDX-License-Identifier: MIT
#include "scaled_tables.h"

#include <algorithm>

#include "topology/energies.h"

namespace phymul {

const TopologyTextures& ScaledTables::of(const TopologyTextures& topology, std::span<const double> factors) {
  if (factors.empty()) return topology;
  const bool same_body = scaled_ && scaled_->edits == topology.edits;
  if (same_body && std::ranges::equal(factors, factors_)) return *scaled_;
  if (!same_body) scaled_ = topology;
  const std::size_t moduli = kind_of(topology.options.strain_energy).moduli;
  for (std::size_t d = 0; d < topology.domains.size(); ++d) {
    const DomainTexel& own = topology.domains[d];
    DomainTexel& domain = scaled_->domains[d];
    // Tables of a model that was given more materials since have rows that the scene does not know.
    const auto material = static_cast<std::size_t>(own.material);
    const double factor = material < factors.size() ? factors[material] : 1.0;
    domain.spread_stiffness = factor * own.spread_stiffness;
    for (std::size_t k = 0; k < moduli; ++k) {
      scaled_->energies[own.energy][k] = factor * topology.energies[own.energy][k];
    }
    if (!topology.dissipation.empty()) {
      scaled_->dissipation[d].mu = factor * topology.dissipation[d].mu;
      scaled_->dissipation[d].lambda = factor * topology.dissipation[d].lambda;
    }
    // Links join domains of one material, and domains that share their rows are of one.
    for (Index row = own.first_link; row < own.first_link + own.link_count; ++row) {
      scaled_->links[row].stiffness = factor * topology.links[row].stiffness;
    }
  }
  factors_.assign(factors.begin(), factors.end());
  return *scaled_;
}

}  // namespace phymul
