// SPDX-License-Identifier: MIT
#include "compute_tables.h"

namespace phymul::gl {

void ComputeTables::add_all(const SliceTables& slices) {
  rows_.add_words("order_place", slices.order);
  rows_.add_words("neighbour_ranges_place", slices.neighbours);
  rows_.add_words("base_ranges_place", kind_.enumerated ? slices.heights : slices.bases);
  rows_.add_words("reaction_ranges_place", slices.reactions);
  rows_.add_words("volume_ranges_place", slices.volumes);
  rows_.add_words("spring_ranges_place", slices.springs);
  slices.rows.for_each([this](const char* name, const auto& table) {
    const std::string place = std::string(name) + "_place";
    if constexpr (sizeof table[0] == sizeof(Float4)) {
      rows_.add(place, table);
    } else {
      rows_.add_words(place, table);
    }
  });
  FloatEntries entries(slices.rows);
  rows_.add_words("entries_place", std::move(entries.rows));
  rows_.note("volume_start", entries.volume_start);
  rows_.note("spring_start", entries.spring_start);
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
