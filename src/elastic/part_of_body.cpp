// SPDX-License-Identifier: MIT
#include "part_of_body.h"

namespace phymul {

std::vector<bool> materials_of(const TopologyTextures& t) {
  std::vector<bool> present;
  for (const DomainTexel& domain : t.domains) {
    const auto m = static_cast<std::size_t>(domain.material);
    if (m >= present.size()) present.resize(m + 1, false);
    present[m] = true;
  }
  return present;
}

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

}  // namespace

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

}  // namespace phymul
