// SPDX-License-Identifier: MIT
#include "stuffing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <concepts>

#include "graded_lattice.h"

namespace phymul {
namespace {

// A point this near to the surface, as a share of the edge along which it is near, moves onto it. The paper's 0.359
// along short edges bounds the dihedral angles, but leaves particles of a hundredth of the mean mass, which set the
// stable step; cells that the larger one spoils are improved afterwards. A larger one along long edges would cut off
// the edges of boxes.
constexpr double near_along_short = 0.46, near_along_long = 0.21509;
/// The same in a graded lattice for edges longer than the shortest at the point, whose length it is a share of.
constexpr double near_by_shortest = near_along_long / CentredLattice::short_length;

enum Side : signed char { outside = -1, on_surface = 0, inside = 1 };

/// An edge of a lattice; lengths in edges of its cubes.
struct LatticeEdge {
  Index from, to;
  double length;
  double near_from, near_to;  // shares of it: a point as near to the surface as this moves onto it
};

std::vector<char> points_inside(const Interior& interior, const CentredLattice& lattice) {
  return interior.inside(lattice);
}

std::vector<char> points_inside(const Interior& interior, const GradedLattice& lattice) {
  VecList places(lattice.points());
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = lattice.place(static_cast<Index>(i));
  return interior.inside(places);
}

/// Calls f(edge) for each edge from a point inside to one outside.
template <class Function>
void each_crossing_edge(const CentredLattice& lattice, const std::vector<signed char>& side, const Function& f) {
  const std::array<std::array<Index, 14>, 2> steps{lattice.steps(false), lattice.steps(true)};
  for (Index point = 0; point < static_cast<Index>(side.size()); ++point) {
    if (side[point] != inside) continue;
    const auto& own = steps[CentredLattice::is_middle(point) ? 1 : 0];
    for (std::size_t k = 0; k < own.size(); ++k) {
      if (side[point + own[k]] == inside) continue;
      const double length = k < 8 ? CentredLattice::short_length : 1.0;
      const double near = k < 8 ? near_along_short : near_along_long;
      f(LatticeEdge{point, point + own[k], length, near, near});
    }
  }
}

template <class Function>
void each_crossing_edge(const GradedLattice& lattice, const std::vector<signed char>& side, const Function& f) {
  std::vector<std::array<Index, 2>> edges;
  for (const Tetrahedron& cell : lattice.cells()) {
    for (const Index in : cell) {
      for (const Index out : cell) {
        if (side[in] == inside && side[out] != inside) edges.push_back({in, out});
      }
    }
  }
  std::ranges::sort(edges);
  edges.erase(std::ranges::unique(edges).begin(), edges.end());
  for (const auto& [in, out] : edges) {
    const double length = lattice.length(in, out);
    const auto near = [&](Index end) {
      const double shortest = lattice.shortest_edge(end);
      return length < 1.01 * shortest ? near_along_short : near_by_shortest * shortest / length;
    };
    f(LatticeEdge{in, out, length, near(in), near(out)});
  }
}

/// Calls f for each tetrahedron. Around each edge between neighbouring middles lie four, one at each edge of the square
/// between them.
template <class Function>
void each_cell(const CentredLattice& lattice, const Function& f) {
  const auto& n = lattice.count;
  for (int k = 0; k + 1 < n[2]; ++k) {
    for (int j = 0; j + 1 < n[1]; ++j) {
      for (int i = 0; i + 1 < n[0]; ++i) {
        const auto corner = [&](int x, int y, int z) { return lattice.corner(i + x, j + y, k + z); };
        const auto around = [&](Index other, const std::array<Index, 4>& square) {
          for (int e = 0; e < 4; ++e) f({lattice.middle(i, j, k), other, square[e], square[(e + 1) % 4]});
        };
        around(lattice.middle(i + 1, j, k), {corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1)});
        around(lattice.middle(i, j + 1, k), {corner(0, 1, 0), corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0)});
        around(lattice.middle(i, j, k + 1), {corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)});
      }
    }
  }
}

template <class Function>
void each_cell(const GradedLattice& lattice, const Function& f) {
  for (const Tetrahedron& cell : lattice.cells()) f(cell);
}

/// Where an edge of the lattice leaves the shape.
struct Crossing {
  LatticeEdge edge;      // from inside to outside
  double share;          // of the way
  bool is_there = true;  // until one of its ends moves onto the surface
  Index particle = -1;

  /// Of its edge, from one of its ends.
  double share_from(Index end) const { return end == edge.from ? share : 1.0 - share; }
  bool is_near(Index end) const { return share_from(end) < (end == edge.from ? edge.near_from : edge.near_to); }
  double length_from(Index end) const { return share_from(end) * edge.length; }
};

template <class Lattice>
class Filling {
 public:
  Filling(const Interior& interior, const Lattice& lattice) : lattice_(lattice) {
    find_sides(interior);
    find_crossings(interior);
    move_points();
    each_cell(lattice_, [this](const Tetrahedron& cell) { cut_cell(cell); });
  }

