// SPDX-License-Identifier: MIT
//
// Trees over places, one a group: the cube around them is halved along z, y and x in turn. Walked without a stack.
// Built once, from places at rest, in linear time by Morton codes (T. Karras, Maximizing Parallelism in the
// Construction of BVHs, Octrees, and k-d Trees, 2012); boxes are the user's, and may move.
#pragma once

#include <phymul/types.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace phymul {

/// Empty, as Eigen has it, where there are no places.
inline Eigen::AlignedBox3d bounding_box(std::span<const Vec3> places) {
  Eigen::AlignedBox3d box;
  for (const Vec3& x : places) box.extend(x);
  return box;
}

struct BoxTree {
  struct Node {
    Index first = 0, end = 0;  ///< items in it
    Index next = 0;            ///< the node behind its last descendant; a leaf's is the one behind it
    bool is_leaf = false;      ///< at most `leaf_size` items
  };
  struct Shape {
    Index leaf_size = 8;
    int halvings = 1;  ///< of a node into its children, of which there are two to the power of this at most
  };

  BoxTree() = default;
  /// One tree of all.
  BoxTree(const VecList& places, const Shape& shape)
      : BoxTree(places, std::vector<Index>(places.size(), 0), 1, shape) {}
  /// `group`, 0 ... count - 1, of each place.
  BoxTree(const VecList& places, const std::vector<Index>& group, Index count) : BoxTree(places, group, count, {}) {}
  BoxTree(const VecList& places, const std::vector<Index>& group, Index count, const Shape& shape);

  std::vector<Node> nodes;    ///< each tree in preorder: a node's first child stands behind it
  std::vector<Index> items;   ///< rows of `places`
  std::vector<Index> groups;  ///< [groups + 1] first node of each; equal where a group has no items

  /// Calls visit(node, part, is_item) for each item of a leaf and each child of another node, these after their own.
  template <class Visit>
  void each_part_from_below(Visit visit) const {
    for (auto own = static_cast<Index>(nodes.size()); own-- > 0;) {  // children stand behind their parents
      const Node& node = nodes[own];
      for (Index item = node.first; node.is_leaf && item < node.end; ++item) visit(own, item, true);
      for (Index child = own + 1; !node.is_leaf && child < node.next; child = nodes[child].next) {
        visit(own, child, false);
      }
    }
  }

 private:
  struct Coded {
    std::uint32_t code = 0;
    Index row = 0;
  };
  using Codes = std::vector<Coded>;
  static Codes in_order(const VecList& places, const std::vector<Index>& group, std::size_t count);
  void add(const Codes& codes, const Shape& shape, std::size_t first, std::size_t end);
  void halve(const Codes& codes, const Shape& shape, std::size_t first, std::size_t end, int halvings);
};

}  // namespace phymul
