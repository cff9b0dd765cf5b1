// SPDX-License-Identifier: MIT
#include "region_interfaces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <numbers>
#include <tuple>

#include "dihedral_angles.h"

namespace phymul {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr Angles good_angles{15.0 * degree, 155.0 * degree};

using Edge = std::array<Index, 2>;

class Meeting {
 public:
  Meeting(Stuffing& body, const LabelField& field) : body_(body), field_(field) {
    region_.reserve(body.place.size());
    for (const Vec3& x : body.place) region_.push_back(region_at(x));
    moved_.assign(body.place.size(), 0);
    find_mixed_edges();
    if (edges_.empty()) return;
    sort_cells();
    find_moves();
    // A move that spoiled a cell may be good after others.
    for (int sweep = 0; sweep < 2; ++sweep) {
      for (const Move& move : moves_) try_move(move);
    }
  }

 private:
  /// Of one end of an edge, onto the boundary.
  struct Move {
    double distance;
    Index particle;
    Index edge;  // row of edges_
    Vec3 target;
  };

  int region_at(const Vec3& x) const { return field_.shares(x).largest(); }

  /// Between particles of two regions, each once.
  void find_mixed_edges() {
    for (const Tetrahedron& cell : body_.cells) {
      for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < a; ++b) {
          const Index i = std::min(cell[a], cell[b]), j = std::max(cell[a], cell[b]);
          if (region_[i] != region_[j]) edges_.push_back({i, j});
        }
      }
    }
    std::ranges::sort(edges_);
    const auto repeated = std::ranges::unique(edges_);
    edges_.erase(repeated.begin(), repeated.end());
  }

  void sort_cells() {
    of_particle_.assign(body_.place.size() + 1, 0);
    for (const Tetrahedron& cell : body_.cells) {
      for (const Index i : cell) ++of_particle_[i + 1];
    }
    for (std::size_t i = 1; i < of_particle_.size(); ++i) of_particle_[i] += of_particle_[i - 1];
    cells_.resize(4 * body_.cells.size());
    std::vector<Index> next(of_particle_.begin(), of_particle_.end() - 1);
    for (Index row = 0; row < static_cast<Index>(body_.cells.size()); ++row) {
      for (const Index i : body_.cells[row]) cells_[next[i]++] = row;
    }
  }

  /// The last share of the way from a place that is still in its region. The way must leave it.
  double way_out(const Vec3& from, const Vec3& to, int region) const {
    double inside = 0.0, outside = 1.0;
    while (outside - inside > 1e-4) {
      const double middle = 0.5 * (inside + outside);
      (region_at(from + middle * (to - from)) == region ? inside : outside) = middle;
    }
    return 0.5 * (inside + outside);
  }

  /// Direction in which the share of one region falls and that of the other grows.
  Vec3 normal_at(const Vec3& x, int from, int to) const {
    const double step = 0.25 * field_.voxel();
    Vec3 normal;
    for (int axis = 0; axis < 3; ++axis) {
      const RegionShares ahead = field_.shares(x + step * Vec3::Unit(axis)),
                         behind = field_.shares(x - step * Vec3::Unit(axis));
      normal[axis] = ahead.of(to) - ahead.of(from) - behind.of(to) + behind.of(from);
    }
    return normal.normalized();  // zero if the shares are constant
  }

  void find_moves() {
    for (Index row = 0; row < static_cast<Index>(edges_.size()); ++row) {
      const auto [a, b] = edges_[row];
      const Vec3 &at_a = body_.place[a], &at_b = body_.place[b];
      const double share = way_out(at_a, at_b, region_[a]);
      const Vec3 crossing = at_a + share * (at_b - at_a);
      const int beyond = region_at(at_a + std::min(share + 1e-3, 1.0) * (at_b - at_a));
      const Vec3 normal = normal_at(crossing, region_[a], beyond);
      add_move(a, row, crossing, normal);
      add_move(b, row, crossing, normal);
    }
    std::ranges::sort(moves_, {}, [](const Move& m) { return std::tuple(m.distance, m.particle, m.edge); });
  }

  /// To where the normal of the boundary through the particle meets it, or to the crossing of the edge if that fails.
  void add_move(Index particle, Index edge, const Vec3& crossing, const Vec3& normal) {
    if (body_.at_surface[particle]) return;
    const Vec3& from = body_.place[particle];
    const Vec3 beyond = from + 1.5 * (crossing - from).dot(normal) * normal;
    Vec3 target = crossing;
    if (region_at(beyond) != region_[particle]) {
      const Vec3 nearest = from + way_out(from, beyond, region_[particle]) * (beyond - from);
      if ((nearest - from).norm() < (crossing - from).norm()) target = nearest;
    }
    moves_.push_back({(target - from).norm(), particle, edge, target});
  }

  void try_move(const Move& move) {
    const auto [a, b] = edges_[move.edge];
    if (moved_[a] || moved_[b]) return;
    for (Index k = of_particle_[move.particle]; k < of_particle_[move.particle + 1]; ++k) {
      const Tetrahedron& cell = body_.cells[cells_[k]];
      const std::array<Vec3, 4> before = corners_of(cell, body_.place);
      std::array<Vec3, 4> after = before;
      after[std::ranges::find(cell, move.particle) - cell.begin()] = move.target;
      if (!((after[1] - after[0]).cross(after[2] - after[0]).dot(after[3] - after[0]) > 0.0)) return;
      const Angles now = dihedral_angles(before), then = dihedral_angles(after);
      if (then.smallest < std::min(now.smallest, good_angles.smallest)) return;
      if (then.largest > std::max(now.largest, good_angles.largest)) return;
    }
    body_.place[move.particle] = move.target;
    moved_[move.particle] = 1;
  }

  Stuffing& body_;
  const LabelField& field_;
  std::vector<int> region_;         // [particles] before any moved
  std::vector<char> moved_;         // [particles] 1: on a boundary
  std::vector<Edge> edges_;         // that join two regions
  std::vector<Index> of_particle_;  // [particles + 1] first of each particle in cells_
  std::vector<Index> cells_;        // rows of the body's cells
  std::vector<Move> moves_;         // the shortest first
};

}  // namespace

void meet_interfaces(Stuffing& body, const LabelField& field) {
  Meeting(body, field);
}

}  // namespace phymul
