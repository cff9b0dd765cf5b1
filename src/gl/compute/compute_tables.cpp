// SPDX-License-Identifier: MIT
#include "compute_tables.h"

namespace phymul::gl {
namespace {

/// With heights and loads apart a shader sees five buffers; OpenGL ES 3.1 promises four.
constexpr int most_blocks = 5;

}  // namespace

template <class Row>
void ComputeTables::add(const char* name, const std::vector<Row>& rows) {
  if (rows.empty()) return;
  const auto bytes = static_cast<std::int64_t>(rows.size() * sizeof(Row));
  tables_.push_back({name, rows.data(), bytes, bytes_, sizeof(Row) < sizeof(Int4)});
  bytes_ += (bytes + 15) / 16 * 16;
}

void ComputeTables::add_entries(const FloatTables& rows) {
  const auto append = [this](const std::vector<std::int32_t>& list) {
    const auto start = static_cast<int>(entries_.size());
    entries_.insert(entries_.end(), list.begin(), list.end());
    return start;
  };
  append(rows.reaction);
  volume_start_ = append(rows.volume_entry);
  spring_start_ = append(rows.spring_other);
  add("entries_place", entries_);
}

void ComputeTables::add_all(const SliceTables& slices) {
  const FloatTables& rows = slices.rows;
  add("particle_place", rows.particle);
  add("order_place", slices.order);
  add("neighbour_ranges_place", slices.neighbours);
  add("base_ranges_place", kind_.enumerated ? slices.heights : slices.bases);
  add("reaction_ranges_place", slices.reactions);
  add("volume_ranges_place", slices.volumes);
  add("spring_ranges_place", slices.springs);
  add("neighbours_place", rows.neighbour);
  add("alpha_place", rows.alpha);
  add("edge_alpha_place", rows.edge_alpha);
  if (!heights_apart_) add("height_place", rows.height);
  add("bases_place", rows.base);
  add("base_e1_place", rows.base_e1);
  add("base_e2_place", rows.base_e2);
  add("base_share_place", rows.base_share);
  add("share_place", rows.share);
  add_entries(rows);
  add("volume_place", rows.volume);
  add("volume_e1_place", rows.volume_e1);
  add("volume_e2_place", rows.volume_e2);
  add("volume_e3_place", rows.volume_e3);
  add("spring_place", rows.spring);
  add("domain_range_place", rows.domains.range);
  add("domain_law_place", rows.domains.law);
  add("domain_owner_place", rows.domains.owner);
  add("link_domain_place", rows.domains.neighbour);
  add("link_place", rows.domains.link);
}

ComputeTables::ComputeTables(const SliceTables& slices, const ComputeLimits& limits)
    : kind_(slices.rows),
      places_(slices.place_count()),
      slice_(slices.slice),
      place_of_(slices.place_of),
      heights_apart_(!slices.rows.height.empty() && limits.blocks >= most_blocks) {
  add_all(slices);
  constants_ = StorageBuffer((bytes_ + 15) / 16, "the body's constants", limits);
  for (Table& table : tables_) {
    constants_.write(table.first_byte, table.data, table.bytes);
    table.data = nullptr;
  }
  entries_ = {};
  if (!heights_apart_) return;
  const auto rows = static_cast<std::int64_t>(slices.rows.height.size());
  heights_ = StorageBuffer(rows, "the heights of bases", limits);
  heights_.write(0, slices.rows.height.data(), rows * 16);
}

void ComputeTables::bind() const {
  constants_.bind(constant_rows_binding);
  constants_.bind(constant_words_binding);
  if (heights_) heights_.bind(heights_binding);
}

void ComputeTables::define(ShaderRequest& request) const {
  define_kernels(kind_, request);
  request.defines.emplace_back("SLICE", slice_);
  if (heights_apart_) request.defines.emplace_back("HEIGHTS_APART", 1);
}

void ComputeTables::place(Kernel& kernel) const {
  for (const Table& table : tables_) {
    kernel.set(table.name, static_cast<int>(table.first_byte / (table.by_words ? 4 : 16)));
  }
  kernel.set("particle_count", kind_.particles);
  kernel.set("place_count", places_);
  kernel.set("volume_start", volume_start_);
  kernel.set("spring_start", spring_start_);
}

}  // namespace phymul::gl
