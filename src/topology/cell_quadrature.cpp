// SPDX-License-Identifier: MIT
#include "cell_quadrature.h"

#include <phymul/error.h>

#include <Eigen/LU>
#include <cmath>

#include "model/cell_geometry.h"

namespace phymul {
namespace {

/// A point of the reference cell: shape functions, their derivatives by its coordinates, and its weight.
struct ReferencePoint {
  double weight = 0.0;
  std::array<double, 8> value{};
  std::array<Vec3, 8> slope;
};
using Rule = std::vector<ReferencePoint>;

/// Triangle and tetrahedron of unit edges along the axes: as many points as vertices, degree 2.
/// Source: Stroud, Approximate Calculation of Multiple Integrals, 1971 (T2: 2-1, T3: 2-1).
Rule simplex_rule(int dimension) {
  const int vertices = dimension + 1;
  const double near = dimension == 2 ? 2.0 / 3.0 : 0.25 + 0.15 * std::sqrt(5.0);
  const double far = (1.0 - near) / dimension;
  Rule rule;
  for (int at = 0; at < vertices; ++at) {
    ReferencePoint point;
    point.slope.fill(Vec3::Zero());
    point.weight = (dimension == 2 ? 0.5 : 1.0 / 6.0) / vertices;
    for (int v = 0; v < vertices; ++v) {
      point.value[v] = v == at ? near : far;
      point.slope[v] = v == 0 ? Vec3(-1.0, -1.0, dimension == 2 ? 0.0 : -1.0) : Vec3(Vec3::Unit(v - 1));
    }
    rule.push_back(point);
  }
  return rule;
}

struct Gauss {
  std::vector<double> place, weight;
};

Gauss gauss(int points) {
  if (points == 1) return {{0.0}, {2.0}};
  if (points == 2) return {{-std::sqrt(1.0 / 3.0), std::sqrt(1.0 / 3.0)}, {1.0, 1.0}};
  return {{-std::sqrt(0.6), 0.0, std::sqrt(0.6)}, {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0}};
}

/// Corners of the hexahedron [-1, 1]^3 in PML's order; the first four, in the plane, are those of a quad.
constexpr std::array<std::array<double, 3>, 8> corner{
    {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};

/// `vertex_of`: the cell's vertex at each corner; several corners may share one.
Rule hexahedron_rule(int dimension, std::span<const int> vertex_of, int upward_points) {
  const Gauss across = gauss(2), upward = dimension == 2 ? Gauss{{0.0}, {1.0}} : gauss(upward_points);
  Rule rule;
  for (std::size_t k = 0; k < upward.place.size(); ++k) {
    for (int j = 0; j < 2; ++j) {
      for (int i = 0; i < 2; ++i) {
        ReferencePoint point;
        point.slope.fill(Vec3::Zero());
        point.weight = across.weight[i] * across.weight[j] * upward.weight[k];
        for (std::size_t c = 0; c < vertex_of.size(); ++c) {
          const auto& at = corner[c];
          const double x = 0.5 * (1.0 + at[0] * across.place[i]), y = 0.5 * (1.0 + at[1] * across.place[j]);
          const double z = dimension == 2 ? 1.0 : 0.5 * (1.0 + at[2] * upward.place[k]);
          point.value[vertex_of[c]] += x * y * z;
          point.slope[vertex_of[c]] += 0.5 * Vec3(at[0] * y * z, at[1] * x * z, dimension == 2 ? 0.0 : at[2] * x * y);
        }
        rule.push_back(point);
      }
    }
  }
  return rule;
}

const Rule& rule_of(CellType type) {
  static const Rule triangle = simplex_rule(2), tetrahedron = simplex_rule(3);
  static const Rule quad = hexahedron_rule(2, std::array{0, 1, 2, 3}, 1);
  static const Rule hexahedron = hexahedron_rule(3, std::array{0, 1, 2, 3, 4, 5, 6, 7}, 2);
  static const Rule wedge = hexahedron_rule(3, std::array{0, 1, 2, 2, 3, 4, 5, 5}, 2);
  // Towards the apex the volume falls as a square: a third point keeps the rule exact.
  static const Rule pyramid = hexahedron_rule(3, std::array{0, 1, 2, 3, 4, 4, 4, 4}, 3);
  switch (type) {
    case CellType::triangle:
      return triangle;
    case CellType::quad:
      return quad;
    case CellType::tetrahedron:
      return tetrahedron;
    case CellType::wedge:
      return wedge;
    case CellType::pyramid:
      return pyramid;
    default:
      return hexahedron;
  }
}

}  // namespace

void cell_points(const Model& model, Index row, std::vector<CellPoint>& points) {
  const Cell& cell = model.cells[row];
  const bool plane = model.dimension == 2;
  const double winding = plane && signed_measure(2, cell, model.rest) < 0.0 ? -1.0 : 1.0;
  const Vec3& origin = model.rest[cell.particles[0]];
  const bool linear = cell.type == CellType::triangle || cell.type == CellType::tetrahedron;
  points.clear();
  for (const ReferencePoint& at : rule_of(cell.type)) {
    if (linear && !points.empty()) {  // the same map everywhere
      points.push_back(points.front());
      points.back().value = at.value;
      continue;
    }
    Mat3 map = plane ? Mat3(Vec3(0.0, 0.0, 1.0).asDiagonal()) : Mat3(Mat3::Zero());
    for (std::size_t v = 1; v < cell.particles.size(); ++v) {
      map += (model.rest[cell.particles[v]] - origin) * at.slope[v].transpose();
    }
    const double determinant = winding * map.determinant();
    if (!(determinant > 0.0)) {
      throw Error(ErrorCode::invalid_model,
                  cell_label(model, static_cast<std::size_t>(row)) +
                      " is folded or inside out at rest: its volume is not positive everywhere. Run check_mesh, which "
                      "turns wrongly wound cells, or mend the mesh");
    }
    const Mat3 pull = map.inverse().transpose();
    CellPoint point;
    point.volume = at.weight * determinant;
    point.value = at.value;
    for (std::size_t v = 0; v < 8; ++v) point.gradient[v] = pull * at.slope[v];
    points.push_back(point);
  }
}

}  // namespace phymul
