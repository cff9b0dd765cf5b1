// SPDX-License-Identifier: MIT
//
// Cuts by virtual nodes: a cut cell becomes two cells over the same places, each with its share of the volume, and a
// particle gets a copy for each group of parts around it that the cut leaves connected (N. Molino, Z. Bao, R. Fedkiw,
// "A virtual node algorithm for changing mesh topology during simulation", ACM Trans. Graph. 23 (2004) 385-392; here
// parts count by their share, so that neither mass nor stiffness doubles and the stable step stays).
#include <phymul/body.h>
#include <phymul/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "base/union_find.h"
#include "model/cell_geometry.h"
#include "model/cut_cells.h"

namespace phymul {
namespace {

/// Of the shortest edge at a vertex: the surface passes through a vertex that is nearer. Thinner parts would be whipped
/// about by what they hang on.
constexpr double on_surface = 0.1;
/// Spacings by which the front is ahead of the blade. Cells part as wholes: without it slits are too short by 0.25 to
/// 0.4 spacings.
constexpr double lead = 0.3;
/// Of a particle's mass that a copy has at least, taken from the heaviest one.
constexpr double least_mass = 0.02;

/// Of a part's share: less than this, or more than all but this, is none and all.
constexpr double no_share = 1e-9;
constexpr std::size_t most_cuts = 3;  // through a cell

class BodyCutter {
 public:
  BodyCutter(Model model, const CutSurface& cut) : model_(std::move(model)), cut_(cut) {}

  Model cut() {
    look_at_cells();
    find_sides();
    choose_cells();
    if (parted_.empty()) {
      model_.notes.emplace_back("cut_body: the surface parts no cell; the body is as it was");
      return std::move(model_);
    }
    part_cells();
    std::vector<Index> corners;
    for (const Index row : parted_) {
      corners.insert(corners.end(), before_[row].begin(), before_[row].end());
    }
    std::ranges::sort(corners);
    const auto again = std::ranges::unique(corners);
    corners.erase(again.begin(), again.end());
    for (const Index i : corners) copy_particle(i);
    follow_components();
    model_.neighbours = neighbours_from_cells(model_.cells, model_.particle_count());
    model_.extras = nullptr;
    validate(model_);
    return std::move(model_);
  }
  const std::vector<Index>& copies() const { return copies_; }

 private:
  /// Part of a cell: a row of Model::cells. `side`: of the surface; 0: the cell is whole and not parted from either.
  struct Part {
    Index row = -1;
    int side = 0;
  };

  void look_at_cells() {
    cells_of_.resize(model_.rest.size());
    double volume = 0.0;
    for (Index row = 0; row < static_cast<Index>(model_.cells.size()); ++row) {
      const Cell& cell = model_.cells[row];
      before_.push_back(cell.particles);
      earlier_.push_back(cell.cuts);
      if (!is_solid(model_.dimension, cell)) continue;
      if (cell.type != CellType::tetrahedron) {
        throw Error(ErrorCode::not_supported, "cut_body: expected a body of tetrahedra; " +
                                                  cell_label(model_, static_cast<std::size_t>(row)) + " is none");
      }
      for (const Index i : cell.particles) cells_of_[i].push_back(row);
      volume += signed_measure(model_.dimension, cell, model_.rest);
    }
    if (!(volume > 0.0)) throw Error("cut_body: expected a body of tetrahedra, got none");
    spacing_ = std::cbrt(volume / static_cast<double>(model_.rest.size()));
    particles_ = model_.particle_count();
    parts_.resize(model_.cells.size());
    side_.assign(model_.cells.size(), 0);
    shared_.resize(model_.rest.size());
  }

  void find_sides() {
    std::vector<double> shortest(model_.rest.size(), HUGE_VAL);
    for (const auto& corners : before_) {
      for (const Index i : corners) {
        for (const Index j : corners) {
          if (i != j) shortest[i] = std::min(shortest[i], (model_.rest[i] - model_.rest[j]).norm());
        }
      }
    }
    for (Index i = 0; i < particles_; ++i) {
      const double distance = cut_.distance(model_.rest[i]);
      if (!std::isfinite(distance)) throw Error("cut_body: expected finite distances to the surface");
      distance_.push_back(std::abs(distance) < on_surface * shortest[i] ? 0.0 : distance);
    }
  }

