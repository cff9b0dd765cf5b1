// SPDX-License-Identifier: MIT
#include "material_spectra.h"

#include <phymul/elasticity.h>

#include <algorithm>

#include "scaled_tables.h"

namespace phymul {
namespace {

/// Row of the first. `row`: number of each domain in the part.
template <class Link>
Index append_links(std::span<const Link> links, Index d, const std::vector<Index>& row, std::vector<Link>& to) {
  const auto first = static_cast<Index>(to.size());
  for (const Link& link : links) {
    to.push_back(link);
    to.back().offset = row[d + link.offset] - row[d];
  }
  return first;
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

std::vector<bool> materials_of(const TopologyTextures& t) {
  std::vector<bool> present;
  for (const DomainTexel& domain : t.domains) {
    const auto m = static_cast<std::size_t>(domain.material);
    if (m >= present.size()) present.resize(m + 1, false);
    present[m] = true;
  }
  return present;
}

PartOfBody part_of(const TopologyTextures& t, const std::vector<bool>& chosen) {
  PartOfBody part;
  TopologyTextures& to = part.tables;
  to.options = t.options;
  to.dimension = t.dimension;
  to.energies = t.energies;
  std::vector<Index> row(t.domains.size(), none);  // of a domain in `to`
  Index rows = 0;
  for (std::size_t d = 0; d < t.domains.size(); ++d) {
    const auto m = static_cast<std::size_t>(t.domains[d].material);
    if (m < chosen.size() && chosen[m]) row[d] = rows++;
  }
  to.first_domain.push_back(0);
  for (Index i = 0; i < t.particle_count; ++i) {
    const std::size_t before = to.domains.size();
    for (Index d = t.first_domain[i]; d < t.first_domain[i + 1]; ++d) {
      if (row[d] == none) continue;
      to.domains.push_back(t.domains[d]);
      to.domains.back().particle = static_cast<Index>(part.particle.size());
      if (!t.dissipation.empty()) to.dissipation.push_back(t.dissipation[d]);
      to.domains.back().first_link = append_links(t.links_of(d), d, row, to.links);
      to.domains.back().first_surface_link = append_links(t.surface_links_of(d), d, row, to.surface_links);
    }
    if (to.domains.size() == before) continue;
    part.particle.push_back(i);
    to.rest.push_back(t.rest[i]);
    to.mass.push_back(t.mass[i]);
    to.first_domain.push_back(static_cast<Index>(to.domains.size()));
  }
  to.particle_count = static_cast<Index>(part.particle.size());
  to.index.resize(part.particle.size());
  return part;
}

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
