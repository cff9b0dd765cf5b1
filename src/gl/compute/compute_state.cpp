// SPDX-License-Identifier: MIT
#include "compute_state.h"

#include <phymul/error.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace phymul::gl {

void ComputeTables::add_all(const SliceTables& slices) {
  rows_.add_words("order_place", slices.order);
  rows_.add_words("neighbour_ranges_place", slices.neighbours);
  rows_.add_words("base_ranges_place", kind_.enumerated ? slices.heights : slices.bases);
  rows_.add_words("reaction_ranges_place", slices.reactions);
  rows_.add_words("volume_ranges_place", slices.volumes);
  rows_.add_words("spring_ranges_place", slices.springs);
  rows_.add_words("wall_ranges_place", slices.walls);
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
  rows_.note("wall_start", entries.wall_start);
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

ComputeState::ComputeState(const ComputeTables& tables, const ComputeLimits& limits) : tables_(&tables) {
  const BodyKind& kind = tables.kind();
  rows_.take({}, pair_row(pairs));
  measured_row_ = rows_.take("measured_place", tables.places());
  rows_.take("force_place", kind.attractors ? tables.places() : 0);
  rows_.take("base_terms_place", kind.base_terms ? std::int64_t{4} * kind.bases : 0);
  rows_.take("volume_terms_place", std::int64_t{4} * kind.volumes);
  rows_.take("wall_terms_place", std::int64_t{4} * kind.walls);
  rows_.take("domain_terms_place", std::int64_t{4} * kind.domains);
  if (kind.dissipates()) {
    strains_row_ = rows_.take({}, pairs * strain_rows());
    dissipation_row_ = rows_.take("dissipation_place", std::int64_t{2} * kind.domains);
  }
  report_row_ = rows_.take({}, 2 * most_report_groups + 2);
  const std::int64_t rows = rows_.end();
  if (rows > std::numeric_limits<int>::max()) {
    throw Error(ErrorCode::not_supported,
                "the forces and terms of the body take more than the 2147483647 rows a shader counts to; use fewer "
                "particles or bases");
  }
  buffer_ = StorageBuffer(rows, "the state and the forces", limits);
  const std::vector<Int4> zeros(1 << 16, Int4{});  // forces of particles without an attractor, and nobody's places
  for (std::int64_t row = 0; row < rows; row += 1 << 16) {
    buffer_.write(16 * row, zeros.data(), 16 * std::min<std::int64_t>(rows - row, 1 << 16));
  }
}

void ComputeState::write(const VecList& rest, const State& state) {
  const auto places = static_cast<std::size_t>(tables_->places());
  std::vector<Float4> rows(2 * places, Float4{});
  pack_state(rest, state, place_of(), rows.data(), rows.data() + places);
  buffer_.write_rows(pair_row(current()), rows);
  set_checkpoint();
  set_strains_fresh(true);
}

void ComputeState::set_dissipation(std::span<const Float4> constants) {
  buffer_.write_rows(dissipation_row_, constants);
}

void ComputeState::write_strains(std::span<const Float4> rows) {
  buffer_.write_rows(strains_row(current()), rows);
  set_strains_fresh(false);
}

std::vector<Float4> ComputeState::read_strains() const {
  if (no_strains()) return {};
  std::vector<Float4> rows(static_cast<std::size_t>(strain_rows()));
  buffer_.read(strains_row(current()), strain_rows(), rows.data());
  return rows;
}

void ComputeState::read(const VecList& rest, State& state) const {
  const auto places = static_cast<std::size_t>(tables_->places());
  std::vector<Float4> rows(2 * places);
  buffer_.read(pair_row(current()), static_cast<std::int64_t>(2 * places), rows.data());
  unpack_state(rows.data(), rows.data() + places, rest, place_of(), state);
}

void ComputeState::request_copy(StateCopies& copies, const State& header) const {
  const auto places = static_cast<std::size_t>(tables_->places());
  copies.request(places, header, [&] {
    buffer_.copy(pair_row(current()), static_cast<std::int64_t>(2 * places), GL_PIXEL_PACK_BUFFER, 0);
  });
}

}  // namespace phymul::gl