  /// Cells that the surface crosses behind the front are parted; those that only lie on it with a face are of its side.
  void choose_cells() {
    for (Index row = 0; row < static_cast<Index>(before_.size()); ++row) {
      if (!is_solid(model_.dimension, model_.cells[row])) continue;
      const std::vector<Index>& corner = before_[row];
      int above = 0, below = 0;
      Vec3 middle = Vec3::Zero();  // of the section
      int points = 0;
      for (std::size_t a = 0; a < 4; ++a) {
        const double at_a = distance_[corner[a]];
        above += at_a > 0.0 ? 1 : 0;
        below += at_a < 0.0 ? 1 : 0;
        if (at_a == 0.0) {
          middle += model_.rest[corner[a]];
          ++points;
        }
        for (std::size_t b = 0; b < a; ++b) {
          const double at_b = distance_[corner[b]];
          if (at_a * at_b >= 0.0) continue;
          middle += model_.rest[corner[a]] + at_a / (at_a - at_b) * (model_.rest[corner[b]] - model_.rest[corner[a]]);
          ++points;
        }
      }
      const bool crosses = above > 0 && below > 0, lies_on = above + below == 1;
      if (!crosses && !lies_on) continue;
      if (cut_.front && !(cut_.front(middle / points) < lead * spacing_)) continue;
      if (lies_on) {
        side_[row] = above > 0 ? 1 : -1;
        continue;
      }
      // What earlier cuts left of it may lie on one side.
      std::vector<CellCut> cuts = model_.cells[row].cuts;
      const double whole = tissue_share(cuts);
      cuts.push_back(cut_of(row));
      const double share = tissue_share(cuts) / whole;
      if (share < no_share || share > 1.0 - no_share) {
        side_[row] = share > 0.5 ? 1 : -1;
        continue;
      }
      if (cuts.size() > most_cuts) {
        throw Error(ErrorCode::not_supported,
                    "cut_body: " + cell_label(model_, static_cast<std::size_t>(row)) +
                        " would be cut a fourth time; expected at most three cuts through one");
      }
      share_above_.emplace_back(row, share);
    }
    for (const auto& [row, share] : share_above_) parted_.push_back(row);
    // A cell of a side alone parts nothing: it needs its neighbour's corners to be looked at.
    for (Index row = 0; row < static_cast<Index>(side_.size()); ++row) {
      if (side_[row] != 0) parted_.push_back(row);
    }
    std::ranges::sort(parted_);
  }

  CellCut cut_of(Index row) const {
    CellCut cut{};
    for (std::size_t v = 0; v < 4; ++v) cut[v] = distance_[before_[row][v]];
    return cut;
  }

  void part_cells() {
    for (Index row = 0; row < static_cast<Index>(before_.size()); ++row) parts_[row] = {{row, side_[row]}};
    for (const auto& [row, share] : share_above_) {
      CellCut cut = cut_of(row);
      Cell other = model_.cells[row];
      model_.cells[row].share *= share;
      model_.cells[row].cuts.push_back(cut);
      for (double& value : cut) value = -value;
      other.share *= 1.0 - share;
      other.cuts.push_back(cut);
      const auto added = static_cast<Index>(model_.cells.size());
      model_.cells.push_back(std::move(other));
      parts_[row] = {{row, 1}, {added, -1}};
      part_of_.emplace_back(row, added);
    }
  }

  /// Whether two parts are one body across the face that their cells share, if they do.
  bool meet(Index cell_a, const Part& a, Index cell_b, const Part& b) const {
    if (a.side * b.side < 0) return false;
    std::array<Index, 3> face{};
    std::size_t common = 0;
    for (const Index i : before_[cell_a]) {
      if (std::ranges::find(before_[cell_b], i) == before_[cell_b].end()) continue;
      if (common < 3) face[common] = i;
      ++common;
    }
    if (common != 3) return false;
    cuts_of_face_.clear();
    if (const int side = a.side != 0 ? a.side : b.side; side != 0) {
      cuts_of_face_.push_back({side * distance_[face[0]], side * distance_[face[1]], side * distance_[face[2]]});
    }
    for (const Index row : {cell_a, cell_b}) add_cuts_of_face(before_[row], earlier_[row], face, cuts_of_face_);
    return has_tissue(cuts_of_face_);
  }

