// SPDX-License-Identifier: MIT
#include "cell_quadrature.h"

#include <phymul/error.h>

#include <Eigen/Geometry>
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

/// Corners of the hexahedron [-1, 1]^3 in PML's order; the first four, in the plane, are those of a quad.
constexpr std::array<std::array<double, 3>, 8> cube_corner{
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
      const auto& at = cube_corner[c];
      const double x = 0.5 * (1.0 + at[0] * cube_corner[k][0] * place),
                   y = 0.5 * (1.0 + at[1] * cube_corner[k][1] * place);
      const double z = plane ? 1.0 : 0.5 * (1.0 + at[2] * cube_corner[k][2] * place);
      point.value[vertex_of[c]] += x * y * z;
      point.slope[vertex_of[c]] += 0.5 * Vec3(at[0] * y * z, at[1] * x * z, plane ? 0.0 : at[2] * x * y);
    }
    rule.push_back(point);
  }
  return rule;
}

const Rule& rule_of(CellType type) {
  static const Rule quad = hexahedron_rule(2, std::array{0, 1, 2, 3});
  static const Rule hexahedron = hexahedron_rule(3, std::array{0, 1, 2, 3, 4, 5, 6, 7});
  static const Rule wedge = hexahedron_rule(3, std::array{0, 1, 2, 2, 3, 4, 5, 5});
  static const Rule pyramid = hexahedron_rule(3, std::array{0, 1, 2, 3, 4, 4, 4, 4});
  switch (type) {
    case CellType::quad:
      return quad;
    case CellType::wedge:
      return wedge;
    case CellType::pyramid:
      return pyramid;
    default:
      return hexahedron;
  }
}

bool is_linear(CellType type) {
  return type == CellType::triangle || type == CellType::tetrahedron;
}

void require_not_folded(double determinant, const Model& model, Index row) {
  if (determinant > 0.0) return;
  throw Error(ErrorCode::invalid_model,
              cell_label(model, static_cast<std::size_t>(row)) +
                  " is folded or inside out at rest: its volume is not positive everywhere. Run check_mesh, which "
                  "turns wrongly wound cells, or mend the mesh");
}

/// Triangle or tetrahedron: grad N_v of the vertices but the first are the rows of the inverse of the edges from there.
void linear_point(const Model& model, Index row, CellPoint& point) {
  const std::vector<Index>& vertex = model.cells[row].particles;
  const Vec3& origin = model.rest[vertex[0]];
  const bool plane = model.dimension == 2;
  const Vec3 a = model.rest[vertex[1]] - origin, b = model.rest[vertex[2]] - origin;
  const Vec3 c = plane ? Vec3(Vec3::UnitZ()) : Vec3(model.rest[vertex[3]] - origin);
  const Vec3 across = b.cross(c);
  const double determinant = a.dot(across);
  require_not_folded(plane ? std::abs(determinant) : determinant, model, row);
  point.gradient[1] = across / determinant;
  point.gradient[2] = c.cross(a) / determinant;
  point.gradient[3] = plane ? Vec3(Vec3::Zero()) : Vec3(a.cross(b) / determinant);
  point.gradient[0] = -(point.gradient[1] + point.gradient[2] + point.gradient[3]);
  point.volume = std::abs(determinant) / (plane ? 2.0 : 6.0);
  point.value.fill(plane ? 1.0 / 3.0 : 0.25);
}

/// A point of another cell.
void mapped_point(const Model& model, Index row, double winding, const ReferencePoint& at, CellPoint& point) {
  const std::vector<Index>& vertex = model.cells[row].particles;
  const Vec3& origin = model.rest[vertex[0]];
  Mat3 map = model.dimension == 2 ? Mat3(Vec3::UnitZ().asDiagonal()) : Mat3(Mat3::Zero());
  for (std::size_t v = 1; v < vertex.size(); ++v) map += (model.rest[vertex[v]] - origin) * at.slope[v].transpose();
  const double determinant = winding * map.determinant();
  require_not_folded(determinant, model, row);
  const Mat3 pull = map.inverse().transpose();
  point.volume = at.weight * determinant;
  point.value = at.value;
  for (std::size_t v = 0; v < vertex.size(); ++v) point.gradient[v] = pull * at.slope[v];
}

}  // namespace

void cell_points(const Model& model, Index row, std::vector<CellPoint>& points) {
  const Cell& cell = model.cells[row];
  if (is_linear(cell.type)) {
    points.resize(1);
    linear_point(model, row, points.front());
    points.front().volume *= cell.share;
    return;
  }
  const double winding = model.dimension == 2 && signed_measure(2, cell, model.rest) < 0.0 ? -1.0 : 1.0;
  const Rule& rule = rule_of(cell.type);
  points.resize(rule.size());
  for (std::size_t k = 0; k < rule.size(); ++k) {
    mapped_point(model, row, winding, rule[k], points[k]);
    points[k].volume *= cell.share;
  }
}

double integral_of_square(CellType type, std::span<const CellPoint> points, std::span<const double> at_vertex) {
  double sum = 0.0;
  for (const CellPoint& point : points) {
    double value = 0.0;
    for (std::size_t v = 0; v < at_vertex.size(); ++v) value += point.value[v] * at_vertex[v];
    sum += point.volume * value * value;
    if (!is_linear(type)) continue;
    // n vertices: the mean of f^2 is that of f squared plus sum (f_v - mean)^2 / (n (n + 1)).
    double spread = 0.0;
    for (const double f : at_vertex) spread += (f - value) * (f - value);
    const auto n = static_cast<double>(at_vertex.size());
    sum += point.volume * spread / (n * (n + 1.0));
  }
  return sum;
}

}  // namespace phymul
