// SPDX-License-Identifier: MIT
#include "improve_cells.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numbers>

#include "model/enclosed_volume.h"

namespace phymul {
namespace {

constexpr double radians = std::numbers::pi / 180.0;
constexpr double good_angle = 15.0 * radians;
constexpr int passes = 8;

/// The smallest dihedral angle, or what the largest lacks to 180 degrees and 5 more; below 0 if inverted.
double quality(const std::array<Vec3, 4>& corner) {
  const double volume = (corner[3] - corner[0]).dot((corner[1] - corner[0]).cross(corner[2] - corner[0]));
  const Angles angles = dihedral_angles(corner);
  const double worst = std::min(angles.smallest, std::numbers::pi - angles.largest);
  return volume > 0.0 ? worst : -worst - 1e-3;
}

/// Along the axes and the diagonals between them.
std::array<Vec3, 14> directions() {
  std::array<Vec3, 14> all;
  for (int k = 0; k < 6; ++k) all[k] = (k % 2 ? 1.0 : -1.0) * Vec3::Unit(k / 2);
  for (int k = 0; k < 8; ++k) all[6 + k] = Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1).normalized();
  return all;
}

class Improvement {
 public:
  Improvement(Stuffing& body, const std::vector<std::array<Index, 3>>& outer_faces)
      : body_(body), normal_(body.place.size()), cells_(body.place.size()) {
    volume_gradient(outer_faces, body.place, normal_);
    for (Vec3& normal : normal_) normal.normalize();  // zero inside
    for (Index row = 0; row < static_cast<Index>(body.cells.size()); ++row) {
      for (const Index i : body.cells[row]) cells_[i].push_back(row);
    }
    for (int pass = 0; pass < passes; ++pass) {
      std::vector<Index> bad;
      for (const Tetrahedron& cell : body.cells) {
        if (quality(corners_of(cell, body.place)) < good_angle) bad.insert(bad.end(), cell.begin(), cell.end());
      }
      if (bad.empty()) break;
      std::ranges::sort(bad);
      bad.erase(std::ranges::unique(bad).begin(), bad.end());
      for (const Index i : bad) improve(i);
    }
  }

 private:
  double worst_at(Index i) const {
    double worst = std::numbers::pi;
    for (const Index row : cells_[i]) worst = std::min(worst, quality(corners_of(body_.cells[row], body_.place)));
    return worst;
  }

  double shortest_at(Index i) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Index row : cells_[i]) {
      for (const Index j : body_.cells[row]) {
        if (j != i) least = std::min(least, (body_.place[j] - body_.place[i]).norm());
      }
    }
    return least;
  }

  void improve(Index i) {
    Vec3& place = body_.place[i];
    const Vec3& normal = normal_[i];
    double best = worst_at(i);
    double step = 0.3 * shortest_at(i);
    for (int turn = 0; turn < 6; ++turn, step *= 0.5) {
      const Vec3 from = place;
      Vec3 to = from;
      for (const Vec3& along : directions_) {
        place = from + step * (along - along.dot(normal) * normal);
        const double own = worst_at(i);
        if (own <= best) continue;
        best = own;
        to = place;
      }
      place = to;
    }
  }

  const std::array<Vec3, 14> directions_ = directions();
  Stuffing& body_;
  VecList normal_;                         // [places] outward; zero inside
  std::vector<std::vector<Index>> cells_;  // [places] rows
};

}  // namespace

void improve_cells(Stuffing& body, const std::vector<std::array<Index, 3>>& outer_faces) {
  Improvement(body, outer_faces);
}

}  // namespace phymul
