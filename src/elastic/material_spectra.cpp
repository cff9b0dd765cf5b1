// SPDX-License-Identifier: MIT
#include "material_spectra.h"

#include <phymul/elasticity.h>

#include <algorithm>
#include <limits>

#include "scaled_stiffness.h"

namespace phymul {
namespace {

/// Domains of one material and nothing else; particle d is the one of domain d.
TopologyTextures part_of(const TopologyTextures& whole, Index material) {
  TopologyTextures part;
  part.options = whole.options;
  part.dimension = whole.dimension;
  std::vector<Index> row(whole.domains.size(), none);
  for (std::size_t d = 0; d < whole.domains.size(); ++d) {
    if (whole.domains[d].material != material) continue;
    row[d] = part.particle_count++;
    part.domains.push_back(whole.domains[d]);
    part.domains.back().particle = row[d];
    part.rest.push_back(whole.rest[whole.domains[d].particle]);
    part.mass.push_back(whole.mass[whole.domains[d].particle]);
  }
  part.index.resize(part.rest.size());
  // Links join domains of one material.
  for (std::size_t d = 0; d < whole.domains.size(); ++d) {
    if (row[d] == none) continue;
    for (Index r = whole.first_link[d]; r < whole.first_link[d + 1]; ++r) {
      part.links.push_back(whole.links[r]);
      part.links.back().domain = row[whole.links[r].domain];
    }
    for (Index r = whole.first_surface_link[d]; r < whole.first_surface_link[d + 1]; ++r) {
      part.surface_links.push_back(whole.surface_links[r]);
      part.surface_links.back().domain = row[whole.surface_links[r].domain];
    }
    part.first_link.push_back(static_cast<Index>(part.links.size()));
    part.first_surface_link.push_back(static_cast<Index>(part.surface_links.size()));
  }
  return part;
}

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
  std::vector<Index> materials;
  for (const DomainTexel& domain : topology.domains) materials.push_back(domain.material);
  std::ranges::sort(materials);
  const auto repeated = std::ranges::unique(materials);
  materials.erase(repeated.begin(), repeated.end());
  const std::vector<double> share = shares_of_volume(topology);
  for (const Index material : materials) {
    TopologyTextures part = part_of(topology, material);
    Own own{material, largest_of(part), 0.0};
    std::size_t row = 0;
    for (std::size_t d = 0; d < share.size(); ++d) {
      if (topology.domains[d].material == material) part.mass[row++] *= share[d];
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