  Stuffing take() { return std::move(result_); }

 private:
  static constexpr bool is_graded = std::same_as<Lattice, GradedLattice>;

  void find_sides(const Interior& interior) {
    const std::vector<char> in = points_inside(interior, lattice_);
    side_.resize(in.size());
    std::ranges::transform(in, side_.begin(), [](char yes) { return yes ? inside : outside; });
    particle_.assign(in.size(), -1);
    moved_.assign(in.size(), -1);
  }

  void find_crossings(const Interior& interior) {
    each_crossing_edge(lattice_, side_, [&](const LatticeEdge& edge) {
      crossings_.push_back({edge, interior.exit(lattice_.place(edge.from), lattice_.place(edge.to))});
    });
    // Crossings of each point, so that those of an edge are found from either end.
    of_point_.assign(side_.size() + 1, 0);
    for (const Crossing& c : crossings_) {
      ++of_point_[c.edge.from + 1];
      ++of_point_[c.edge.to + 1];
    }
    for (std::size_t i = 1; i < of_point_.size(); ++i) of_point_[i] += of_point_[i - 1];
    rows_.resize(2 * crossings_.size());
    std::vector<Index> next(of_point_.begin(), of_point_.end() - 1);
    for (Index row = 0; row < static_cast<Index>(crossings_.size()); ++row) {
      rows_[next[crossings_[row].edge.from]++] = row;
      rows_[next[crossings_[row].edge.to]++] = row;
    }
  }

  /// Each point that a crossing is near to moves to the nearest one, in the lattice's order.
  void move_points() {
    for (Index point = 0; point < static_cast<Index>(side_.size()); ++point) {
      Index nearest = -1;
      for (Index k = of_point_[point]; k < of_point_[point + 1]; ++k) {
        const Crossing& c = crossings_[rows_[k]];
        if (!c.is_there || !c.is_near(point)) continue;
        if (nearest < 0 || c.length_from(point) < crossings_[nearest].length_from(point)) nearest = rows_[k];
      }
      if (nearest < 0) continue;
      side_[point] = on_surface;
      moved_[point] = nearest;
      for (Index k = of_point_[point]; k < of_point_[point + 1]; ++k) crossings_[rows_[k]].is_there = false;
    }
  }

  Vec3 place_of(const Crossing& c) const {
    const Vec3 from = lattice_.place(c.edge.from);
    return from + c.share * (lattice_.place(c.edge.to) - from);
  }

  // A corner of what is cut out of a tetrahedron of the lattice: one of its points, or where two of them, the first
  // inside and the second outside, have the surface between them.
  struct Corner {
    int in = 0, out = -1;  // of 0 ... 3
  };

  Index crossing_of(Index in, Index out) const {
    Index k = of_point_[in];
    while (crossings_[rows_[k]].edge.to != out) ++k;
    assert(k < of_point_[in + 1]);
    return rows_[k];
  }

  Index particle_of(const Tetrahedron& t, const Corner& corner) {
    const Index in = t[corner.in];
    const bool at_surface = corner.out >= 0 || moved_[in] >= 0;
    Index& own = corner.out < 0 ? particle_[in] : crossings_[crossing_of(in, t[corner.out])].particle;
    if (own < 0) {
      own = static_cast<Index>(result_.place.size());
      result_.place.push_back(place_of(t, corner));
      result_.at_surface.push_back(at_surface);
      if constexpr (is_graded) result_.leaf_edge.push_back(lattice_.leaf_edge(in));
    }
    return own;
  }

  Vec3 place_of(const Tetrahedron& t, const Corner& corner) const {
    if (corner.out >= 0) return place_of(crossings_[crossing_of(t[corner.in], t[corner.out])]);
    const Index in = t[corner.in];
    return moved_[in] < 0 ? lattice_.place(in) : place_of(crossings_[moved_[in]]);
  }

  /// Orders the corners by where they lie in the lattice's own tetrahedron, cut edges halved: no rounding decides.
  void add_cell(const Tetrahedron& t, std::array<Corner, 4> corners) {
    Eigen::Matrix4d share = Eigen::Matrix4d::Zero();
    for (int k = 0; k < 4; ++k) {
      share(corners[k].in, k) += 1.0;
      if (corners[k].out >= 0) share(corners[k].out, k) += 1.0;
    }
    if (share.determinant() < 0.0) std::swap(corners[2], corners[3]);
    Tetrahedron cell{};
    for (int k = 0; k < 4; ++k) cell[k] = particle_of(t, corners[k]);
    result_.cells.push_back(cell);
  }

