// SPDX-License-Identifier: MIT
#include "sleep_blocks.h"

#include <algorithm>

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

}  // namespace phymul::cpu
