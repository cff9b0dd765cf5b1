// SPDX-License-Identifier: MIT
#include "cluster_claims.h"

#include <cstddef>

namespace phymul::cpu {
namespace {

/// The last cluster of a run is left to its part: another would read constants from further away than it saves, for a
/// part that is late by less than one cluster.
constexpr int least_to_take_from = 2;

std::uint64_t run_of(std::uint64_t first, std::uint64_t end) {
  return first | end << 32;
}
int first_of(std::uint64_t run) {
  return static_cast<int>(run & 0xffffffffu);
}
int end_of(std::uint64_t run) {
  return static_cast<int>(run >> 32);
}
int size_of(std::uint64_t run) {
  return end_of(run) - first_of(run);
}

/// Clusters [result[part], result[part + 1]) of about equal cost for each part.
std::vector<int> shared_out(const PackedBody& body, int parts) {
  std::vector<int> first{0};
  double done = 0.0;
  double all = 0.0;
  for (const Cluster& cluster : body.clusters) all += cluster.cost;
  for (std::size_t c = 0; c < body.clusters.size(); ++c) {
    const double middle = done + 0.5 * body.clusters[c].cost;
    while (static_cast<int>(first.size()) < parts && middle >= all * static_cast<double>(first.size()) / parts) {
      first.push_back(static_cast<int>(c));
    }
    done += body.clusters[c].cost;
  }
  first.resize(static_cast<std::size_t>(parts) + 1, static_cast<int>(body.clusters.size()));
  return first;
}

}  // namespace

ClusterClaims::ClusterClaims(const PackedBody& body, int parts) : runs_(static_cast<std::size_t>(parts)) {
  const std::vector<int> first = shared_out(body, parts);
  for (std::size_t part = 0; part < runs_.size(); ++part) {
    runs_[part].all = run_of(static_cast<std::uint64_t>(first[part]), static_cast<std::uint64_t>(first[part + 1]));
  }
}

void ClusterClaims::begin() {
  for (Run& run : runs_) run.left.store(run.all, std::memory_order_relaxed);
}

int ClusterClaims::take(int part) {
  std::atomic<std::uint64_t>& left = runs_[static_cast<std::size_t>(part)].left;
  std::uint64_t run = left.load(std::memory_order_relaxed);
  if (runs_.size() == 1) {  // nobody to agree with, which small bodies need not pay for
    left.store(run + 1, std::memory_order_relaxed);
    return size_of(run) > 0 ? first_of(run) : -1;
  }
  while (size_of(run) > 0) {
    if (left.compare_exchange_weak(run, run + 1, std::memory_order_relaxed)) return first_of(run);
  }
  return take_from_another();
}

/// From the part that has most left, which is the latest.
int ClusterClaims::take_from_another() {
  for (;;) {
    Run* latest = nullptr;
    std::uint64_t of_latest = 0;
    int most = least_to_take_from - 1;
    for (Run& run : runs_) {
      const std::uint64_t left = run.left.load(std::memory_order_relaxed);
      if (size_of(left) <= most) continue;
      most = size_of(left);
      latest = &run;
      of_latest = left;
    }
    if (!latest) return -1;
    const int last = end_of(of_latest) - 1;
    const std::uint64_t rest =
        run_of(static_cast<std::uint64_t>(first_of(of_latest)), static_cast<std::uint64_t>(last));
    if (latest->left.compare_exchange_strong(of_latest, rest, std::memory_order_relaxed)) return last;
  }
}

}  // namespace phymul::cpu
