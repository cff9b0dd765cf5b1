// SPDX-License-Identifier: MIT
#include "cell_geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace phymul {
namespace {

constexpr CellEdge line_edges[] = {{0, 1}};
constexpr CellEdge triangle_edges[] = {{0, 1}, {1, 2}, {2, 0}};
constexpr CellEdge quad_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
constexpr CellEdge tetrahedron_edges[] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
constexpr CellEdge wedge_edges[] = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}};
constexpr CellEdge pyramid_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}};
constexpr CellEdge hexahedron_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                         {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};

constexpr CellFace tetrahedron_faces[] = {{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}};
constexpr CellFace wedge_faces[] = {{0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
constexpr CellFace pyramid_faces[] = {{0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}};
constexpr CellFace hexahedron_faces[] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                         {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

constexpr CellCorner tetrahedron_corners[] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}};
constexpr CellCorner wedge_corners[] = {{0, 1, 2, 3}, {1, 2, 0, 4}, {2, 0, 1, 5},
                                        {3, 5, 4, 0}, {4, 3, 5, 1}, {5, 4, 3, 2}};
constexpr CellCorner pyramid_corners[] = {{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}};
constexpr CellCorner hexahedron_corners[] = {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7},
                                             {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}};

constexpr int triangle_reversal[] = {0, 2, 1};
constexpr int quad_reversal[] = {0, 3, 2, 1};
constexpr int tetrahedron_reversal[] = {0, 2, 1, 3};
constexpr int wedge_reversal[] = {3, 4, 5, 0, 1, 2};
constexpr int pyramid_reversal[] = {0, 3, 2, 1, 4};
constexpr int hexahedron_reversal[] = {4, 5, 6, 7, 0, 1, 2, 3};

struct CellTables {
  std::span<const CellEdge> edges{};
  std::span<const CellFace> faces{};
  std::span<const CellCorner> corners{};
  std::span<const int> reversal{};
};

/// Rows in the order of CellType.
constexpr CellTables tables[] = {
    {},
    {.edges = line_edges},
    {.edges = triangle_edges, .reversal = triangle_reversal},
    {.edges = quad_edges, .reversal = quad_reversal},
    {tetrahedron_edges, tetrahedron_faces, tetrahedron_corners, tetrahedron_reversal},
    {wedge_edges, wedge_faces, wedge_corners, wedge_reversal},
    {pyramid_edges, pyramid_faces, pyramid_corners, pyramid_reversal},
    {hexahedron_edges, hexahedron_faces, hexahedron_corners, hexahedron_reversal},
    {},
    {},
};

double six_volumes(const Vec3& a, const Vec3& b, const Vec3& c) {
  return a.dot(b.cross(c));
}

}  // namespace

std::span<const CellEdge> cell_edges(CellType type) {
  return tables[static_cast<int>(type)].edges;
}

std::span<const CellFace> cell_faces(CellType type) {
  return tables[static_cast<int>(type)].faces;
}

std::span<const CellCorner> cell_corners(CellType type) {
  return tables[static_cast<int>(type)].corners;
}

std::span<const int> cell_reversal(CellType type) {
  return tables[static_cast<int>(type)].reversal;
}

double signed_volume(CellType type, std::span<const Index> particles, std::span<const Vec3> position) {
  const std::span<const CellFace> faces = cell_faces(type);
  if (faces.empty()) return 0.0;
  // From one vertex, not from the origin: a body far away from it keeps its digits.
  const Vec3 origin = position[particles[0]];
  std::array<Vec3, 8> x;
  for (std::size_t v = 0; v < particles.size(); ++v) x[v] = position[particles[v]] - origin;
  double twelve_volumes = 0.0;
  for (const CellFace& face : faces) {
    const Vec3 &a = x[face[0]], &b = x[face[1]], &c = x[face[2]];
    if (face[3] < 0) {
      twelve_volumes += 2.0 * six_volumes(a, b, c);
    } else {
      const Vec3& d = x[face[3]];
      twelve_volumes += six_volumes(a, b, c) + six_volumes(a, c, d) + six_volumes(a, b, d) + six_volumes(b, c, d);
    }
  }
  return twelve_volumes / 12.0;
}

