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

/// Corners of the hexahedron [-1, 1]^3 in PML's order; the first four, in the plane, are those of a quad.
constexpr std::array<std::array<double, 3>, 8> corner{
    {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};

/// Two Gauss points along each axis. `vertex_of`: the cell's vertex at each corner; several corners may share one.
Rule hexahedron_rule(int dimension, std::span<const int> vertex_of) {
  const double place = std::sqrt(1.0 / 3.0);
  const bool plane = dimension == 2;
  Rule rule;
  for (std::size_t k = 0; k < vertex_of.size(); ++k) {
    ReferencePoint point;
    point.slope.fill(Vec3::Zero());
    point.weight = 1.0;
    for (std::size_t c = 0; c < vertex_of.size(); ++c) {
      const auto& at = corner[c];
      const double x = 0.5 * (1.0 + at[0] * corner[k][0] * place), y = 0.5 * (1.0 + at[1] * corner[k][1] * place);
      const double z = plane ? 1.0 : 0.5 * (1.0 + at[2] * corner[k][2] * place);
      point.value[vertex_of[c]] += x * y * z;
      point.slope[vertex_of[c]] += 0.5 * Vec3(at[0] * y * z, at[1] * x * z, plane ? 0.0 : at[2] * x * y);
    }
    rule.push_back(point);
  }
  return rule;
}

const Rule& rule_of(CellType type) {
  static const Rule triangle = simplex_rule(2), tetrahedron = simplex_rule(3);
  static const Rule quad = hexahedron_rule(2, std::array{0, 1, 2, 3});
  static const Rule hexahedron = hexahedron_rule(3, std::array{0, 1, 2, 3, 4, 5, 6, 7});
  static const Rule wedge = hexahedron_rule(3, std::array{0, 1, 2, 2, 3, 4, 5, 5});
  static const Rule pyramid = hexahedron_rule(3, std::array{0, 1, 2, 3, 4, 4, 4, 4});
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
