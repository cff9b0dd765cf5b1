// SPDX-License-Identifier: MIT
#include "averaged_body.h"

#include <algorithm>
#include <cstdint>
#include <unordered_map>

#include "base/union_find.h"

namespace phymul {
namespace {

/// Two places count as the same if they differ by less than this share of their distance from the domain's own.
/// Coordinates of a lattice have a tenth of it where they are a thousand cells from the origin. Sums of links that
/// should be zero must stay below the `rounding` of domain_links.cpp.
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

void find_kinds(const Model& model, const RaggedList& cells, Domains& domains) {
  AlikeDomains(model, cells, domains).find();
}

}  // namespace phymul