  /// The face of points a, b inside and c outside is cut to a quadrilateral a, b, bc, ac: true where its diagonal
  /// starts in a, and not in b. Depends on the face alone, because two tetrahedra share it.
  bool diagonal_from_first(const Tetrahedron& t, int a, int b, int c) const {
    if constexpr (is_graded) {
      // An order by nearness to c: diagonals never run around the prism of three points and c. Between middles and
      // corners of one size it is the rule below.
      const double longer = lattice_.length(t[a], t[c]) - lattice_.length(t[b], t[c]);
      return longer != 0.0 ? longer < 0.0 : t[a] < t[b];
    } else {
      const bool same_kind = CentredLattice::is_middle(t[a]) == CentredLattice::is_middle(t[b]);
      if (!same_kind) return CentredLattice::is_middle(t[a]) != CentredLattice::is_middle(t[c]);
      return from_first(t, {{{a}, {b}, {b, c}, {a, c}}});
    }
  }

  /// Of the two diagonals of a quadrilateral the shorter; where they are alike, that from the smaller point.
  bool from_first(const Tetrahedron& t, const std::array<Corner, 4>& q) const {
    const double longer =
        (place_of(t, q[2]) - place_of(t, q[0])).squaredNorm() - (place_of(t, q[3]) - place_of(t, q[1])).squaredNorm();
    if (std::abs(longer) > tie_) return longer < 0.0;
    return t[q[0].in] < t[q[1].in];
  }

  /// A prism between the triangles 0, 1, 2 and 0', 1', 2'. first[k], of the sides 01, 02, 12: their diagonal starts in
  /// the lower number of the first triangle. They must not run around the prism.
  void add_prism(const Tetrahedron& t, const std::array<Corner, 3>& low, const std::array<Corner, 3>& high,
                 const std::array<bool, 3>& first) {
    std::array<int, 3> diagonals{first[0] + first[1], !first[0] + first[2], !first[1] + !first[2]};
    std::array<int, 3> order{};  // by the number of diagonals that start in each
    for (int k = 0; k < 3; ++k) order[2 - diagonals[k]] = k;
    const auto [a, b, c] = order;
    add_cell(t, {low[a], low[b], low[c], high[c]});
    add_cell(t, {low[a], low[b], high[b], high[c]});
    add_cell(t, {low[a], high[a], high[b], high[c]});
  }

  void cut_cell(const Tetrahedron& t) {
    std::array<int, 4> in{}, on{}, out{};
    int ins = 0, ons = 0, outs = 0;
    for (int k = 0; k < 4; ++k) {
      const signed char side = side_[t[k]];
      if (side == inside) in[ins++] = k;
      if (side == on_surface) on[ons++] = k;
      if (side == outside) out[outs++] = k;
    }
    if (ins == 0) return;
    if (outs == 0) return add_cell(t, {{{0}, {1}, {2}, {3}}});
    if (ins == 1) {
      std::array<Corner, 4> corners{};
      for (int k = 0; k < 4; ++k) corners[k] = side_[t[k]] == outside ? Corner{in[0], k} : Corner{k};
      return add_cell(t, corners);
    }
    const int a = in[0], b = in[1], c = in[2];
    if (ins == 2 && outs == 1) {
      const int o = out[0];
      const bool first = diagonal_from_first(t, a, b, o);
      const Corner apex{on[0]};
      add_cell(t, {{first ? Corner{b, o} : Corner{a, o}, {a}, {b}, apex}});
      add_cell(t, {{first ? Corner{a} : Corner{b}, {b, o}, {a, o}, apex}});
    } else if (ins == 2) {
      const int o = out[0], p = out[1];
      const bool ab = diagonal_from_first(t, a, b, o), ap = diagonal_from_first(t, a, b, p);
      // The side that the surface cuts out is free, but for a diagonal that would run around.
      const bool op = ab == ap ? from_first(t, {{{a, o}, {a, p}, {b, p}, {b, o}}}) : ap;
      add_prism(t, {{{a}, {a, o}, {a, p}}}, {{{b}, {b, o}, {b, p}}}, {ab, ap, op});
    } else {
      const int o = out[0];
      add_prism(t, {{{a}, {b}, {c}}}, {{{a, o}, {b, o}, {c, o}}},
                {diagonal_from_first(t, a, b, o), diagonal_from_first(t, a, c, o), diagonal_from_first(t, b, c, o)});
    }
  }

  static double edge_of(const CentredLattice& lattice) { return lattice.edge; }
  static double edge_of(const GradedLattice& lattice) { return lattice.roots().edge; }

  const Lattice& lattice_;
  const double tie_ = 1e-9 * edge_of(lattice_) * edge_of(lattice_);  // m^2
  std::vector<signed char> side_;                                    // [points] Side
  std::vector<Crossing> crossings_;
  std::vector<Index> of_point_;  // [points + 1] first of each point in rows_
  std::vector<Index> rows_;      // of crossings_
  std::vector<Index> moved_;     // [points] crossing that it moved to; -1: none
  std::vector<Index> particle_;  // [points] -1: none yet
  Stuffing result_;
};

}  // namespace

Stuffing stuffed(const Interior& interior, const CentredLattice& lattice) {
  return Filling(interior, lattice).take();
}

Stuffing stuffed(const Interior& interior, const GradedLattice& lattice) {
  return Filling(interior, lattice).take();
}

}  // namespace phymul
