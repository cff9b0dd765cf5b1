// SPDX-License-Identifier: MIT
#include "compute_tables.h"

namespace phymul::gl {

void ComputeTables::add_entries(const FloatTables& rows) {
  std::vector<std::int32_t> entries;
  const auto append = [&entries](const std::vector<std::int32_t>& list) {
    const auto start = static_cast<int>(entries.size());
    entries.insert(entries.end(), list.begin(), list.end());
    return start;
  };
  append(rows.reaction);
  rows_.note("volume_start", append(rows.volume_entry));
  rows_.note("spring_start", append(rows.spring_other));
  rows_.note("entries_place", static_cast<int>(4 * rows_.add(nullptr, std::move(entries))));
}

void ComputeTables::add_all(const SliceTables& slices) {
  const FloatTables& rows = slices.rows;
  rows_.add("particle_place", rows.particle);
  rows_.add_words("order_place", slices.order);
  rows_.add_words("neighbour_ranges_place", slices.neighbours);
  rows_.add_words("base_ranges_place", kind_.enumerated ? slices.heights : slices.bases);
  rows_.add_words("reaction_ranges_place", slices.reactions);
  rows_.add_words("volume_ranges_place", slices.volumes);
  rows_.add_words("spring_ranges_place", slices.springs);
  rows_.add_words("neighbours_place", rows.neighbour);
  rows_.add_words("alpha_place", rows.alpha);
  rows_.add("edge_alpha_place", rows.edge_alpha);
  rows_.add("height_place", rows.height);
  rows_.add("bases_place", rows.base);
  rows_.add("base_e1_place", rows.base_e1);
  rows_.add("base_e2_place", rows.base_e2);
  rows_.add_words("base_share_place", rows.base_share);
  rows_.add_words("share_place", rows.share);
  add_entries(rows);
  rows_.add("volume_place", rows.volume);
  rows_.add("volume_e1_place", rows.volume_e1);
  rows_.add("volume_e2_place", rows.volume_e2);
  rows_.add("volume_e3_place", rows.volume_e3);
  rows_.add("spring_place", rows.spring);
  rows_.add("domain_range_place", rows.domains.range);
  rows_.add("domain_law_place", rows.domains.law);
  rows_.add_words("domain_owner_place", rows.domains.owner);
  rows_.add_words("link_domain_place", rows.domains.neighbour);
  rows_.add("link_place", rows.domains.link);
  rows_.note("particle_count", kind_.particles);
  rows_.note("place_count", places_);
}

ComputeTables::ComputeTables(const SliceTables& slices, const ComputeLimits& limits)
    : kind_(slices.rows),
      places_(slices.place_count()),
      slice_(slices.slice),
      place_of_(slices.place_of),
      materials_(slices.rows.domains.material) {
  add_all(slices);
  constants_ = StorageBuffer(rows_.end(), "the body's constants", limits);
  rows_.send(constants_);
}

std::vector<Int4> ComputeTables::placed(std::vector<Int4> rows, std::size_t particles) const {
  for (Int4& row : rows) {
    for (std::size_t k = 0; k < particles; ++k) row[k] = place_of_[static_cast<std::size_t>(row[k])];
  }
  return rows;
}

void ComputeTables::bind() const {
  constants_.bind(constant_rows_binding);
  constants_.bind(constant_words_binding);
}

void ComputeTables::define(ShaderRequest& request) const {
  define_kernels(kind_, request);
  request.defines.emplace_back("SLICE", slice_);
}

}  // namespace phymul::gl
