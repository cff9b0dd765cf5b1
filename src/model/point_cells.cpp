// SPDX-License-Identifier: MIT
#include "point_cells.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "cell_geometry.h"

namespace phymul {
namespace {

constexpr double flat = 1e-9;  // what rounding leaves of a height, over the neighbourhood's size

/// The side normal . r <= distance of a cell; distance >= 0, so that the particle is in it.
struct Side {
  Vec3 normal;  // not of unit length
  double distance;
};

/// Directions spread evenly, all of one weight: a spiral around the sphere (Vogel 1979 on a disc), or a circle.
std::vector<Vec3> even_directions(int dimension) {
  constexpr int count = 400;
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  std::vector<Vec3> all;
  for (int k = 0; k < count; ++k) {
    const double z = dimension == 2 ? 0.0 : 1.0 - (2.0 * k + 1.0) / count;
    const double angle = dimension == 2 ? 2.0 * std::numbers::pi * (k + 0.5) / count : golden * k;
    const double r = std::sqrt(1.0 - z * z);
    all.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return all;
}

/// Adds the plane through the particle (0) or neighbours with this normal where all neighbours are on one side of it.
void add_side(const VecList& r, const Vec3& on, const Vec3& normal, double size, std::vector<Side>& cell) {
  const double length = normal.norm(), height = normal.dot(on), slack = flat * size * length;
  if (!(length > 0.0)) return;
  const double sign = height >= -slack ? 1.0 : -1.0;  // so that 0 is inside
  const auto beyond = [&](double way) {
    return way * height < -slack ||
           std::ranges::any_of(r, [&](const Vec3& p) { return way * (normal.dot(p) - height) > slack; });
  };
  for (const double way : {sign, -sign}) {
    if (!beyond(way)) cell.push_back({way * normal, std::max(way * height, 0.0)});
  }
}

/// Sides of the convex hull of 0 and the neighbours.
void add_hull(const VecList& r, int dimension, double size, std::vector<Side>& cell) {
  for (std::size_t j = 0; j < r.size(); ++j) {
    if (dimension == 2) add_side(r, r[j], r[j].cross(Vec3::UnitZ()), size, cell);
    for (std::size_t k = j + 1; k < r.size(); ++k) {
      if (dimension == 2) {
        add_side(r, r[j], (r[k] - r[j]).cross(Vec3::UnitZ()), size, cell);
        continue;
      }
      const Vec3 through_own = r[j].cross(r[k]);
      if (through_own.norm() > flat * size * size) add_side(r, r[j], through_own, size, cell);
      for (std::size_t l = k + 1; l < r.size(); ++l) {
        const Vec3 normal = (r[k] - r[j]).cross(r[l] - r[j]);
        if (normal.norm() > flat * size * size) add_side(r, r[j], normal, size, cell);
      }
    }
  }
}

PointCell moments(const std::vector<Side>& cell, const std::vector<Vec3>& directions, int dimension) {
  PointCell sum;
  for (const Vec3& n : directions) {
    double reach = std::numeric_limits<double>::infinity();
    for (const Side& side : cell) {
      const double rate = side.normal.dot(n);
      if (rate * reach > side.distance) reach = side.distance / rate;
    }
    if (!std::isfinite(reach)) continue;  // no neighbours at all
    const double power = dimension == 2 ? reach * reach : reach * reach * reach;
    sum.volume += power / dimension;
    sum.first += power * reach / (dimension + 1) * n;
    sum.second += power * reach * reach / (dimension + 2) * n * n.transpose();
  }
  const double angle = (dimension == 2 ? 2.0 : 4.0) * std::numbers::pi / static_cast<double>(directions.size());
  return {angle * sum.volume, angle * sum.first, angle * sum.second};
}

}  // namespace

RaggedList point_neighbours(const Model& model) {
  const Index enough = model.dimension == 2 ? 8 : 14;
  const RaggedList& given = model.neighbours;
  RaggedList list;
  std::vector<Index> row;
  for (Index i = 0; i < model.particle_count(); ++i) {
    row.assign(given.begin(i), given.end(i));
    if (given.size(i) < enough) {
      for (const Index* j = given.begin(i); j != given.end(i); ++j)
        row.insert(row.end(), given.begin(*j), given.end(*j));
    }
    std::erase(row, i);
    std::ranges::sort(row);
    row.erase(std::ranges::unique(row).begin(), row.end());
    list.push_row(row.begin(), row.end());
  }
  return list;
}

std::vector<PointCell> point_cells(const Model& model, const RaggedList& neighbours) {
  const std::vector<Vec3> directions = even_directions(model.dimension);
  std::vector<PointCell> all;
  VecList r;
  std::vector<Side> cell;
  for (Index i = 0; i < model.particle_count(); ++i) {
    r.clear();
    cell.clear();
    double size = 0.0;
    for (const Index* j = neighbours.begin(i); j != neighbours.end(i); ++j) {
      r.push_back(model.rest[*j] - model.rest[i]);
      size = std::max(size, r.back().norm());
    }
    for (const Vec3& p : r) cell.push_back({p, 0.5 * p.squaredNorm()});
    add_hull(r, model.dimension, size, cell);
    all.push_back(moments(cell, directions, model.dimension));
  }
  return all;
}

bool is_body_of_points(const Model& model) {
  return std::ranges::none_of(
      model.cells, [&](const Cell& cell) { return is_solid(model.dimension, cell.type) || is_wall(model, cell); });
}

}  // namespace phymul
