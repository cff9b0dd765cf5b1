// SPDX-License-Identifier: MIT
#include "compute_tools.h"

#include <algorithm>

namespace phymul::gl {
namespace {

std::int64_t size_of(const auto& rows) {
  return static_cast<std::int64_t>(rows.size());
}

}  // namespace

ComputeTools::ComputeTools(const FloatTools& tools, std::int64_t first, const ComputeTables& tables)
    : tables_(&tables),
      count_(tools.count()),
      needle_count_(tools.needle_count()),
      any_grid_(tools.any_grid()),
      end_(first) {
  const auto take = [this](std::int64_t rows) {
    const std::int64_t row = end_;
    end_ += rows;
    return row;
  };
  const std::int64_t places = tables.places(), count = count_;
  laws_row_ = take(size_of(tools.laws()));
  frames_row_ = take(static_cast<std::int64_t>(tools.most_frames()));
  rest_row_ = take(static_cast<std::int64_t>(FloatTools::rest_rows) * places);
  held_row_ = take(places);
  grid_row_ = take((size_of(tools.grid_values()) + 3) / 4);
  sums_row_ = take(4 * places * count);
  parts_row_ = take(4 * most_parts * count);
  total_row_ = take(4 * count);
}

std::vector<Float4> ComputeTools::by_place(const std::vector<Float4>& by_particle, std::size_t rows_each) const {
  std::vector<Float4> rows(rows_each * static_cast<std::size_t>(tables_->places()), Float4{});
  for (std::size_t i = 0; i < by_particle.size() / rows_each; ++i) {
    const auto place = static_cast<std::size_t>(tables_->place_of()[i]);
    std::copy_n(by_particle.begin() + static_cast<std::ptrdiff_t>(rows_each * i), rows_each,
                rows.begin() + static_cast<std::ptrdiff_t>(rows_each * place));
  }
  return rows;
}

void ComputeTools::write(const FloatTools& tools, StorageBuffer& rows) const {
  rows.write(16 * laws_row_, tools.laws().data(), 16 * size_of(tools.laws()));
  const std::vector<Float4> rest = by_place(tools.rest(), FloatTools::rest_rows);
  rows.write(16 * rest_row_, rest.data(), 16 * size_of(rest));
  rows.write(16 * grid_row_, tools.grid_values().data(), 4 * size_of(tools.grid_values()));
  write_held(tools, rows);
  const std::vector<Float4> zeros(needle_count_ > 0 ? static_cast<std::size_t>(4 * tables_->places()) : 0, Float4{});
  for (int tool = 0; tool < count_; ++tool) {  // a needle tells of itself in the rows of the first place
    if (!tools.is_needle(tool)) continue;
    rows.write(16 * (sums_row_ + std::int64_t{4} * tables_->places() * tool), zeros.data(), 16 * size_of(zeros));
  }
}

void ComputeTools::write_held(const FloatTools& tools, StorageBuffer& rows) const {
  const std::vector<Float4> held = by_place(tools.held(), 1);
  rows.write(16 * held_row_, held.data(), 16 * size_of(held));
}

void ComputeTools::write_frames(const FloatTools& tools, StorageBuffer& rows) const {
  rows.write(16 * frames_row_, tools.frames().data(), 16 * size_of(tools.frames()));
}

void ComputeTools::place(Kernel& kernel) const {
  const auto set = [&](const char* name, std::int64_t row) { kernel.set(name, static_cast<int>(row)); };
  set("tool_laws_place", laws_row_);
  set("tool_frames_place", frames_row_);
  set("tool_rest_place", rest_row_);
  set("tool_held_place", held_row_);
  set("tool_grid_place", grid_row_);
  set("tool_sums_place", sums_row_);
  set("tool_count", count_);
}

}  // namespace phymul::gl
