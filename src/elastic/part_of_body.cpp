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

PartOfBody part_of(const TopologyTextures& t, const std::vector<bool>& chosen) {
  PartOfBody part;
  TopologyTextures& to = part.tables;
  to.options = t.options;
  to.dimension = t.dimension;
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
      for (Index r = t.first_link[d]; r < t.first_link[d + 1]; ++r) {
        to.links.push_back(t.links[r]);
        to.links.back().domain = row[t.links[r].domain];
      }
      to.first_link.push_back(static_cast<Index>(to.links.size()));
      for (Index r = t.first_surface_link[d]; r < t.first_surface_link[d + 1]; ++r) {
        to.surface_links.push_back(t.surface_links[r]);
        to.surface_links.back().domain = row[t.surface_links[r].domain];
      }
      to.first_surface_link.push_back(static_cast<Index>(to.surface_links.size()));
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
