// SPDX-License-Identifier: MIT
#include "compute_state.h"

#include <phymul/error.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace phymul::gl {

ComputeState::ComputeState(const ComputeTables& tables, const ComputeLimits& limits) : tables_(&tables) {
  const BodyKind& kind = tables.kind();
  std::int64_t rows = pair_row(pairs);
  const auto take = [&rows](std::int64_t count) {
    const std::int64_t first = rows;
    rows += count;
    if (rows > std::numeric_limits<int>::max()) {
      throw Error(ErrorCode::not_supported,
                  "the forces and terms of the body take more than the 2147483647 rows a shader counts to; use fewer " +
                      std::string("particles or bases"));
    }
    return static_cast<int>(first);
  };
  measured_row_ = take(tables.places());
  force_row_ = take(kind.attractors ? tables.places() : 0);
  base_row_ = take(kind.base_terms ? std::int64_t{4} * kind.bases : 0);
  volume_row_ = take(std::int64_t{4} * kind.volumes);
  domain_row_ = take(std::int64_t{4} * kind.domains);
  report_row_ = take(2 * most_report_groups + 2);
  rows_ = StorageBuffer(rows, "the state and the forces", limits);
  const std::vector<Int4> zeros(1 << 16, Int4{});  // forces of particles without an attractor, and nobody's places
  for (std::int64_t row = 0; row < rows; row += 1 << 16) {
    rows_.write(16 * row, zeros.data(), 16 * std::min<std::int64_t>(rows - row, 1 << 16));
  }
}

int ComputeState::free_pair() const {
  int pair = 0;
  while (pair == current_ || pair == checkpoint_) ++pair;
  return pair;
}

void ComputeState::place(Kernel& kernel) const {
  kernel.set("measured_place", measured_row_);
  kernel.set("force_place", force_row_);
  kernel.set("base_terms_place", base_row_);
  kernel.set("volume_terms_place", volume_row_);
  kernel.set("domain_terms_place", domain_row_);
}

void ComputeState::write(const VecList& rest, const State& state) {
  const auto places = static_cast<std::size_t>(tables_->places());
  std::vector<Float4> rows(2 * places, Float4{});
  pack_state(rest, state, place_of(), rows.data(), rows.data() + places);
  rows_.write(16 * pair_row(current_), rows.data(), static_cast<std::int64_t>(16 * rows.size()));
  set_checkpoint();
}

void ComputeState::read(const VecList& rest, State& state) const {
  const auto places = static_cast<std::size_t>(tables_->places());
  std::vector<Float4> rows(2 * places);
  rows_.read(pair_row(current_), static_cast<std::int64_t>(2 * places), rows.data());
  unpack_state(rows.data(), rows.data() + places, rest, place_of(), state);
}

void ComputeState::request_copy(StateCopies& copies, const State& header) const {
  const auto places = static_cast<std::size_t>(tables_->places());
  copies.request(places, header, [&] {
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glBindBuffer(GL_COPY_READ_BUFFER, rows_.id());
    glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_PIXEL_PACK_BUFFER, static_cast<GLintptr>(16 * pair_row(current_)), 0,
                        static_cast<GLsizeiptr>(32 * places));
    glBindBuffer(GL_COPY_READ_BUFFER, 0);
  });
}

}  // namespace phymul::gl
