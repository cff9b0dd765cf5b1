// SPDX-License-Identifier: MIT
//
// Filling the rows of simd/job.h: column after column, `lanes` of each. Which cluster a term belongs to, and where its
// particles stand there.
#pragma once

#include <phymul/types.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "device/float_range.h"
#include "packed_body.h"

namespace phymul::cpu {

/// Offsets of lanes that nothing has claimed.
inline constexpr std::int32_t unclaimed = -1;

/// Rows at the end of an array.
class LaneRows {
 public:
  LaneRows(Floats& to, int columns, int lanes) : to_(to), columns_(columns), lanes_(lanes), first_(to.size()) {}

  /// Appends rows of zeros whose offsets are unclaimed; put() and offset() then mean these.
  void add(Index rows, int offset_columns);
  void put(Index row, int column, int lane, double value) { at(row, column, lane) = narrow(value); }
  void put(Index row, int column, int lane, const Vec3& v);  ///< this column and the two after it
  void offset(Index row, int column, int lane, std::int32_t value);

 private:
  float& at(Index row, int column, int lane) {
    return to_[first_ + (static_cast<std::size_t>(row) * columns_ + column) * lanes_ + lane];
  }

  Floats& to_;
  int columns_, lanes_;
  std::size_t first_;
};

/// Points what is unclaimed among the rows from `first` on, up to `last`, to `idle`.
void fill_idle(Floats& rows, std::size_t first, int columns, int offset_columns, int lanes, std::int32_t idle,
               std::size_t last = static_cast<std::size_t>(-1));

/// Terms that are neighbours share particles, and adding to one place in lane after lane would wait for each other: so
/// a lane takes a run of terms, and a row takes its terms far from each other.
class SpreadLanes {
 public:
  SpreadLanes(std::size_t terms, int lanes) : rows_(static_cast<int>((terms + lanes - 1) / lanes)) {}
  int rows() const { return rows_; }
  std::pair<Index, int> place(std::size_t term) const {
    return {static_cast<Index>(term % rows_), static_cast<int>(term / rows_)};
  }

 private:
  int rows_;
};

/// Slots of one cluster: its own particles, then others in the order they are met.
class Slots {
 public:
  Slots(Index particles, int lanes)
      : slot_(static_cast<std::size_t>(particles)), seen_(slot_.size(), -1), lanes_(lanes) {}

  void begin(int cluster, Cluster& to, Index own_particles) {
    cluster_ = cluster;
    to_ = &to;
    own_particles_ = own_particles;
  }
  Index own_particles() const { return own_particles_; }
  /// `pushes`: the term has forces for the particle.
  std::int32_t offset_of(Index particle, bool pushes = true) {
    const Index k = particle - to_->first;
    if (k >= 0 && k < own_particles_) return 16 * simd::quad_of(k, lanes_);
    if (seen_[particle] != cluster_) {
      seen_[particle] = cluster_;
      slot_[particle] = to_->own + static_cast<std::int32_t>(to_->halo.size());
      to_->halo.push_back(simd::quad_of(particle, lanes_));
      to_->pushed.push_back(false);
    }
    if (pushes) to_->pushed[slot_[particle] - to_->own] = true;
    return 16 * slot_[particle];
  }

 private:
  std::vector<std::int32_t> slot_, seen_;
  Cluster* to_ = nullptr;
  int lanes_, cluster_ = -1;
  Index own_particles_ = 0;
};

/// Rows of `terms` that belong to each cluster: to the one that has most of its vertices, the
/// first of those.
template <class Term, class Vertices>
std::vector<std::vector<Index>> by_cluster(const std::vector<Term>& terms, Index size, std::size_t clusters,
                                           const Vertices& vertices) {
  std::vector<std::vector<Index>> rows(clusters);
  for (std::size_t t = 0; t < terms.size(); ++t) {
    Index best = 0;
    std::ptrdiff_t most = 0;
    auto of = vertices(terms[t]);  // clusters of its vertices
    for (Index& i : of) {
      if (i != none) i /= size;
    }
    for (const Index c : of) {
      if (c == none) continue;
      const auto here = std::ranges::count(of, c);
      if (here > most || (here == most && c < best)) {
        most = here;
        best = c;
      }
    }
    rows[best].push_back(static_cast<Index>(t));
  }
  return rows;
}

}  // namespace phymul::cpu
