// SPDX-License-Identifier: MIT
#include "compute_tools.h"

namespace phymul::gl {

ComputeTools::ComputeTools(const FloatTools& tools, bool acts, const ComputeTables& tables, StorageRows& rows)
    : tables_(&tables),
      count_(tools.count()),
      acts_(acts),
      any_grid_(acts && tools.any_grid()),
      frames_row_(rows.take("tool_frames_place", static_cast<std::int64_t>(tools.most_frames()))),
      held_row_(rows.add("tool_held_place", tables.by_place(tools.held()))) {
  rows.note("tool_count", count_);
  if (!acts_) return;
  rows.add("tool_laws_place", tools.laws());
  rows.add("tool_rest_place", tables.by_place(tools.rest(), FloatTools::rest_rows));
  rows.add("tool_grid_place", tools.grid_values());
  sums_row_ = rows.take("tool_sums_place", std::int64_t{4} * tables.places() * count_);
  parts_row_ = rows.take({}, std::int64_t{4} * most_parts * count_);
  total_row_ = rows.take({}, std::int64_t{4} * count_);
}

void ComputeTools::write_held(const FloatTools& tools, StorageBuffer& buffer) const {
  buffer.write_rows(held_row_, tables_->by_place(tools.held()));
}

void ComputeTools::write_frames(const FloatTools& tools, StorageBuffer& buffer) const {
  buffer.write_rows(frames_row_, tools.frames());
}

}  // namespace phymul::gl
