// SPDX-License-Identifier: MIT
#include "neighbourhoods.h"

#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace phymul {
namespace {

// Room for rounding, so that equal bases on equal neighbourhoods pass or fail together.
constexpr double threshold_slack = 1e-9;

bool passes(const RestBase& base, const TopologyOptions& options) {
  if (!has_plane(base)) return false;
  if (options.bases == BaseSelection::all) return true;
  if (base.quality < options.min_quality * (1 - threshold_slack)) return false;
  return std::ranges::all_of(base.lambda, [&options](double lambda) {
    return std::abs(lambda) <= options.max_barycentric * (1 + threshold_slack);
  });
}

void append_row(const std::vector<RestBase>& row, BaseTable& table) {
  constexpr std::size_t most = std::numeric_limits<Index>::max() / 3;
  if (table.base.size() + row.size() > most) {
    throw Error("the table of bases needs more than " + std::to_string(most) +
                " rows, which is all that 32-bit numbers allow. Use fewer neighbours or a sparser base selection");
  }
  table.base.insert(table.base.end(), row.begin(), row.end());
  table.weight.insert(table.weight.end(), row.size(), row.empty() ? 0.0 : 1.0 / static_cast<double>(row.size()));
  table.offset.push_back(table.base.size());
}

}  // namespace

std::vector<RestBase> neighbour_bases(const Model& model, Index owner, const TopologyOptions& options) {
  const Index* n = model.neighbours.begin(owner);
  const Index count = model.neighbours.size(owner);
  std::vector<RestBase> result;
  const auto keep = [&](const std::array<Index, 3>& vertex) {
    const RestBase base = rest_base(model.rest, owner, vertex);
    if (passes(base, options)) result.push_back(base);
  };
  for (Index j = 0; j < count; ++j) {
    for (Index k = j + 1; k < count; ++k) {
      if (model.dimension == 2) keep({n[j], n[k], -1});
      for (Index l = k + 1; l < count && model.dimension == 3; ++l) keep({n[j], n[k], n[l]});
    }
  }
  return result;
}

BaseTable select_bases(const Model& model, const TopologyOptions& options) {
  BaseTable table;
  table.stiffness = model.stiffness;
  for (Index i = 0; i < model.particle_count(); ++i) append_row(neighbour_bases(model, i, options), table);
  return table;
}

namespace {

/// Enumerated triples without a base cost time for nothing, but less than half of what a base from a table does.
constexpr double most_triples_a_base = 1.5;

std::int64_t triple_count(std::int64_t neighbours) {
  return neighbours * (neighbours - 1) * (neighbours - 2) / 6;
}

}  // namespace

Index triple_row(Index n, Index j, Index k, Index l) {
  const auto pairs = [](Index m) { return m * (m - 1) / 2; };
  return static_cast<Index>(triple_count(n) - triple_count(n - j)) + pairs(n - j - 1) - pairs(n - k) + (l - k - 1);
}

Triples triples_of(const TopologyTextures& t, Index i) {
  Triples triples;
  const IndexTexel& at = t.index[i];
  if (at.base_count == 0) return triples;
  const auto row = t.neighbours.begin() + at.first_neighbour;
  const auto count = static_cast<Index>(at.neighbour_count);
  triples.neighbour.assign(row, row + count);
  triples.alpha.assign(t.alpha.begin() + at.first_neighbour, t.alpha.begin() + at.first_neighbour + count);
  triples.base.assign(static_cast<std::size_t>(triple_count(count)), none);
  for (Index b = at.first_base; b < at.first_base + at.base_count; ++b) {
    std::array<Index, 3> place{};
    for (int k = 0; k < 3; ++k) {
      place[k] = static_cast<Index>(std::find(row, row + count, t.bases[b].vertex[k]) - row);
    }
    std::ranges::sort(place);
    triples.base[triple_row(count, place[0], place[1], place[2])] = b;
  }
  return triples;
}

bool is_enumerable(const TopologyTextures& t, Index most) {
  const bool plain = t.dimension == 3 && t.options.reaction != Reaction::conservative;
  if (!plain || t.base_count == 0) return false;
  std::int64_t triples = 0;
  for (Index i = 0; i < t.particle_count; ++i) {
    const IndexTexel& at = t.index[i];
    if (at.base_count == 0) continue;
    if (at.neighbour_count > most) return false;
    triples += triple_count(at.neighbour_count);
    const auto row = t.neighbours.begin() + at.first_neighbour;
    for (Index b = at.first_base; b < at.first_base + at.base_count; ++b) {
      const auto& vertex = t.bases[b].vertex;
      const bool among = std::ranges::all_of(
          vertex, [&](Index v) { return std::find(row, row + at.neighbour_count, v) != row + at.neighbour_count; });
      if (!among) return false;
    }
  }
  return static_cast<double>(triples) <= most_triples_a_base * t.base_count;
}

}  // namespace phymul
