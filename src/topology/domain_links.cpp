// SPDX-License-Identifier: MIT
#include "averaged_body.h"

#include <algorithm>

namespace phymul {
namespace {

/// Appends rows of links to a table, equal ones of a kind once.
template <class Link>
class SharedRows {
 public:
  SharedRows(const Domains& domains, std::vector<Link>& table)
      : domains_(domains), table_(table), latest_(domains.first_of_kind.size(), none) {}

  /// Row of the table where the links of domain d begin.
  Index add(Index d, const std::vector<Link>& links) {
    // In a lattice they are mostly those of the domain before. Domains of two materials share none, because a factor of
    // Scene::scale_stiffness() is of one.
    const bool same_material = d > 0 && domains_.material[d] == domains_.material[d - 1];
    if (same_material && is(before_, links)) return rows_[before_].first;
    Index& latest = latest_[domains_.kind[d]];
    int compared = 0;
    for (Index row = latest; row != none && compared < most_compared; row = rows_[row].earlier, ++compared) {
      if (is(row, links)) return rows_[before_ = row].first;
    }
    rows_.push_back({static_cast<Index>(table_.size()), static_cast<Index>(links.size()), latest});
    table_.insert(table_.end(), links.begin(), links.end());
    return rows_[before_ = latest = static_cast<Index>(rows_.size()) - 1].first;
  }

 private:
  static constexpr int most_compared = 64;

  struct Row {
    Index first = 0, count = 0;
    Index earlier = none;  ///< the last row before it of domains of its kind
  };

  bool is(Index row, const std::vector<Link>& links) const {
    const auto [first, count, earlier] = rows_[row];
    return count == static_cast<Index>(links.size()) && std::equal(links.begin(), links.end(), table_.begin() + first);
  }

  const Domains& domains_;
  std::vector<Link>& table_;
  std::vector<Row> rows_;
  std::vector<Index> latest_;  // [kinds] the last row
  Index before_ = none;        // the row of the domain before
};

}  // namespace

void add_links(const Domains& domains, const PairStiffness& stiffness, TopologyTextures& topology) {
  SharedRows<LinkTexel> rows(domains, topology.links);
  SharedRows<SurfaceLinkTexel> surface_rows(domains, topology.surface_links);
  // Where few domains are alike most rows are stored, and a table that grows would be copied again and again.
  if (2 * domains.first_of_kind.size() > domains.particle.size()) topology.links.reserve(domains.pairs.entry.size());
  std::vector<LinkTexel> links;
  std::vector<SurfaceLinkTexel> surface_links;
  // Where row e has d: both rows are in increasing order, so that it is where the row has been read to.
  std::vector<Index> next(domains.particle.size(), 0);
  for (Index d = 0; d < domains.count(); ++d) {
    links.clear();
    surface_links.clear();
    double largest = 0.0;
    domains.for_each_pair(
        d, [&](Index, Index row) { largest = std::max(largest, domains.area[row].cwiseAbs().maxCoeff()); });
    const auto cleaned = [&](const Vec3& area) {
      return Vec3((area.array().abs() > rounding_of_area * largest).select(area, 0.0));
    };
    domains.for_each_pair(d, [&](Index e, Index row) {
      const Index reverse = next[e]++;
      const Vec3 &there = domains.area[row], &back = domains.area[domains.first_pair(e) + reverse];
      const Vec3 surface = cleaned(0.5 * (there + back));
      if (surface != Vec3::Zero()) surface_links.push_back({e - d, surface});
      if (e == d) return;
      const Index at = e < d ? stiffness.first[d] + row - domains.first_pair(d) : stiffness.first[e] + reverse;
      links.push_back({e - d, cleaned(0.5 * (there - back)), stiffness.value[at]});
    });
    DomainTexel& domain = topology.domains[d];
    domain.first_link = rows.add(d, links);
    domain.link_count = static_cast<Index>(links.size());
    domain.first_surface_link = surface_rows.add(d, surface_links);
    domain.surface_link_count = static_cast<Index>(surface_links.size());
  }
  topology.links.shrink_to_fit();
  topology.surface_links.shrink_to_fit();
}

}  // namespace phymul
