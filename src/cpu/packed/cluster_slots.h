// SPDX-License-Identifier: MIT
//
// Which cluster a term belongs to, and where its particles stand there.
#pragma once

#include <algorithm>
#include <vector>

#include "packed_body.h"

namespace phymul::cpu {

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
