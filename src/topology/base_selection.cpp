// SPDX-License-Identifier: MIT
#include "base_selection.h"

#include <phymul/error.h>

#include <algorithm>
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

}  // namespace phymul
