// SPDX-License-Identifier: MIT
//
// Which segments of free threads may touch in a step.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "thread_crossings.h"

namespace phymul {
namespace {

/// Of two diameters, along the thread: segments with less between them are neighbours, which bends bring together.
constexpr double neighbours_in_radii = 4.0;
/// Of the radius: so much farther may a node go in a step than by the speed that it has.
constexpr double room_for_speed_in_radii = 2.0;
/// Of the reach of a step, that segments may go before they are looked for anew.
constexpr double room_in_reach = 3.0;

}  // namespace

bool ThreadCrossings::is_neighbour(const Strand& strand, Index first, Index second) const {
  return second - first < 2 || (second - first - 1) * strand.rod->segment() < neighbours_in_radii * strand.radius;
}

void ThreadCrossings::find_places() {
  std::size_t count = 0;
  from_.clear();
  for (const Strand& strand : strands_) {
    from_.push_back(count);
    count += static_cast<std::size_t>(strand.rod->last());
  }
  for (VecList* const list : {&middle_, &going_}) list->resize(count);
  for (std::vector<double>* const list : {&half_, &room_}) list->resize(count);
  for (std::size_t s = 0; s < strands_.size(); ++s) {
    const Strand& strand = strands_[s];
    const VecList &x = strand.rod->state().position, &v = strand.rod->state().velocity;
    const double room = strand.surprise + (1.0 + room_for_speed_in_radii) * strand.radius;
    for (std::size_t k = 0, own = from_[s]; k + 1 < x.size(); ++k, ++own) {
      middle_[own] = 0.5 * (x[k] + x[k + 1]);
      going_[own] = 0.5 * strand.dt * (v[k] + v[k + 1]);
      half_[own] = 0.5 * (x[k + 1] - x[k]).norm();
      room_[own] = 0.5 * strand.dt * (v[k + 1] - v[k]).lpNorm<1>() + room;
    }
  }
}

bool ThreadCrossings::is_within(std::size_t a, std::size_t b, double reach) const {
  const double most = half_[a] + half_[b] + reach;
  return (middle_[a] - middle_[b]).squaredNorm() <= most * most;
}

bool ThreadCrossings::knows_near(double reach) const {
  if (then_.size() != middle_.size()) return false;
  double moved = 0.0, longer = 0.0;
  for (std::size_t k = 0; k < middle_.size(); ++k) {
    moved = std::max(moved, (middle_[k] - then_[k]).squaredNorm());
    longer = std::max(longer, std::abs(half_[k] - then_half_[k]));
  }
  return 2.0 * (std::sqrt(moved) + longer) + reach <= reach_;
}

/// By boxes of runs of segments, sorted along x.
void ThreadCrossings::find_near(double reach) {
  constexpr Index length = 8;
  struct Run {
    std::size_t strand = 0;
    Index first = 0, end = 0;
    Vec3 low{0, 0, 0}, high{0, 0, 0};
  };
  reach_ = (1.0 + room_in_reach) * reach;
  then_ = middle_;
  then_half_ = half_;
  std::vector<Run> runs;
  for (std::size_t s = 0; s < strands_.size(); ++s) {
    const VecList& x = strands_[s].rod->state().position;
    const Index segments = static_cast<Index>(x.size()) - 1;
    for (Index k = 0; k < segments; k += length) {
      Run run{.strand = s, .first = k, .end = std::min<Index>(k + length, segments), .low = x[k], .high = x[k]};
      for (Index i = k + 1; i <= run.end; ++i) {
        run.low = run.low.cwiseMin(x[i]);
        run.high = run.high.cwiseMax(x[i]);
      }
      runs.push_back(run);
    }
  }
  std::ranges::stable_sort(runs, {}, [](const Run& run) { return run.low.x(); });
  listed_.clear();
  for (std::size_t a = 0; a < runs.size(); ++a) {
    for (std::size_t b = a; b < runs.size() && runs[b].low.x() <= runs[a].high.x() + reach_; ++b) {
      if (((runs[a].low - runs[b].high).array() > reach_).any()) continue;
      if (((runs[b].low - runs[a].high).array() > reach_).any()) continue;
      const auto order = [](const Run& run) { return std::pair(run.strand, run.first); };
      const bool turned = order(runs[b]) < order(runs[a]);
      const Run &one = runs[turned ? b : a], &other = runs[turned ? a : b];
      for (Index p = one.first; p < one.end; ++p) {
        for (Index q = a == b ? p + 1 : other.first; q < other.end; ++q) {
          if (one.strand == other.strand && is_neighbour(strands_[one.strand], p, q)) continue;
          if (!is_within(from_[one.strand] + p, from_[other.strand] + q, reach_)) continue;
          listed_.push_back({.strand = {one.strand, other.strand}, .segment = {p, q}});
        }
      }
    }
  }
}

void ThreadCrossings::find_groups() {
  std::vector<std::size_t> root(strands_.size());
  std::iota(root.begin(), root.end(), 0);
  const auto root_of = [&](std::size_t s) {
    while (root[s] != s) s = root[s];
    return s;
  };
  near_.clear();
  for (const Pair& pair : listed_) {
    const std::size_t p = from_[pair.strand[0]] + pair.segment[0], q = from_[pair.strand[1]] + pair.segment[1];
    if (!is_within(p, q, room_[p] + room_[q] + (going_[p] - going_[q]).lpNorm<1>())) continue;
    near_.push_back(pair);
    const std::size_t a = root_of(pair.strand[0]), b = root_of(pair.strand[1]);
    root[std::max(a, b)] = std::min(a, b);
  }
  groups_.clear();
  std::vector<std::size_t> group(strands_.size());
  for (std::size_t s = 0; s < strands_.size(); ++s) {
    group[s] = root_of(s) == s ? groups_.size() : group[root_of(s)];
    if (group[s] == groups_.size()) groups_.emplace_back();
    groups_[group[s]].push_back(s);
  }
  for (Pair& pair : near_) pair.group = group[pair.strand[0]];
  std::ranges::sort(near_, {}, [](const Pair& pair) { return std::tuple(pair.group, pair.strand, pair.segment); });
}

const std::vector<std::vector<std::size_t>>& ThreadCrossings::find(std::vector<Strand> strands) {
  strands_ = std::move(strands);
  find_places();
  double way = 0.0, room = 0.0;
  for (std::size_t k = 0; k < middle_.size(); ++k) {
    way = std::max(way, going_[k].squaredNorm());
    room = std::max(room, room_[k]);
  }
  const double reach = 2.0 * (std::sqrt(way) + room);
  if (!knows_near(reach)) find_near(reach);
  find_groups();
  return groups_;
}

std::size_t ThreadCrossings::strand_of(const ThreadRod& rod) const {
  return static_cast<std::size_t>(std::ranges::find(strands_, &rod, &Strand::rod) - strands_.begin());
}

void ThreadCrossings::begin(std::size_t strand) {
  const auto has_it = [&](const auto& rows) { return std::ranges::find(rows, strand) != rows.end(); };
  const auto group = static_cast<std::size_t>(std::ranges::find_if(groups_, has_it) - groups_.begin());
  const auto range = std::ranges::equal_range(near_, group, {}, &Pair::group);
  first_ = static_cast<std::size_t>(range.begin() - near_.begin());
  end_ = static_cast<std::size_t>(range.end() - near_.begin());
  crosses_.clear();
}

}  // namespace phymul
