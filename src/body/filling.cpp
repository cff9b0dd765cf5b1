// SPDX-License-Identifier: MIT
#include "filling.h"

#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/decimal.h"
#include "base/union_find.h"
#include "graded_lattice.h"
#include "model/closed_surface.h"
#include "model/shape_builder.h"

namespace phymul {
namespace {

constexpr double most_moved = 0.05;  // spacings, of the surface to meet the volume
/// Spacing over the largest coordinate: below it the lattice's points are no longer evenly apart.
constexpr double least_share = 1e-9;

/// Degrees, smallest and largest.
void measure_angles(const Stuffing& body, BodyReport& report) {
  Angles all;
  for (const Tetrahedron& cell : body.cells) {
    const Angles own = dihedral_angles(corners_of(cell, body.place));
    all = {std::min(all.smallest, own.smallest), std::max(all.largest, own.largest)};
  }
  report.smallest_angle = all.smallest * 180.0 / std::numbers::pi;
  report.largest_angle = all.largest * 180.0 / std::numbers::pi;
}

int count_parts(const Stuffing& body) {
  UnionFind sets(body.place.size());
  auto parts = static_cast<int>(body.place.size());
  for (const Tetrahedron& cell : body.cells) {
    for (int k = 1; k < 4; ++k) parts -= sets.join(cell[0], cell[k]) ? 1 : 0;
  }
  return parts;
}

/// Faces that one cell has, counter-clockwise seen from outside.
std::vector<std::array<Index, 3>> outer_faces(const Stuffing& body) {
  struct Face {
    std::array<Index, 3> sorted, wound;
  };
  std::vector<Face> faces;
  faces.reserve(4 * body.cells.size());
  for (const auto& [a, b, c, d] : body.cells) {
    for (const std::array<Index, 3>& wound : {std::array{a, c, b}, {a, b, d}, {b, c, d}, {a, d, c}}) {
      const auto [low, high] = std::minmax({wound[0], wound[1], wound[2]});
      faces.push_back({{low, wound[0] + wound[1] + wound[2] - low - high, high}, wound});
    }
  }
  std::ranges::sort(faces, {}, &Face::sorted);
  std::vector<std::array<Index, 3>> outer;
  for (std::size_t from = 0, to = 0; from < faces.size(); from = to) {
    for (to = from + 1; to < faces.size() && faces[to].sorted == faces[from].sorted;) ++to;
    if (to - from == 1) outer.push_back(faces[from].wound);
  }
  return outer;
}

/// Moves the surface along its normals by one length times the square of the local spacing as a share of the coarsest:
/// that is how much flat triangles cut off. `most`, m: of the length if the surface has the coarsest spacing somewhere,
/// else as much of the spacing there is. Returns the way of the particles that move most, m.
double meet_volume(Stuffing& body, const std::vector<std::array<Index, 3>>& faces, double wanted, double most) {
  VecList along(body.place.size());
  volume_gradient(faces, body.place, along);
  for (Vec3& normal : along) normal.normalize();
  double most_along = body.leaf_edge.empty() ? 1.0 : 0.0;
  for (std::size_t i = 0; i < body.leaf_edge.size(); ++i) {
    along[i] *= body.leaf_edge[i] * body.leaf_edge[i];
    most_along = std::max(most_along, along[i].norm());
  }
  const auto root = root_of_cubic(volume_along(faces, body.place, along), wanted - enclosed_volume(faces, body.place));
  most /= std::sqrt(most_along);
  const double length = std::clamp(root.value_or(0.0), -most, most);
  for (std::size_t i = 0; i < along.size(); ++i) body.place[i] += length * along[i];
  return most_along * length;
}

BodyReport report_of(const Stuffing& body, double wanted_volume) {
  BodyReport report;
  report.particles = static_cast<Index>(body.place.size());
  report.cells = static_cast<Index>(body.cells.size());
  report.wanted_volume = wanted_volume;
  for (const auto& [a, b, c, d] : body.cells) {
    const Vec3& from = body.place[a];
    report.volume += (body.place[d] - from).dot((body.place[b] - from).cross(body.place[c] - from)) / 6.0;
  }
  measure_angles(body, report);
  report.parts = count_parts(body);
  return report;
}

void require_few(const BodyReport& report, const BodyOptions& options) {
  if (report.particles > options.most_particles) {
    refuse_body("a spacing of " + length_text(options.spacing) + " m needs " + std::to_string(report.particles) +
                " particles, more than " + std::to_string(options.most_particles) +
                " (BodyOptions::most_particles); take a larger spacing");
  }
}

Model model_of(Stuffing body, const BodyReport& report) {
  Model model = named_model("body");
  std::vector<Index> at_surface;
  for (std::size_t i = 0; i < body.at_surface.size(); ++i) {
    if (body.at_surface[i]) at_surface.push_back(static_cast<Index>(i));
  }
  model.rest = std::move(body.place);
  model.cells.reserve(body.cells.size());
  for (const auto& [a, b, c, d] : body.cells) add_cell(model, CellType::tetrahedron, {a, b, c, d});
  model.add_group("surface", std::move(at_surface));
  if (report.parts > 1) {
    model.notes.push_back("make_body: the body has " + std::to_string(report.parts) +
                          " parts that no tetrahedron connects");
  }
  return finished(std::move(model));
}

}  // namespace

void refuse_body(const std::string& what) {
  throw Error("make_body: " + what);
}

CentredLattice lattice_over(const Vec3& low, const Vec3& high, const BodyOptions& options) {
  if (!(options.spacing > 0.0) || !std::isfinite(options.spacing)) {
    refuse_body("expected a spacing above 0 m, got " + length_text(options.spacing) +
                "; a tenth of the body is coarse");
  }
  if (!(options.most_volume_error > 0.0)) {
    refuse_body("expected most_volume_error above 0, got " + length_text(options.most_volume_error));
  }
  const double furthest = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  if (!(options.spacing >= least_share * furthest)) {
    refuse_body("expected a shape within " + length_text(1.0 / least_share) + " spacings of " +
                length_text(options.spacing) + " m from the origin, got one that reaches to " + length_text(furthest) +
                " m, where rounding spoils the lattice; move it to the origin");
  }
  CentredLattice lattice;
  lattice.edge = options.spacing / CentredLattice::mean_length;
  const Vec3 cubes = ((high - low) / lattice.edge).array().ceil() + 3.0;
  // An organ fills a third of its box or so; a thin one a twentieth.
  if (!(2.0 * cubes.prod() <= 20.0 * options.most_particles)) {
    const Vec3 sides = high - low;
    refuse_body("a spacing of " + length_text(options.spacing) + " m over a box of " + length_text(sides.x()) + " x " +
                length_text(sides.y()) + " x " + length_text(sides.z()) + " m needs a lattice of " +
                length_text(2.0 * cubes.prod()) + " points, for at most " + std::to_string(options.most_particles) +
                " particles (BodyOptions::most_particles); take a larger spacing, or check the unit of length");
  }
  if (2.0 * cubes.prod() > std::numeric_limits<Index>::max()) {
    refuse_body("a spacing of " + length_text(options.spacing) + " m needs a lattice of " +
                length_text(2.0 * cubes.prod()) + " points, more than " +
                std::to_string(std::numeric_limits<Index>::max()) +
                ", the most that can be counted; take a larger spacing");
  }
  for (int k = 0; k < 3; ++k) lattice.count[k] = static_cast<int>(cubes[k]);
  lattice.origin = 0.5 * (low + high) - 0.5 * lattice.edge * (cubes - Vec3::Constant(0.5));
  return lattice;
}

namespace {

Stuffing filled(const Interior& interior, const CentredLattice& lattice, const BodyOptions& options) {
  if (!options.spacing_at) return stuffed(interior, lattice);
  GradedLattice graded(lattice, options);
  if (graded.is_uniform()) return stuffed(interior, lattice);
  graded.number_points();
  return stuffed(interior, graded);
}

}  // namespace

Model filled_body(const Interior& interior, const CentredLattice& lattice, const WantedVolumeOf& volume_of,
                  const BodyOptions& options, BodyReport& report, const std::function<void(Stuffing&)>& adjust) {
  Stuffing body = filled(interior, lattice, options);
  if (body.cells.empty()) {
    refuse_body("no point of a lattice with a spacing of " + length_text(options.spacing) +
                " m lies inside the shape; take a smaller spacing, or check the unit of length");
  }
  const double wanted_volume = volume_of(!body.leaf_edge.empty());
  if (!(wanted_volume > 0.0)) {
    refuse_body("expected a shape with a volume above 0, got " + length_text(1e6 * wanted_volume) + " ml");
  }
  std::vector<std::array<Index, 3>> faces = outer_faces(body);
  improve_cells(body, faces);
  if (adjust) {
    adjust(body);
    faces = outer_faces(body);
  }
  const double unmoved = enclosed_volume(faces, body.place);
  const double moved = meet_volume(body, faces, wanted_volume, most_moved * options.spacing);
  report = report_of(body, wanted_volume);
  report.unmoved_volume = unmoved;
  report.moved = moved;
  report.smallest_spacing = report.largest_spacing = options.spacing;
  if (!body.leaf_edge.empty()) {
    const auto [least, most] = std::ranges::minmax(body.leaf_edge);
    report.smallest_spacing = least * options.spacing;
    report.largest_spacing = most * options.spacing;
  }
  require_few(report, options);
  return model_of(std::move(body), report);
}

void require_volume(const BodyReport& report, const BodyOptions& options, const std::function<std::string()>& thin) {
  const auto error = [&](double volume) { return volume / report.wanted_volume - 1.0; };
  const auto text = [&](double volume) {
    return length_text(100.0 * std::abs(error(volume))) + " % " + (error(volume) < 0.0 ? "less" : "more");
  };
  if (std::abs(error(report.volume)) <= options.most_volume_error) return;
  std::string cause = "gaps or cavities narrower than that are filled";
  if (error(report.volume) < 0.0) {
    const std::string lost = thin ? thin() : "",
                      edges = "edges and corners, and walls of one or two spacings, are rounded off";
    cause = "parts thinner than the spacing are lost" + (thin ? ": " + lost : ", or " + edges);
    if (thin && lost.empty()) cause = edges;
  }
  refuse_body("the body has " + length_text(1e6 * report.volume) + " ml, " + text(report.volume) + " than the " +
              length_text(1e6 * report.wanted_volume) + " ml asked for (" + text(report.unmoved_volume) +
              " before its surface was moved). With a spacing of " + length_text(options.spacing) + " m " + cause +
              "; take a smaller one, or allow more by BodyOptions::most_volume_error");
}

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
