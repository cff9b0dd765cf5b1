// SPDX-License-Identifier: MIT
#include "box_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

namespace phymul {
namespace {

constexpr std::size_t steps = 1024;  // of each axis, by ten bits of a code

/// The number with two zeros before each of its bits.
std::uint32_t spread(std::uint32_t bits) {
  bits = (bits | bits << 16) & 0x030000ff;
  bits = (bits | bits << 8) & 0x0300f00f;
  bits = (bits | bits << 4) & 0x030c30c3;
  return (bits | bits << 2) & 0x09249249;
}

}  // namespace

BoxTree::BoxTree(const VecList& places, const std::vector<Index>& group, Index count, const Shape& shape) {
  std::vector<Codes> own(static_cast<std::size_t>(count));
  for (const Coded& coded : in_order(places, group, own.size())) own[group[coded.row]].push_back(coded);
  Codes codes;
  codes.reserve(places.size());
  groups.push_back(0);
  for (const Codes& of : own) {
    const std::size_t first = codes.size();
    codes.insert(codes.end(), of.begin(), of.end());
    if (!of.empty()) add(codes, shape, first, codes.size());
    groups.push_back(static_cast<Index>(nodes.size()));
  }
  items.reserve(codes.size());
  for (const Coded& coded : codes) items.push_back(coded.row);
}

/// Of all groups, each by a cube of its own: sorted digit by digit, equal ones by their rows.
BoxTree::Codes BoxTree::in_order(const VecList& places, const std::vector<Index>& group, std::size_t count) {
  VecList low(count, Vec3::Constant(HUGE_VAL)), high(count, Vec3::Constant(-HUGE_VAL));
  for (std::size_t k = 0; k < places.size(); ++k) {
    low[group[k]] = low[group[k]].cwiseMin(places[k]);
    high[group[k]] = high[group[k]].cwiseMax(places[k]);
  }
  Codes codes;
  codes.reserve(places.size());
  for (std::size_t k = 0; k < places.size(); ++k) {
    const Vec3 at = places[k] - low[group[k]];
    const double side = (high[group[k]] - low[group[k]]).maxCoeff(), last = steps - 1;
    const auto step = [&](double from_low) {  // 0 also where it is no number
      const double in_steps = from_low / side * last;
      return in_steps > 0.0 ? static_cast<std::uint32_t>(std::min(in_steps, last)) : 0u;
    };
    const std::uint32_t code = spread(step(at[0])) | spread(step(at[1])) << 1 | spread(step(at[2])) << 2;
    codes.push_back({code, static_cast<Index>(k)});
  }
  Codes sorted(codes.size());
  for (const int shift : {0, 10, 20}) {
    const auto digit = [shift](const Coded& coded) { return coded.code >> shift & (steps - 1); };
    std::array<std::size_t, steps + 1> first{};
    for (const Coded& coded : codes) ++first[digit(coded) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    for (const Coded& coded : codes) sorted[first[digit(coded)]++] = coded;
    codes.swap(sorted);
  }
  return codes;
}

void BoxTree::add(const Codes& codes, const Shape& shape, std::size_t first, std::size_t end) {
  const std::size_t own = nodes.size();
  const bool is_leaf = end - first <= static_cast<std::size_t>(shape.leaf_size);
  nodes.push_back({static_cast<Index>(first), static_cast<Index>(end), 0, is_leaf});
  if (!is_leaf) halve(codes, shape, first, end, shape.halvings);
  nodes[own].next = static_cast<Index>(nodes.size());
}

/// Adds nodes for the parts, which are more than a leaf until they have been halved often enough.
void BoxTree::halve(const Codes& codes, const Shape& shape, std::size_t first, std::size_t end, int halvings) {
  if (halvings == 0 || end - first <= static_cast<std::size_t>(shape.leaf_size)) return add(codes, shape, first, end);
  const std::uint32_t differ = codes[first].code ^ codes[end - 1].code, bit = std::bit_floor(differ);
  const auto begin = codes.begin();
  const auto at = [begin](std::size_t k) { return begin + static_cast<std::ptrdiff_t>(k); };
  const auto is_low = [bit](const Coded& coded) { return (coded.code & bit) == 0; };
  const std::size_t middle = differ == 0
                                 ? std::midpoint(first, end)
                                 : static_cast<std::size_t>(std::partition_point(at(first), at(end), is_low) - begin);
  halve(codes, shape, first, middle, halvings - 1);
  halve(codes, shape, middle, end, halvings - 1);
}

}  // namespace phymul
