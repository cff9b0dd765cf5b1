// SPDX-License-Identifier: MIT
#include "material_spectra.h"

#include <phymul/elasticity.h>

#include <algorithm>

#include "part_of_body.h"
#include "scaled_stiffness.h"

namespace phymul {
namespace {

/// [domains] of the particle's volume.
std::vector<double> shares_of_volume(const TopologyTextures& t) {
  std::vector<double> volume(t.rest.size(), 0.0), share;
  for (const DomainTexel& domain : t.domains) volume[domain.particle] += 1.0 / domain.inverse_volume;
  for (const DomainTexel& domain : t.domains) share.push_back(1.0 / domain.inverse_volume / volume[domain.particle]);
  return share;
}

/// More than what Lanczos iteration may stop short of: where many eigenvalues are near the largest, a little more than
/// ritz_accuracy.
constexpr double margin = 3.0 * ritz_accuracy;

double largest_of(const TopologyTextures& part) {
  return (1.0 + margin) * estimate_spectrum(part, part.rest).largest;
}

}  // namespace

MaterialSpectra::MaterialSpectra(const TopologyTextures& topology) {
  const std::vector<bool> present = materials_of(topology);
  const std::vector<double> share = shares_of_volume(topology);
  for (std::size_t material = 0; material < present.size(); ++material) {
    if (!present[material]) continue;
    std::vector<bool> chosen(present.size(), false);
    chosen[material] = true;
    TopologyTextures part = part_of(topology, chosen).tables;
    Own own{static_cast<Index>(material), largest_of(part), 0.0};
    std::size_t row = 0;
    for (std::size_t d = 0; d < share.size(); ++d) {
      if (topology.domains[d].material == own.material) part.mass[row++] *= share[d];
    }
    own.apart = largest_of(part);
    own_.push_back(own);
  }
}

double MaterialSpectra::largest(double whole, std::span<const double> factors) const {
  const auto factor = [&](const Own& own) {
    const auto row = static_cast<std::size_t>(own.material);
    return row < factors.size() ? factors[row] : 1.0;
  };
  double apart = 0.0;
  for (const Own& own : own_) apart = std::max(apart, factor(own) * own.apart);
  const auto joined = [&](double t) {
    double sum = t * whole;
    for (const Own& own : own_) sum += std::max(factor(own) - t, 0.0) * own.joined;
    return sum;
  };
  // Convex and linear in t between factors.
  double bound = std::min(apart, joined(0.0));
  for (const Own& own : own_) bound = std::min(bound, joined(factor(own)));
  return bound;
}

}  // namespace phymul