  /// One copy of a particle for each group of parts around it; the group that the particle itself lies in keeps it.
  void copy_particle(Index particle) {
    std::vector<std::pair<Index, Part>> around;  // cell, part
    for (const Index row : cells_of_[particle]) {
      for (const Part& part : parts_[row]) around.emplace_back(row, part);
    }
    UnionFind groups(around.size());
    for (std::size_t a = 0; a < around.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        const auto& [cell_a, part_a] = around[a];
        const auto& [cell_b, part_b] = around[b];
        if (cell_a != cell_b && meet(cell_a, part_a, cell_b, part_b)) {
          groups.join(static_cast<Index>(a), static_cast<Index>(b));
        }
      }
    }
    struct Group {
      Index root;
      double mass = 0.0;  // kg, of its parts' shares
      bool own = false;   // the particle lies in it
    };
    std::vector<Group> found;
    const double distance = distance_[particle];
    for (std::size_t a = 0; a < around.size(); ++a) {
      const Index root = groups.root(static_cast<Index>(a));
      auto group = std::ranges::find(found, root, &Group::root);
      if (group == found.end()) group = found.insert(group, {root});
      const Part& part = around[a].second;
      const Cell& cell = model_.cells[part.row];
      group->mass += (cell.material < 0 ? 1.0 : model_.materials[cell.material].density) * cell.share *
                     signed_volume(cell.type, before_[around[a].first], model_.rest);
      group->own = group->own || part.side * distance > 0.0 || (part.side == 0 && distance != 0.0);
    }
    if (found.size() < 2) return;
    std::ranges::stable_sort(found, std::greater(),
                             [](const Group& group) { return std::pair(group.own, group.mass); });
    double whole = 0.0;
    for (const Group& group : found) whole += group.mass;
    const double mass = model_.mass[particle], stiffness = model_.stiffness[particle];
    std::vector<Index> copies;
    for (std::size_t k = 0; k < found.size(); ++k) {
      const Index copy = k == 0 ? particle : model_.particle_count();
      if (k > 0) {
        copies_.push_back(particle);
        model_.rest.push_back(Vec3(model_.rest[particle]));
        model_.mass.push_back(0.0);
        model_.stiffness.push_back(stiffness);
        model_.neighbours.push_row(&particle, &particle);
        // Where the surface passes through it, it lies on both sides, and its copies belong to what it belongs to.
        if (distance == 0.0) shared_[particle].push_back(copy);
      }
      model_.mass[copy] = mass * std::max(found[k].mass / whole, least_mass);
      copies.push_back(copy);
      for (std::size_t a = 0; a < around.size(); ++a) {
        if (groups.root(static_cast<Index>(a)) != found[k].root) continue;
        const auto v = std::ranges::find(before_[around[a].first], particle) - before_[around[a].first].begin();
        model_.cells[around[a].second.row].particles[static_cast<std::size_t>(v)] = copy;
      }
    }
    double sum = 0.0;
    for (const Index copy : copies) sum += model_.mass[copy];
    const Index heaviest = *std::ranges::max_element(copies, {}, [&](Index copy) { return model_.mass[copy]; });
    model_.mass[heaviest] += mass - sum;
  }

  void follow_components() {
    std::vector<Index> other_part(before_.size(), -1);
    for (const auto& [row, other] : part_of_) other_part[row] = other;
    for (Component& component : model_.components) {
      std::vector<Index> added;
      for (const std::vector<Index>* rows : {&component.cells, &component.cell_refs}) {
        for (const Index row : *rows) {
          if (other_part[row] >= 0) added.push_back(other_part[row]);
        }
      }
      component.cell_refs.insert(component.cell_refs.end(), added.begin(), added.end());
      std::vector<Index> copies;
      for (const Index i : component.particles) {
        copies.insert(copies.end(), shared_[i].begin(), shared_[i].end());
      }
      component.particles.insert(component.particles.end(), copies.begin(), copies.end());
    }
  }

  Model model_;
  const CutSurface& cut_;
  Index particles_ = 0;                                // before the cut
  double spacing_ = 0.0;                               // m
  std::vector<std::vector<Index>> before_;             // [cells] particles before the cut
  std::vector<std::vector<CellCut>> earlier_;          // [cells] cuts before this one
  mutable std::vector<FaceCut> cuts_of_face_;          // of the face at hand
  std::vector<std::pair<Index, double>> share_above_;  // of the parted cells, ascending: of what they had
  std::vector<std::vector<Index>> cells_of_;           // [particles]
  std::vector<double> distance_;                       // [particles] m
  std::vector<int> side_;                              // [cells] of those with a face on the surface
  std::vector<Index> parted_;                          // cells, ascending
  std::vector<std::vector<Part>> parts_;               // [cells]
  std::vector<std::pair<Index, Index>> part_of_;       // rows of parted cells, and of their second parts
  std::vector<Index> copies_;                          // of which particle, each
  std::vector<std::vector<Index>> shared_;             // [particles] copies that lie on the surface as they do
};

}  // namespace

Model cut_body(Model model, const CutSurface& cut, std::vector<Index>* copies) {
  validate(model);
  if (!cut.distance) throw Error("cut_body: expected CutSurface::distance");
  BodyCutter cutter(std::move(model), cut);
  Model made = cutter.cut();
  if (copies) *copies = cutter.copies();
  return made;
}

CutSurface cut_plane(const Vec3& point, const Vec3& normal) {
  const double length = normal.norm();
  if (!(length > 0.0) || !std::isfinite(length) || !point.allFinite()) {
    throw Error("cut_plane: expected a finite point and a normal that is not zero");
  }
  const Vec3 unit = normal / length;
  return {.distance = [point, unit](const Vec3& x) { return unit.dot(x - point); }, .front = {}};
}

}  // namespace phymul
