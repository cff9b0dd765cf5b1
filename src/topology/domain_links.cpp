// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdint>
#include <unordered_map>

#include "averaged_body.h"
#include "base/union_find.h"

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

/// Two places count as the same if they differ by less than this share of their distance from the domain's own.
/// Coordinates of a lattice have a tenth of it where they are a thousand cells from the origin. Sums of links that
/// should be zero must stay below rounding_of_area.
constexpr double same_place = 1e-12;

/// Kinds of one key that a domain is compared with, the first ones: where no two are alike the search must end.
constexpr std::size_t most_compared = 8;

class AlikeDomains {
 public:
  AlikeDomains(const Model& model, const RaggedList& cells, Domains& domains)
      : model_(model), cells_(cells), domains_(domains), parts_(domains.particle.size()) {
    for (Index row = 0; row < domains.of_cell.rows(); ++row) {
      for (const Index* d = domains.of_cell.begin(row); d != domains.of_cell.end(row); ++d) {
        parts_.join(*d, *domains.of_cell.begin(row));
      }
    }
  }

  void find() {
    std::unordered_map<std::uint64_t, std::vector<Index>> known;  // kinds by key
    Index before = none;                                          // the kind of the domain before
    for (Index d = 0; d < domains_.count(); ++d) {
      const auto is_of = [&](Index kind) { return alike(d, domains_.first_of_kind[kind]); };
      // In a lattice it is mostly the kind of the domain before.
      if (before == none || !is_of(before)) {
        std::vector<Index>& same_key = known[key(d)];
        const auto found = std::ranges::find_if(same_key, is_of);
        before = found != same_key.end() ? *found : static_cast<Index>(domains_.first_of_kind.size());
        if (found == same_key.end()) {
          domains_.first_of_kind.push_back(d);
          if (same_key.size() < most_compared) same_key.push_back(before);
        }
      }
      domains_.kind.push_back(before);
    }
  }

 private:
  const Cell& cell_of(Index entry) const { return model_.cells[entry / most_vertices]; }
  const Vec3& place(Index d) const { return model_.rest[domains_.particle[d]]; }

  /// Hash of all that must be equal but the places.
  std::uint64_t key(Index d) {
    std::uint64_t sum = 0;
    const auto add = [&sum](Index number) {
      sum = (sum ^ static_cast<std::uint32_t>(number)) * 0x9e3779b97f4a7c15ull;  // odd, its bits spread well
      sum ^= sum >> 32;
    };
    add(parts_.root(d));
    add(domains_.material[d]);
    for (const Index* entry = cells_.begin(d); entry != cells_.end(d); ++entry) {
      add(static_cast<Index>(cell_of(*entry).type));
      if (cell_of(*entry).share != 1.0) add(d);  // parts of cut cells are like no other
      add(*entry % most_vertices);
      const Index cell = *entry / most_vertices;
      for (const Index* e = domains_.of_cell.begin(cell); e != domains_.of_cell.end(cell); ++e) add(*e - d);
    }
    return sum;
  }

  bool alike(Index d, Index other) {
    if (cells_.size(d) != cells_.size(other) || domains_.material[d] != domains_.material[other]) return false;
    if (parts_.root(d) != parts_.root(other)) return false;
    const Index* b = cells_.begin(other);
    for (const Index* a = cells_.begin(d); a != cells_.end(d); ++a, ++b) {
      if (cell_of(*a).share != 1.0 || cell_of(*b).share != 1.0) return false;
      if (cell_of(*a).type != cell_of(*b).type || *a % most_vertices != *b % most_vertices) return false;
      const Index cell = *a / most_vertices;
      const Index* f = domains_.of_cell.begin(*b / most_vertices);
      for (const Index* e = domains_.of_cell.begin(cell); e != domains_.of_cell.end(cell); ++e, ++f) {
        if (*e - d != *f - other) return false;
        const Vec3 there = place(*e) - place(d), difference = there - (place(*f) - place(other));
        if (difference.cwiseAbs().maxCoeff() > same_place * there.cwiseAbs().maxCoeff()) return false;
      }
    }
    return true;
  }

  const Model& model_;
  const RaggedList& cells_;
  Domains& domains_;
  UnionFind parts_;  // of domains that cells join
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

void find_kinds(const Model& model, const RaggedList& cells, Domains& domains) {
  AlikeDomains(model, cells, domains).find();
}

}  // namespace phymul
