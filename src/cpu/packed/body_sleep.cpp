// SPDX-License-Identifier: MIT
#include "body_sleep.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <string>

#include "base/denormals.h"

namespace phymul::cpu {
namespace {

using Lists = std::vector<std::vector<std::int32_t>>;

/// Sets of blocks, one block after another.
class BlockSet {
 public:
  explicit BlockSet(int count) : seen_by_(static_cast<std::size_t>(count), -1) {}
  void add(std::int32_t of, std::int32_t block, std::vector<std::int32_t>& to) {
    if (seen_by_[block] == of) return;
    seen_by_[block] = of;
    to.push_back(block);
  }

 private:
  std::vector<std::int32_t> seen_by_;
};

/// The blocks that the stress of a block's domains, or their force from given stresses, depends on; itself included.
Lists around(const TopologyTextures& t, const PackedBody& body, int count) {
  std::vector<std::int32_t> block_of(body.order.size());
  for (std::size_t place = 0; place < body.order.size(); ++place) {
    block_of[body.order[place]] = static_cast<std::int32_t>(place) / SleepBlocks::size;
  }
  Lists lists(static_cast<std::size_t>(count));
  BlockSet set(count);
  for (std::size_t place = 0; place < body.order.size(); ++place) {
    const Index i = body.order[place];
    const std::int32_t own = block_of[i];
    const auto add = [&](Index domain) { set.add(own, block_of[t.domains[domain].particle], lists[own]); };
    set.add(own, own, lists[own]);
    for (Index d = t.first_domain[i]; d < t.first_domain[i + 1]; ++d) {
      for (const LinkTexel& link : t.links_of(d)) add(d + link.offset);
      for (const SurfaceLinkTexel& link : t.surface_links_of(d)) add(d + link.offset);
    }
  }
  return lists;
}

/// Share of gravity that a held block may be out of balance by.
constexpr double most_of_gravity = 0.05;

}  // namespace

SleepBlocks make_sleep_blocks(const TopologyTextures& topology, const PackedBody& body) {
  SleepBlocks blocks;
  blocks.count = (body.places + SleepBlocks::size - 1) / SleepBlocks::size;
  const Lists ring = around(topology, body, blocks.count);
  Lists reached(ring.size());
  BlockSet set(blocks.count);
  std::vector<std::int32_t> needed;
  for (std::int32_t b = 0; b < blocks.count; ++b) {
    // A force comes from the stresses around it, each of them from the displacements around that.
    needed.clear();
    for (const std::int32_t c : ring[b]) {
      for (const std::int32_t d : ring[c]) set.add(b, d, needed);
    }
    for (const std::int32_t c : needed) reached[c].push_back(b);
  }
  blocks.first_reached.push_back(0);
  for (const auto& list : reached) {
    blocks.reached.insert(blocks.reached.end(), list.begin(), list.end());
    blocks.first_reached.push_back(static_cast<std::int32_t>(blocks.reached.size()));
  }
  const auto& further = body.averages.further;  // in the order of their particles
  for (std::int32_t b = 0; b <= blocks.count; ++b) {
    const auto first = std::ranges::partition_point(further, [&](const auto& pair) {
      return static_cast<std::int32_t>(SleepBlocks::of_quad(static_cast<std::size_t>(pair.first))) < b;
    });
    blocks.first_further.push_back(static_cast<std::int32_t>(first - further.begin()));
  }
  return blocks;
}

void SliceRanges::clear() {
  ranges_.clear();
  total_ = 0;
}

void SliceRanges::add(int first, int last) {
  if (!ranges_.empty() && first <= ranges_.back().second) {
    total_ += std::max(0, last - ranges_.back().second);
    ranges_.back().second = std::max(ranges_.back().second, last);
  } else if (first < last) {
    total_ += last - first;
    ranges_.emplace_back(first, last);
  }
}

BodySleep::BodySleep(const TopologyTextures& topology, const PackedBody& body, int held_after)
    : body_(body), blocks_(make_sleep_blocks(topology, body)), held_after_(held_after) {
  const auto count = static_cast<std::size_t>(blocks_.count);
  for (auto* marks : {&changed_, &stirred_, &pushed_, &is_chosen_}) marks->assign(count, 0);
  still_.assign(count, 0);
  still_after_ = still_;
  summaries_.resize(count);
  chosen_.reserve(count);
  slots_.reserve(2 * count);  // of particles and of their further domains
}

void BodySleep::wake_all() {
  everything_ = true;
  std::ranges::fill(still_, 0);
}

void BodySleep::begin(const simd::Move& move, const RestThresholds& hold) {
  const std::array<float, 8> now{move.gravity[0],
                                 move.gravity[1],
                                 move.gravity[2],
                                 move.dt,
                                 move.damping,
                                 move.largest_acceleration,
                                 static_cast<float>(hold.speed),
                                 static_cast<float>(hold.acceleration)};
  if (now != before_) everything_ = true;
  before_ = now;
  hold_ = hold;
  // What falls must not hang: for a stiff body the threshold may be above gravity.
  const double gravity = std::hypot(move.gravity[0], move.gravity[1], move.gravity[2]);
  if (gravity > 0.0) hold_.acceleration = std::min(hold_.acceleration, most_of_gravity * gravity);
  choose();
  for (auto* marks : {&changed_, &stirred_, &pushed_}) std::ranges::fill(*marks, std::uint8_t{0});
  everything_ = false;
}

void BodySleep::choose() {
  const auto is_set = [](std::uint8_t mark) { return mark != 0; };
  chosen_.clear();
  slots_.clear();
  if (everything_ || std::ranges::all_of(changed_, is_set)) {
    chosen_.resize(static_cast<std::size_t>(blocks_.count));
    std::iota(chosen_.begin(), chosen_.end(), 0);
    std::ranges::fill(is_chosen_, std::uint8_t{1});
    return;
  }
  is_chosen_ = stirred_;
  for (std::int32_t b = 0; b < blocks_.count; ++b) {
    if (changed_[b] == 0) continue;
    for (const std::int32_t r : blocks_.reach(b)) is_chosen_[r] = 1;
  }
  for (std::int32_t b = 0; b < blocks_.count; ++b) {
    if (is_chosen_[b] != 0) chosen_.push_back(b);
  }
  const int slices = SleepBlocks::size / body_.lanes;
  for (const std::int32_t b : chosen_) slots_.add(b * slices, std::min((b + 1) * slices, body_.slices()));
  for (const std::int32_t b : chosen_) {
    // Further domains have places of their own after all particles, in the order of these.
    const int first = blocks_.first_further[b], last = blocks_.first_further[b + 1];
    if (first < last) {
      slots_.add((body_.places + first) / body_.lanes, (body_.places + last + body_.lanes - 1) / body_.lanes);
    }
  }
}

void BodySleep::copy_displacements(char* u, char* next_u) const {
  for (const std::int32_t b : chosen_) {
    for (int k = blocks_.first_further[b]; k < blocks_.first_further[b + 1]; ++k) {
      const auto& [own, other] = body_.averages.further[k];
      // Both, because they change places: if this step changes nothing, the block may not be chosen again.
      std::memcpy(u + 16 * std::ptrdiff_t{other}, u + 16 * std::ptrdiff_t{own}, 16);
      std::memcpy(next_u + 16 * std::ptrdiff_t{other}, u + 16 * std::ptrdiff_t{own}, 16);
    }
  }
}

void BodySleep::gather_forces(char* force) const {
  for (const std::int32_t b : chosen_) {
    body_.averages.gather_forces(force, blocks_.first_further[b], blocks_.first_further[b + 1]);
  }
}

void BodySleep::move(const simd::Move& move, const simd::Kernels& kernels, ThreadPool& pool) {
  run(pool, [&, this](int part, int parts) {
    const DenormalsAreZero guard;
    const auto bound = [&](int k) { return chosen_.size() * static_cast<std::size_t>(k) / parts; };
    for (std::size_t k = bound(part); k < bound(part + 1); ++k) move_block(move, kernels, chosen_[k]);
  });
  summary_ = summary_of(summaries_);
}

void BodySleep::move_block(const simd::Move& move, const simd::Kernels& kernels, int block) {
  const int slices = SleepBlocks::size / body_.lanes;
  const int first = block * slices, last = std::min(first + slices, body_.slices());
  simd::MoveSummary& summary = summaries_[block].summary;
  kernels.move(move, first, last, summary);
  still_after_[block] = 0;
  if (hold_.speed > 0.0 && pushed_[block] == 0) hold_if_still(move, block, first, last);
  const std::size_t from = static_cast<std::size_t>(first) * body_.lanes;
  const std::size_t count = static_cast<std::size_t>(last - first) * body_.lanes;
  const bool repeats = std::memcmp(move.u + 16 * from, move.next_u + 16 * from, 16 * count) == 0 &&
                       std::memcmp(move.v + 3 * from, move.next_v + 3 * from, 12 * count) == 0;
  changed_[block] = repeats ? 0 : 1;
  // To compute a block once more that repeats itself must make no difference.
  if (repeats && still_after_[block] > 0) still_after_[block] = still_[block];
}

void BodySleep::hold_if_still(const simd::Move& move, int block, int first, int last) {
  simd::MoveSummary& summary = summaries_[block].summary;
  const RestThresholds hold = rest_thresholds(hold_, std::sqrt(static_cast<double>(summary.displacement)));
  const bool was_held = still_[block] >= held_after_;
  const bool slow = was_held || std::sqrt(static_cast<double>(summary.speed)) <= hold.speed;
  if (!slow || summary.runaway || !(std::sqrt(static_cast<double>(summary.acceleration)) <= hold.acceleration)) return;
  still_after_[block] = std::min(still_[block] + 1, held_after_);
  if (still_after_[block] < held_after_) return;
  if (is_carried(move, first * body_.lanes, last * body_.lanes)) {
    // Not held, so its speed counts again once it stops.
    still_after_[block] = held_after_ - 1;
    return;
  }
  const std::size_t from = static_cast<std::size_t>(first) * body_.lanes;
  const std::size_t count = static_cast<std::size_t>(last - first) * body_.lanes;
  std::memcpy(move.next_u + 16 * from, move.u + 16 * from, 16 * count);
  std::fill_n(move.next_v + 3 * from, 3 * count, 0.0f);
  summary.speed = 0.0f;
}

bool BodySleep::is_carried(const simd::Move& move, int first_place, int last_place) const {
  if (move.fixed == nullptr) return false;
  const float *u = reinterpret_cast<const float*>(move.u), *next_u = reinterpret_cast<const float*>(move.next_u);
  for (int place = first_place; place < last_place; ++place) {
    const std::size_t at = 4 * body_.quad_of(static_cast<std::size_t>(place));
    for (int a = 0; a < 3; ++a) {
      if ((move.fixed[place] >> a & 1) != 0 && u[at + a] != next_u[at + a]) return true;
    }
  }
  return false;
}

void BodySleep::push(std::span<const std::size_t> quads) {
  for (const std::size_t quad : quads) {
    const auto block = static_cast<std::int32_t>(SleepBlocks::of_quad(quad));
    pushed_[block] = 1;
    if (is_chosen_[block] != 0) continue;
    is_chosen_[block] = 1;
    chosen_.push_back(block);
  }
}

void BodySleep::shift(std::size_t quad) {
  const std::size_t block = SleepBlocks::of_quad(quad);
  changed_[block] = 1;
  still_[block] = still_after_[block] = 0;
}

void BodySleep::accept() {
  for (const std::int32_t b : chosen_) still_[b] = still_after_[b];
  for (std::size_t b = 0; b < pushed_.size(); ++b) stirred_[b] |= pushed_[b];
}

std::vector<std::uint8_t> BodySleep::memory() const {
  if (std::ranges::all_of(still_, [](std::int32_t steps) { return steps == 0; })) return {};
  std::vector<std::uint8_t> bytes(4 * still_.size());
  for (std::size_t b = 0; b < still_.size(); ++b) {
    for (std::size_t k = 0; k < 4; ++k) bytes[4 * b + k] = static_cast<std::uint8_t>(still_[b] >> (8 * k));
  }
  return bytes;
}

void BodySleep::require_fitting(std::span<const std::uint8_t> memory) const {
  if (memory.size() != 4 * still_.size()) {
    throw Error("Solver::restore: expected the snapshot's part \"sleep\" to have " + std::to_string(4 * still_.size()) +
                " bytes for this body, got " + std::to_string(memory.size()) + "; the solver keeps its state");
  }
}

void BodySleep::remember(std::span<const std::uint8_t> memory) {
  for (std::size_t b = 0; b < still_.size(); ++b) {
    std::uint32_t steps = 0;
    for (std::size_t k = 0; k < 4; ++k) steps |= std::uint32_t{memory[4 * b + k]} << (8 * k);
    still_[b] = static_cast<std::int32_t>(std::min<std::uint32_t>(steps, static_cast<std::uint32_t>(held_after_)));
  }
  everything_ = true;
}

}  // namespace phymul::cpu
