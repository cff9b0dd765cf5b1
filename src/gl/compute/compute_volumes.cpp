// SPDX-License-Identifier: MIT
#include "compute_volumes.h"

namespace phymul::gl {

ComputeVolumes::ComputeVolumes(const FloatVolumes& volumes, const ComputeTables& tables, StorageRows& rows)
    : count_(volumes.count()), facet_sums_(volumes.levels.front()[1]) {
  const auto sums = static_cast<std::int64_t>(volumes.nodes.size());
  rows.add("kept_laws_place", volumes.laws);
  rows.add("kept_ranges_place", tables.by_place(volumes.ranges, 1, Int4{0, 0, -1, 0}));
  rows.add("kept_around_place", tables.placed(volumes.around, 3));
  rows.add("kept_facets_place", tables.placed(volumes.facets, 4));
  rows.add("kept_edges_place", volumes.edges);
  rows.add("kept_nodes_place", volumes.nodes);
  rows.add("kept_levels_place", volumes.levels);
  rows.take("kept_along_place", tables.places());
  rows.take("kept_sums_place", sums);
  roots_row_ = rows.add("kept_roots_place", std::vector<Float4>(static_cast<std::size_t>(count_), Float4{}));
  rows.note("kept_count", count_);
  rows.note("kept_level_count", static_cast<int>(volumes.levels.size()));
  rows.note("kept_first_total", static_cast<int>(sums) - count_);
}

}  // namespace phymul::gl
