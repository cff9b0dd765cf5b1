// SPDX-License-Identifier: MIT
#include "cell_interpolation.h"

#include <phymul/error.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace phymul::bench {
namespace {

using Weights = std::array<double, 8>;

/// Shape functions at local coordinates: hexahedra [-1, 1]^3; wedges r, s >= 0, r + s <= 1, t in [-1, 1]; tetrahedra
/// r, s, t >= 0, r + s + t <= 1; pyramids r, s in [-1, 1], t in [0, 1] with the apex at t = 1.
Weights shape_functions(CellType type, const Vec3& local) {
  const double r = local.x(), s = local.y(), t = local.z();
  Weights w{};
  const auto ring = [&](std::size_t first, double share) {
    w[first] = share * (1 - r) * (1 - s) / 4;
    w[first + 1] = share * (1 + r) * (1 - s) / 4;
    w[first + 2] = share * (1 + r) * (1 + s) / 4;
    w[first + 3] = share * (1 - r) * (1 + s) / 4;
  };
  switch (type) {
    case CellType::hexahedron:
      ring(0, (1 - t) / 2);
      ring(4, (1 + t) / 2);
      break;
    case CellType::wedge:
      for (std::size_t k : {0u, 3u}) {
        const double share = k == 0 ? (1 - t) / 2 : (1 + t) / 2;
        w[k] = share * (1 - r - s), w[k + 1] = share * r, w[k + 2] = share * s;
      }
      break;
    case CellType::tetrahedron:
      w[0] = 1 - r - s - t, w[1] = r, w[2] = s, w[3] = t;
      break;
    default:
      ring(0, 1 - t);
      w[4] = t;
  }
  return w;
}

double outside(CellType type, const Vec3& p) {
  const double r = p.x(), s = p.y(), t = p.z();
  switch (type) {
    case CellType::hexahedron:
      return (p.cwiseAbs().maxCoeff() - 1) / 2;
    case CellType::wedge:
      return std::max({-r, -s, r + s - 1, (std::abs(t) - 1) / 2});
    case CellType::tetrahedron:
      return std::max({-r, -s, -t, r + s + t - 1});
    default:
      return std::max({(std::abs(r) - 1) / 2, (std::abs(s) - 1) / 2, -t, t - 1});
  }
}

class CellMap {
 public:
  CellMap(const Model& model, Index row) : model_(model), cell_(model.cells[row]), row_(row) {}

  /// Newton's method; the map is linear in each coordinate, so that a central difference of any length is exact.
  PlaceInCell place(const Vec3& point) const {
    Vec3 local = cell_.type == CellType::hexahedron ? Vec3(0, 0, 0) : Vec3(0.25, 0.25, 0.25);
    for (int step = 0; step < 30; ++step) {
      const Vec3 off = point - at(local);
      Mat3 slope;
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 half = 0.25 * Vec3::Unit(axis);
        slope.col(axis) = 2.0 * (at(local + half) - at(local - half));
      }
      const Vec3 move = slope.partialPivLu().solve(off);
      if (!move.allFinite()) break;
      local += move.cwiseMax(-1.0).cwiseMin(1.0);
      if (move.norm() < 1e-13) break;
    }
    PlaceInCell result;
    result.cell = row_;
    result.count = static_cast<int>(cell_.particles.size());
    std::ranges::copy(cell_.particles, result.particle.begin());
    result.weight = shape_functions(cell_.type, local);
    const double error = (at(local) - point).norm();
    result.outside = error < 1e-9 * body_reach() ? outside(cell_.type, local) : 1e9;
    return result;
  }

  /// Whether the point is within half the cell's box around it.
  bool near(const Vec3& point) const {
    Vec3 low = model_.rest[cell_.particles[0]], high = low;
    for (const Index i : cell_.particles) {
      low = low.cwiseMin(model_.rest[i]);
      high = high.cwiseMax(model_.rest[i]);
    }
    const Vec3 margin = 0.5 * (high - low);
    return ((point - low + margin).array() >= 0).all() && ((high + margin - point).array() >= 0).all();
  }

 private:
  Vec3 at(const Vec3& local) const {
    const Weights w = shape_functions(cell_.type, local);
    Vec3 sum = Vec3::Zero();
    for (std::size_t v = 0; v < cell_.particles.size(); ++v) sum += w[v] * model_.rest[cell_.particles[v]];
    return sum;
  }
  double body_reach() const { return (model_.rest[cell_.particles[0]] - model_.rest[cell_.particles[1]]).norm(); }

  const Model& model_;
  const Cell& cell_;
  Index row_;
};

}  // namespace

Vec3 PlaceInCell::interpolate(std::span<const Vec3> values) const {
  Vec3 sum = Vec3::Zero();
  for (int v = 0; v < count; ++v) sum += weight[v] * values[particle[v]];
  return sum;
}

std::vector<PlaceInCell> locate(const Model& model, std::span<const Vec3> points) {
  std::vector<PlaceInCell> places;
  for (const Vec3& point : points) {
    PlaceInCell best;
    best.outside = 1e9;
    for (Index row = 0; row < static_cast<Index>(model.cells.size()) && best.outside > 0.0; ++row) {
      if (!is_volume(model.cells[row].type)) continue;
      const CellMap map(model, row);
      if (!map.near(point)) continue;
      const PlaceInCell place = map.place(point);
      if (place.outside < best.outside) best = place;
    }
    if (best.outside > 0.5) {
      char text[120];
      std::snprintf(text, sizeof text, "sample point (%g, %g, %g) m is outside the body", point.x(), point.y(),
                    point.z());
      throw Error(text);
    }
    places.push_back(best);
  }
  return places;
}

}  // namespace phymul::bench
