// SPDX-License-Identifier: MIT
//
// The lattice of isosurface stuffing with a spacing that varies: middles and corners of the leaves of a balanced octree
// (F. Labelle, J. R. Shewchuk, ACM Trans. Graph. 26 (3), 2007, section 3).
#pragma once

#include <phymul/body.h>

#include <array>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "lattice.h"
#include "stuffing.h"

namespace phymul {

/// The roots of the octree are the cubes of a centred lattice. Leaves that touch, be it at a corner, differ by one
/// halving at most. Two leaves of one size with a common face have a tetrahedron for each of its edges, or for each
/// half of an edge whose midpoint is a corner of a smaller leaf. A face between leaves of different size is cut into
/// the quarters that the smaller ones see, each by the diagonal through the middle of the larger leaf's face, and each
/// triangle makes a tetrahedron with the middle of its leaf. Both sides see the same triangles, so no vertex hangs.
class GradedLattice {
 public:
  static constexpr int most_halvings = 3;

  /// Leaves are halved until their spacing is at most what options.spacing_at asks at 27 places of each. Throws Error
  /// for what it asks out of range, and for too many leaves.
  GradedLattice(const CentredLattice& roots, const BodyOptions& options);

  bool is_uniform() const { return refined_[0].empty(); }
  const CentredLattice& roots() const { return roots_; }
  /// Numbers the points; nothing below is valid before.
  void number_points();

  std::size_t points() const { return at_.size(); }
  Vec3 place(Index point) const {
    const auto& [x, y, z] = at_[point];
    return roots_.origin + roots_.edge / units * Vec3(x, y, z);
  }
  /// Of the smallest leaf that the point is a corner or the middle of, in edges of the roots.
  double leaf_edge(Index point) const { return leaf_edge_[point]; }
  double length(Index a, Index b) const;  ///< in edges of the roots
  /// Of the shortest edge of a tetrahedron at the point, in edges of the roots.
  double shortest_edge(Index point) const { return shortest_edge_[point]; }
  /// All tetrahedra, of positive volume.
  const std::vector<Tetrahedron>& cells() const { return cells_; }

 private:
  using Triple = std::array<int, 3>;
  using Key = std::int64_t;
  struct Leaf {
    Triple at;  // in leaves of its level
    int level;
  };

  static constexpr int units = 2 << most_halvings;  // of an edge of the roots: half the smallest leaf

  Key node_key(const Triple& at, int level) const;
  Key point_key(const Triple& at) const;
  bool exists(const Triple& at, int level) const;
  bool is_refined(const Triple& at, int level) const;
  bool is_in(const Triple& at, int level) const;
  double asked_in(const Leaf& leaf, const BodyOptions& options) const;
  void refine(const BodyOptions& options);
  void balance();
  template <class Divides, class Function>
  void each_leaf(const Divides& divides, const Function& f) const;
  Index point_at(const Triple& at) const;
  void add_cell(Tetrahedron cell);
  void add_cells(const Leaf& leaf, int axis, int side);

  CentredLattice roots_;
  std::array<std::unordered_set<Key>, most_halvings> refined_;  // nodes of each level that have children
  std::unordered_map<Key, Index> point_;
  std::vector<Triple> at_;  // [points] in units
  std::vector<double> leaf_edge_, shortest_edge_;
  std::vector<Tetrahedron> cells_;
};

}  // namespace phymul
