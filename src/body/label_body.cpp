// SPDX-License-Identifier: MIT
//
// Bodies of several regions: a labelled image is filled, and its cells are given to regions.
#include <phymul/labels.h>
#include <phymul/surface.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <tuple>

#include "base/decimal.h"
#include "filling.h"
#include "label_field.h"
#include "model/cell_geometry.h"
#include "model/group.h"
#include "stuffing.h"

namespace phymul {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr Angles good_angles{15.0 * degree, 155.0 * degree};

// In edges of the lattice there, of the corners of a cell over the faces opposite them: lower cells shorten the stable
// step.
constexpr double good_height = 0.15;

// A particle of the surface moves by this share of an edge at most: further ones would leave the surface where it
// bends.
constexpr double most_along_surface = 0.35;

using Edge = std::array<Index, 2>;

/// Of a tetrahedron, m; negative if it is inside out.
double least_height(const std::array<Vec3, 4>& corner) {
  double most = 0.0;  // twice the largest face
  for (int k = 0; k < 4; ++k) {
    const Vec3 &a = corner[(k + 1) % 4], &b = corner[(k + 2) % 4], &c = corner[(k + 3) % 4];
    most = std::max(most, (b - a).cross(c - a).norm());
  }
  return (corner[1] - corner[0]).cross(corner[2] - corner[0]).dot(corner[3] - corner[0]) / most;
}

class Meeting {
 public:
  Meeting(Stuffing& body, const LabelField& field, double edge) : body_(body), field_(field), edge_(edge) {
    region_.reserve(body.place.size());
    for (const Vec3& x : body.place) region_.push_back(region_at(x));
    moved_.assign(body.place.size(), 0);
    find_mixed_edges();
    if (edges_.empty()) return;
    sort_cells();
    find_crossings();
    for (const Move& move : moves_) try_move(move);
    // What spoils a cell may be good after others were cut.
    for (int sweep = 0; sweep < 2; ++sweep) {
      for (const Crossing& crossing : crossings_) try_cut(crossing);
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

  /// Where an edge meets the boundary.
  struct Crossing {
    double off_middle;  // 0 ... 0.5, as a share of the edge
    Index edge;         // row of edges_
    Vec3 place;
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
    cells_.resize(body_.place.size());
    for (Index row = 0; row < static_cast<Index>(body_.cells.size()); ++row) {
      for (const Index i : body_.cells[row]) cells_[i].push_back(row);
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

  void find_crossings() {
    for (Index row = 0; row < static_cast<Index>(edges_.size()); ++row) {
      const auto [a, b] = edges_[row];
      const Vec3 &at_a = body_.place[a], &at_b = body_.place[b];
      const double share = way_out(at_a, at_b, region_[a]);
      const Vec3 crossing = at_a + share * (at_b - at_a);
      const int beyond = region_at(at_a + std::min(share + 1e-3, 1.0) * (at_b - at_a));
      const Vec3 normal = normal_at(crossing, region_[a], beyond);
      crossings_.push_back({std::abs(share - 0.5), row, crossing});
      add_move(a, row, crossing, normal);
      add_move(b, row, crossing, normal);
    }
    std::ranges::sort(moves_, {}, [](const Move& m) { return std::tuple(m.distance, m.particle, m.edge); });
    std::ranges::sort(crossings_, {}, [](const Crossing& c) { return std::tuple(c.off_middle, c.edge); });
  }

  /// Of a particle inside to where the normal of the boundary through it meets the boundary, or to the crossing of the
  /// edge if that fails; of one on the surface along an edge of the surface.
  void add_move(Index particle, Index edge, const Vec3& crossing, const Vec3& normal) {
    const Vec3& from = body_.place[particle];
    if (body_.at_surface[particle]) {
      const auto& [a, b] = edges_[edge];
      const bool is_near = (crossing - from).norm() < most_along_surface * (body_.place[a] - body_.place[b]).norm();
      if (!is_near || !is_on_surface(edges_[edge], cells_around(edges_[edge]))) return;
      moves_.push_back({(crossing - from).norm(), particle, edge, crossing});
      return;
    }
    const Vec3 beyond = from + 1.5 * (crossing - from).dot(normal) * normal;
    Vec3 target = crossing;
    if (region_at(beyond) != region_[particle]) {
      const Vec3 nearest = from + way_out(from, beyond, region_[particle]) * (beyond - from);
      if ((nearest - from).norm() < (crossing - from).norm()) target = nearest;
    }
    moves_.push_back({(target - from).norm(), particle, edge, target});
  }

  bool is_open(Index edge) const { return !moved_[edges_[edge][0]] && !moved_[edges_[edge][1]]; }

  /// m, of the lattice where a cell is.
  double edge_at(const Tetrahedron& cell) const {
    if (body_.leaf_edge.empty()) return edge_;
    double least = 1.0;
    for (const Index i : cell) least = std::min(least, body_.leaf_edge[i]);
    return least * edge_;
  }

  bool is_sound(const std::array<Vec3, 4>& corner, const Angles& before, double edge) const {
    if (!(least_height(corner) > good_height * edge)) return false;
    const Angles now = dihedral_angles(corner);
    return now.smallest >= std::min(before.smallest, good_angles.smallest) &&
           now.largest <= std::max(before.largest, good_angles.largest);
  }

  void try_move(const Move& move) {
    if (!is_open(move.edge)) return;
    for (const Index row : cells_[move.particle]) {
      const Tetrahedron& cell = body_.cells[row];
      std::array<Vec3, 4> corner = corners_of(cell, body_.place);
      const Angles before = dihedral_angles(corner);
      corner[std::ranges::find(cell, move.particle) - cell.begin()] = move.target;
      if (!is_sound(corner, before, edge_at(cell))) return;
    }
    body_.place[move.particle] = move.target;
    moved_[move.particle] = 1;
  }

  /// Cells with both particles.
  std::vector<Index> cells_around(const Edge& edge) const {
    std::vector<Index> around;
    for (const Index row : cells_[edge[0]]) {
      if (std::ranges::find(body_.cells[row], edge[1]) != body_.cells[row].end()) around.push_back(row);
    }
    return around;
  }

  /// Around an edge inside the body the cells close a ring, in which two of them share each other particle.
  bool is_on_surface(const Edge& edge, const std::vector<Index>& around) const {
    if (!body_.at_surface[edge[0]] || !body_.at_surface[edge[1]]) return false;
    std::vector<Index> beside;
    for (const Index row : around) {
      std::ranges::copy_if(body_.cells[row], std::back_inserter(beside),
                           [&](Index i) { return i != edge[0] && i != edge[1]; });
    }
    return std::ranges::any_of(beside, [&](Index i) { return std::ranges::count(beside, i) == 1; });
  }

  /// Puts a particle there, and cuts each cell around the edge in two.
  void try_cut(const Crossing& crossing) {
    if (!is_open(crossing.edge)) return;
    const Edge edge = edges_[crossing.edge];
    const std::vector<Index> around = cells_around(edge);
    if (around.empty()) return;  // cut before
    for (const Index row : around) {
      const Tetrahedron& cell = body_.cells[row];
      const std::array<Vec3, 4> before = corners_of(cell, body_.place);
      for (const Index end : edge) {
        std::array<Vec3, 4> corner = before;
        corner[std::ranges::find(cell, end) - cell.begin()] = crossing.place;
        if (!is_sound(corner, dihedral_angles(before), edge_at(cell))) return;
      }
    }
    const auto middle = static_cast<Index>(body_.place.size());
    body_.place.push_back(crossing.place);
    body_.at_surface.push_back(is_on_surface(edge, around));
    if (!body_.leaf_edge.empty()) {
      body_.leaf_edge.push_back(std::min(body_.leaf_edge[edge[0]], body_.leaf_edge[edge[1]]));
    }
    moved_.push_back(1);
    cells_.emplace_back();
    for (const Index row : around) cut_cell(row, edge[0], edge[1], middle);
  }

  /// The cell keeps a; another one gets b.
  void cut_cell(Index row, Index a, Index b, Index middle) {
    const auto other = static_cast<Index>(body_.cells.size());
    body_.cells.push_back(body_.cells[row]);
    std::ranges::replace(body_.cells[row], b, middle);
    std::ranges::replace(body_.cells[other], a, middle);
    std::erase(cells_[b], row);
    for (const Index i : body_.cells[other]) cells_[i].push_back(other);
    cells_[middle].push_back(row);
  }

  Stuffing& body_;
  const LabelField& field_;
  double edge_;                            // m, of the lattice where it is coarsest
  std::vector<int> region_;                // [particles] before any moved
  std::vector<char> moved_;                // [particles] 1: on a boundary
  std::vector<Edge> edges_;                // that join two regions
  std::vector<std::vector<Index>> cells_;  // [particles] rows of the body's cells
  std::vector<Move> moves_;                // the shortest first
  std::vector<Crossing> crossings_;        // those in the middle of their edge first
};

/// Where an edge of a cell joins two regions, the end that is nearer to their boundary moves onto it, the nearest ones
/// first. Particles on the body's surface move along its edges. Edges of which no end moved are cut at the boundary, by
/// a new particle. What would spoil the angles of a cell, or make it lower than a share of the lattice's edge there, is
/// left out: such edges still cross the boundary. `edge`: m, of the lattice, where it is coarsest.
void meet_interfaces(Stuffing& body, const LabelField& field, double edge) {
  Meeting(body, field, edge);
}

/// [cells] of the region with the largest share at the cell's centre.
std::vector<int> regions_of_cells(const Model& model, const LabelField& field) {
  std::vector<int> regions;
  regions.reserve(model.cells.size());
  int last = 0;  // where no voxel of a region is near, at a body's point, that of the cell before
  for (const Cell& cell : model.cells) {
    const int own = field.shares(cell_centre(cell, model.rest)).largest();
    if (own >= 0) last = own;
    regions.push_back(last);
  }
  return regions;
}

/// Makes the groups, and says what became of each region.
std::vector<RegionReport> add_regions(Model& model, const LabelField& field, double spacing) {
  const std::vector<int> region = regions_of_cells(model, field);
  std::vector<std::vector<Index>> cells(field.names().size());
  for (std::size_t row = 0; row < region.size(); ++row) cells[region[row]].push_back(static_cast<Index>(row));
  std::vector<RegionReport> reports;
  for (std::size_t r = 0; r < cells.size(); ++r) {
    RegionReport& report = reports.emplace_back();
    report.name = field.names()[r];
    report.wanted_volume = field.volumes()[r];
    report.cells = static_cast<Index>(cells[r].size());
    if (cells[r].empty()) {
      model.notes.push_back("make_body: region \"" + report.name + "\" of " + length_text(1e6 * report.wanted_volume) +
                            " ml has no cell and no group: it is thinner than the spacing of " + length_text(spacing) +
                            " m; take a smaller one");
      continue;
    }
    for (const Index row : cells[r]) report.volume += cell_volume(model, model.cells[row]);
    if (model.has_group(report.name)) {
      refuse_body("expected another name than \"" + report.name + "\" for a region: every body has a group of it");
    }
    add_cell_group(model, report.name, std::move(cells[r]));
    report.particles = static_cast<Index>(model.group(report.name).size());
  }
  return reports;
}

/// Calls see(centre) for the voxels of the regions.
void each_voxel(const LabelImage& image, const std::vector<LabelRegion>& regions, const Contains& see) {
  const auto [ni, nj, nk] = image.size;
  for (std::size_t row = 0; row < image.label.size(); ++row) {
    const std::uint16_t own = image.label[row];
    if (regions.empty() ? own == 0 : std::ranges::count(regions, own, &LabelRegion::label) == 0) continue;
    const std::size_t line = row / ni;
    const Vec3 at(static_cast<double>(row % ni), static_cast<double>(line % nj), static_cast<double>(line / nj));
    see(image.origin + at.x() * image.step[0] + at.y() * image.step[1] + at.z() * image.step[2]);
  }
}

}  // namespace

Model make_body(const LabelImage& image, const LabelBodyOptions& options, BodyReport* report) {
  const LabelField field(image, options.regions);
  const BodyOptions filling{options.spacing, options.most_volume_error, options.most_particles, options.spacing_at};
  const CentredLattice lattice = lattice_over(field.low(), field.high(), filling);
  double wanted_volume = 0.0;
  for (const double volume : field.volumes()) wanted_volume += volume;
  BodyReport own;
  Model model = filled_body(
      LabelInterior(field), lattice, [&](bool) { return wanted_volume; }, filling, own,
      [&](Stuffing& body) { meet_interfaces(body, field, lattice.edge); });
  require_volume(own, filling, [&] {
    return lost_parts([&](const Contains& see) { each_voxel(image, options.regions, see); },
                      {model.rest, surface_triangles(model), {}}, filling);
  });
  own.regions = add_regions(model, field, options.spacing);
  model.notes.insert(model.notes.begin(), image.notes.begin(), image.notes.end());
  if (report) *report = std::move(own);
  return model;
}

}  // namespace phymul
