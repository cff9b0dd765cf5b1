// SPDX-License-Identifier: MIT
//
// Which segments of free threads may touch in a step.
#include <algorithm>
#include <numeric>
#include <tuple>

#include "thread_crossings.h"

namespace phymul {
namespace {

/// Of two diameters, along the thread: segments with less between them are neighbours, which bends bring together.
constexpr double neighbours_in_radii = 4.0;
/// Of the radius: so much farther may a node go in a step than by the speed that it has.
constexpr double room_for_speed_in_radii = 2.0;
constexpr Index run_length = 8;  // segments that share a box, and nodes that a given one draws with it

}  // namespace

bool ThreadCrossings::is_neighbour(const Strand& strand, Index first, Index second) const {
  return second - first < 2 || (second - first - 1) * strand.rod->segment() < neighbours_in_radii * strand.radius;
}

void ThreadCrossings::start(double dt) {
  dt_ = dt;
  strands_.clear();
  from_.clear();
  going_.clear();
  surprise_.clear();
}

void ThreadCrossings::add(const Strand& strand, double surprise) {
  from_.push_back(going_.size() - strands_.size());
  strands_.push_back(strand);
  for (const Vec3& velocity : strand.rod->state().velocity) going_.push_back(dt_ * velocity);
  surprise_.resize(going_.size(), surprise);
}

void ThreadCrossings::give(Index node, const Vec3& way) {
  const std::size_t own = first_node(strands_.size() - 1) + node;
  const double surprise = (way - going_[own]).norm();
  const Index last = strands_.back().rod->last();
  for (Index k = std::max<Index>(0, node - run_length); k <= std::min(last, node + run_length); ++k) {
    double& near = surprise_[own - node + k];
    near = std::max(near, surprise);
  }
}

void ThreadCrossings::find_boxes() {
  boxes_.clear();
  runs_.clear();
  for (std::size_t s = 0; s < strands_.size(); ++s) {
    const Strand& strand = strands_[s];
    const VecList& x = strand.rod->state().position;
    Box last;
    for (std::size_t k = 0, own = first_node(s); k < x.size(); ++k, ++own) {
      const Vec3 room = Vec3::Constant(surprise_[own] + (1.0 + room_for_speed_in_radii) * strand.radius);
      const Vec3 end = x[k] + going_[own];
      const Box box(x[k].cwiseMin(end) - room, x[k].cwiseMax(end) + room);
      if (k > 0) {
        last.extend(box);
        boxes_.push_back(last);
        const Index segment = static_cast<Index>(k) - 1;
        if (segment % run_length == 0) runs_.push_back({.strand = s, .first = segment, .end = segment, .box = last});
        runs_.back().box.extend(last);
        ++runs_.back().end;
      }
      last = box;
    }
  }
}

/// `one` is not behind the other in strands and segments.
void ThreadCrossings::find_pairs(const Run& one, const Run& other) {
  const bool is_self = one.strand == other.strand;
  for (Index p = one.first; p < one.end; ++p) {
    const Box& box = boxes_[from_[one.strand] + p];
    if (!box.intersects(other.box)) continue;
    for (Index q = is_self ? std::max(other.first, p + 2) : other.first; q < other.end; ++q) {
      if (!box.intersects(boxes_[from_[other.strand] + q])) continue;
      if (is_self && is_neighbour(strands_[one.strand], p, q)) continue;
      near_.push_back({.strand = {one.strand, other.strand}, .segment = {p, q}});
    }
  }
}

std::size_t ThreadCrossings::root_of(std::size_t strand) const {
  while (group_[strand] != strand) strand = group_[strand];
  return strand;
}

/// By boxes of runs of segments, sorted along x.
void ThreadCrossings::find() {
  find_boxes();
  near_.clear();
  std::ranges::sort(runs_, {}, [](const Run& run) { return std::tuple(run.box.min().x(), run.strand, run.first); });
  for (std::size_t a = 0; a < runs_.size(); ++a) {
    for (std::size_t b = a; b < runs_.size() && runs_[b].box.min().x() <= runs_[a].box.max().x(); ++b) {
      if (!runs_[a].box.intersects(runs_[b].box)) continue;
      const auto order = [](const Run& run) { return std::pair(run.strand, run.first); };
      const bool turned = order(runs_[b]) < order(runs_[a]);
      find_pairs(runs_[turned ? b : a], runs_[turned ? a : b]);
    }
  }
  group_.resize(strands_.size());
  std::iota(group_.begin(), group_.end(), 0);
  pressed_.assign(going_.size(), 0);
  for (const Pair& pair : near_) {
    const std::size_t a = root_of(pair.strand[0]), b = root_of(pair.strand[1]);
    group_[std::max(a, b)] = std::min(a, b);
  }
  for (std::size_t s = 0; s < strands_.size(); ++s) group_[s] = root_of(s);
  std::ranges::sort(near_, {},
                    [this](const Pair& pair) { return std::tuple(group_[pair.strand[0]], pair.strand, pair.segment); });
}

}  // namespace phymul
