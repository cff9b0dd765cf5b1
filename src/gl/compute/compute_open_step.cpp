// SPDX-License-Identifier: MIT
#include "compute_open_step.h"

#include <algorithm>

namespace phymul::gl {

static_assert(sizeof(OpenRow) == 3 * sizeof(Float4), "rows of gather_kernel.glsl");

ComputeOpenStep::ComputeOpenStep(const ComputeTables& tables, StorageRows& rows)
    : tables_(&tables),
      asked_row_(rows.take("gather_rows_place", tables.kind().particles)),
      gathered_row_(rows.take({}, std::int64_t{3} * tables.kind().particles)),
      push_row_(rows.take("push_rows_place", tables.kind().particles)),
      force_row_(rows.take("push_forces_place", tables.kind().particles)),
      shift_row_(rows.take("push_shifts_place", tables.kind().particles)) {
  const auto count = static_cast<std::size_t>(tables.kind().particles);
  rows_.reserve(count);
  pushes_.reserve(count);
  values_.reserve(count);
}

void ComputeOpenStep::set_gathered(std::span<const Index> rows, StorageBuffer& buffer) {
  asked_count_ = static_cast<int>(rows.size());
  rows_.clear();
  for (const Index row : rows) rows_.push_back({tables_->place_of()[static_cast<std::size_t>(row)], 0, 0, 0});
  if (!rows_.empty()) buffer.write_rows(asked_row_, rows_);
}

void ComputeOpenStep::read(std::span<OpenRow> rows, const StorageBuffer& buffer) const {
  if (!rows.empty()) buffer.read(gathered_row_, 3 * static_cast<std::int64_t>(rows.size()), rows.data());
}

void ComputeOpenStep::set_pushes(std::span<const Push> pushes, StorageBuffer& buffer) {
  push_count_ = static_cast<int>(pushes.size());
  if (pushes.empty()) return;
  pushes_.assign(pushes.begin(), pushes.end());
  for (Push& push : pushes_) push.particle = tables_->place_of()[static_cast<std::size_t>(push.particle)];
  std::ranges::sort(pushes_, {}, &Push::particle);
  rows_.clear();
  for (const Push& push : pushes_) rows_.push_back({push.particle, 0, 0, 0});
  buffer.write_rows(push_row_, rows_);
  const auto write = [&](std::int64_t row, Float4 Push::*part) {
    values_.clear();
    for (const Push& push : pushes_) values_.push_back(push.*part);
    buffer.write_rows(row, values_);
  };
  write(force_row_, &Push::force);
  write(shift_row_, &Push::shift);
}

}  // namespace phymul::gl