Vec3 area_vector(std::span<const Index> particles, std::span<const Vec3> position) {
  const Vec3& a = position[particles[0]];
  if (particles.size() < 4) return 0.5 * (position[particles[1]] - a).cross(position[particles[2]] - a);
  return 0.5 * (position[particles[2]] - a).cross(position[particles[3]] - position[particles[1]]);
}

bool has_walls(const Model& model) {
  return std::ranges::any_of(model.materials, [](const Material& of) { return of.thickness > 0.0; }) &&
         std::ranges::any_of(model.cells, [&](const Cell& cell) { return is_wall(model, cell); });
}

bool is_made_of_cells(const Model& model) {
  return std::ranges::any_of(model.cells, [&](const Cell& cell) { return is_solid(model.dimension, cell.type); });
}

bool is_solid(int dimension, CellType type) {
  if (dimension == 3) return is_volume(type);
  return type == CellType::triangle || type == CellType::quad;
}

double tissue_volume(const Model& model, const Cell& cell) {
  if (!is_of_wall(model, cell)) return signed_measure(model.dimension, cell, model.rest);
  return cell.share * model.materials[cell.material].thickness * area_vector(cell.particles, model.rest).norm();
}

double tissue_spacing(const Model& model, std::span<const Index> rows) {
  double volume = 0.0, area = 0.0;
  std::vector<char> in_space(model.rest.size(), 0), in_wall(model.rest.size(), 0);
  for (const Index row : rows) {
    const Cell& cell = model.cells[row];
    const bool wall = is_of_wall(model, cell);
    (wall ? area : volume) += wall ? cell.share * area_vector(cell.particles, model.rest).norm()
                                   : signed_measure(model.dimension, cell, model.rest);
    for (const Index i : cell.particles) (wall ? in_wall : in_space)[i] = 1;
  }
  const auto count = [](const std::vector<char>& in) { return static_cast<double>(std::ranges::count(in, 1)); };
  return volume > 0.0 ? std::cbrt(volume / count(in_space)) : std::sqrt(area / count(in_wall));
}

double signed_measure(int dimension, const Cell& cell, std::span<const Vec3> position) {
  if (!is_solid(dimension, cell)) return 0.0;
  return cell.share * (dimension == 3 ? signed_volume(cell.type, cell.particles, position)
                                      : area_vector(cell.particles, position).z());
}

std::string cell_label(const Model& model, std::size_t row) {
  const Cell& cell = model.cells[row];
  std::string label = "cell " + std::to_string(row) + " (" + cell_name(cell.type);
  const Index number = model.cell_file_index(static_cast<Index>(row));
  if (number >= 0) label += ", file index " + std::to_string(number);
  label += ')';
  if (!cell.name.empty()) label += " \"" + cell.name + '"';
  return label;
}

namespace {

constexpr double flat_hull = 1e-9;  // what rounding leaves of a height, over the neighbourhood's size

/// The side normal . r <= distance of a cell; distance >= 0, so that the particle is in it.
struct HullSide {
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
void add_side(const VecList& r, const Vec3& on, const Vec3& normal, double size, std::vector<HullSide>& cell) {
  const double length = normal.norm(), height = normal.dot(on), slack = flat_hull * size * length;
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
void add_hull(const VecList& r, int dimension, double size, std::vector<HullSide>& cell) {
  for (std::size_t j = 0; j < r.size(); ++j) {
    if (dimension == 2) add_side(r, r[j], r[j].cross(Vec3::UnitZ()), size, cell);
    for (std::size_t k = j + 1; k < r.size(); ++k) {
      if (dimension == 2) {
        add_side(r, r[j], (r[k] - r[j]).cross(Vec3::UnitZ()), size, cell);
        continue;
      }
      const Vec3 through_own = r[j].cross(r[k]);
      if (through_own.norm() > flat_hull * size * size) add_side(r, r[j], through_own, size, cell);
      for (std::size_t l = k + 1; l < r.size(); ++l) {
        const Vec3 normal = (r[k] - r[j]).cross(r[l] - r[j]);
        if (normal.norm() > flat_hull * size * size) add_side(r, r[j], normal, size, cell);
      }
    }
  }
}

PointCell moments(const std::vector<HullSide>& cell, const std::vector<Vec3>& directions, int dimension) {
  PointCell sum;
  for (const Vec3& n : directions) {
    double reach = std::numeric_limits<double>::infinity();
    for (const HullSide& side : cell) {
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
  std::vector<HullSide> cell;
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
