// SPDX-License-Identifier: MIT
#include "cell_cutter.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <utility>

#include "base/union_find.h"
#include "cell_geometry.h"
#include "cut_cells.h"

namespace phymul {
namespace {

/// Of a particle's mass that a copy has at least, taken from the heaviest one.
constexpr double least_mass = 0.02;
BodyCut::Part part_of(const Cell& cell) {
  BodyCut::Part part{{-1, -1, -1, -1}, cell.share, cell.cuts};
  std::ranges::copy(cell.particles, part.particles.begin());
  return part;
}

class CellCutter {
 public:
  CellCutter(const CutBody& body, const CutCells& cut) : body_(body), cut_(cut) {}

  BodyCut run() {
    for (const Index row : cut_.cells) consider(row);
    std::vector<Index> corners;
    for (const Piece& piece : pieces_) {
      std::ranges::copy_if(piece.before, std::back_inserter(corners), [](Index i) { return i >= 0; });
    }
    std::ranges::sort(corners);
    const auto again = std::ranges::unique(corners);
    corners.erase(again.begin(), again.end());
    for (const Index i : corners) copy_particle(i);
    if (!result_.copies.empty()) move_clamps();
    for (Piece& piece : pieces_) {
      if (piece.is_added) {
        result_.added.push_back({piece.row, std::move(piece.now)});
        continue;
      }
      BodyCut::Part before = part_of(body_.model.cells[piece.row]);
      if (piece.now != before) result_.changed.push_back({piece.row, std::move(before), std::move(piece.now)});
    }
    std::ranges::sort(result_.changed, {}, &BodyCut::Change::row);
    return std::move(result_);
  }

 private:
  /// A cell, or one of the two parts of one.
  struct Piece {
    Index row = -1;
    bool is_added = false;                        // the second part
    std::array<Index, 4> before{-1, -1, -1, -1};  // of a triangle the first three
    BodyCut::Part now{};
    double corner_mass = 0.0;  // kg
  };
  /// A face of a tetrahedron; an edge of one beside a wall; a triangle of a wall, or one of its edges.
  struct Face {
    std::array<Index, 2> others;  // particles besides the one at hand, ascending; -1 first: of an edge
    std::size_t piece;
  };

  bool is_wall_row(Index row) const { return is_of_wall(body_.model, body_.model.cells[row]); }

  /// What cannot be cut is refused.
  bool can_cut(Index row) const {
    const Cell& cell = body_.model.cells[row];
    if (cell.share == 0.0 || cell.type == CellType::tetrahedron || is_wall_row(row)) return true;
    if (cut_.refused != nullptr) {
      ++*cut_.refused;
      return false;
    }
    throw Error(ErrorCode::not_supported, std::string(cut_.who) + ": expected a body of tetrahedra or walls; " +
                                              cell_label(body_.model, static_cast<std::size_t>(row)) + " is neither");
  }

  void add_piece(Index row, bool is_added, BodyCut::Part now) {
    const Cell& cell = body_.model.cells[row];
    Piece& piece = pieces_.emplace_back();
    piece.row = row;
    piece.is_added = is_added;
    std::ranges::copy(cell.particles, piece.before.begin());
    piece.corner_mass = body_.mass_of_corner(row) * now.share / cell.share;
    piece.now = std::move(now);
    if (!is_added) piece_of_[row] = pieces_.size() - 1;
  }

  /// A cell that the surface crosses behind the front is parted; one that lies on it with a side keeps that in mind.
  void consider(Index row) {
    if (!can_cut(row)) return;
    const Cell& cell = body_.model.cells[row];
    const std::size_t corners = cell.particles.size();
    CellCut cut{};
    for (std::size_t a = 0; a < corners; ++a) {
      cut[a] = cut_.distance(cell.particles[a]);
      if (!std::isfinite(cut[a])) throw Error(std::string(cut_.who) + ": expected finite distances to the surface");
    }
    const auto middle = middle_of_section(cut, corners);
    if (!middle || !cut_.passed(row, *middle)) return;
    // Particles are copied for all cells around them.
    for (const Index i : cell.particles) {
      for (const Index other : body_.cells_of[i]) {
        if (!can_cut(other)) return;
      }
    }
    BodyCut::Part first = part_of(cell);
    CellCut other_way{};
    for (std::size_t a = 0; a < corners; ++a) other_way[a] = -cut[a];
    const bool lies_on = !divides(cut);
    const CellCut& own_way = lies_on && std::ranges::min(cut) < 0.0 ? other_way : cut;
    if (std::ranges::find(first.cuts, own_way) != first.cuts.end()) return;
    // What earlier cuts left of it may lie on one side.
    const double whole = tissue_share(first.cuts, corners);
    first.cuts.push_back(own_way);
    if (lies_on) {
      add_piece(row, false, std::move(first));
      return;
    }
    const double share = tissue_share(first.cuts, corners) / whole;
    if (share < no_share || share > 1.0 - no_share) return;
    if (std::ranges::count_if(first.cuts, divides) > static_cast<std::ptrdiff_t>(most_cuts_of_cell)) {
      if (cut_.refused != nullptr) {
        ++*cut_.refused;
        return;
      }
      throw Error(ErrorCode::not_supported, std::string(cut_.who) + ": " +
                                                cell_label(body_.model, static_cast<std::size_t>(row)) +
                                                " would be cut a fourth time; expected at most three cuts through one");
    }
    BodyCut::Part second = first;
    second.cuts.back() = other_way;
    first.share *= share;
    second.share *= 1.0 - share;
    add_piece(row, false, std::move(first));
    add_piece(row, true, std::move(second));
  }

  /// Pieces around the particle, and their faces at it.
  void look_around(Index particle) {
    around_.clear();
    faces_.clear();
    removed_mass_ = 0.0;
    bool has_wall = false;
    for (const Index row : body_.cells_of[particle]) {
      if (body_.model.cells[row].share == 0.0) {
        removed_mass_ += body_.mass_of_corner(row);
        continue;
      }
      if (!piece_of_.contains(row)) add_piece(row, false, part_of(body_.model.cells[row]));
      has_wall = has_wall || is_wall_row(row);
      const std::size_t first = piece_of_.at(row);
      around_.push_back(first);
      const bool parted = first + 1 < pieces_.size() && pieces_[first + 1].is_added;
      if (parted) around_.push_back(first + 1);
    }
    for (std::size_t k = 0; k < around_.size(); ++k) {
      std::array<Index, 3> others{};  // -1 first: of a triangle
      std::size_t count = 0;
      for (const Index i : pieces_[around_[k]].before) {
        if (i != particle) others[count++] = i;
      }
      std::ranges::sort(others);
      faces_.push_back({{others[0], others[1]}, k});
      faces_.push_back({{others[0], others[2]}, k});
      faces_.push_back({{others[1], others[2]}, k});
      if (!has_wall || others[0] < 0) continue;
      for (const Index other : others) faces_.push_back({{-1, other}, k});
    }
    std::ranges::sort(faces_, {}, [](const Face& face) { return std::pair(face.others, face.piece); });
  }

  /// Whether two pieces of different cells are one body across the face, or the edge, that these have in common.
  /// Tetrahedra have edges in common with walls alone.
  bool meet(const Piece& a, const Piece& b, const std::array<Index, 3>& face) {
    if (face[1] < 0 && !is_wall_row(a.row) && !is_wall_row(b.row)) return false;
    if (a.now.cuts.empty() && b.now.cuts.empty()) return true;
    if (face[1] < 0) {
      // A tetrahedron that only has an edge in common with a cut does not know of it.
      const auto along_edge = [&](const Piece& piece) {
        const std::size_t first = corner_of(piece, face[0]), last = corner_of(piece, face[2]);
        return std::ranges::any_of(piece.now.cuts,
                                   [&](const CellCut& cut) { return cut[first] == 0.0 && cut[last] == 0.0; });
      };
      if (is_wall_row(a.row) != is_wall_row(b.row) && (along_edge(a) || along_edge(b))) return false;
      return tissue_in_common(a.before, a.now.cuts, b.before, b.now.cuts, {face[0], face[2]}) > no_share;
    }
    cuts_of_face_.clear();
    add_cuts_of_face(a.before, a.now.cuts, face, cuts_of_face_);
    add_cuts_of_face(b.before, b.now.cuts, face, cuts_of_face_);
    const auto vanishes = [](const FaceCut& cut) { return cut[0] == 0.0 && cut[1] == 0.0 && cut[2] == 0.0; };
    const auto of_b = cuts_of_face_.begin() + static_cast<std::ptrdiff_t>(a.now.cuts.size());
    // The cells lie on both sides of their face, and so of a cut along it.
    if (std::any_of(cuts_of_face_.begin(), of_b, vanishes) && std::any_of(of_b, cuts_of_face_.end(), vanishes)) {
      return false;
    }
    return has_tissue(cuts_of_face_);
  }

  /// One copy of a particle for each group of pieces around it; the group that it lies in keeps it.
  void copy_particle(Index particle) {
    look_around(particle);
    UnionFind groups(around_.size());
    for (std::size_t a = 0; a < faces_.size(); ++a) {
      for (std::size_t b = a + 1; b < faces_.size() && faces_[b].others == faces_[a].others; ++b) {
        const auto i = static_cast<Index>(faces_[a].piece), j = static_cast<Index>(faces_[b].piece);
        const Piece &piece = pieces_[around_[i]], &other = pieces_[around_[j]];
        if (piece.row == other.row || groups.root(i) == groups.root(j)) continue;
        if (meet(piece, other, {particle, faces_[a].others[0], faces_[a].others[1]})) groups.join(i, j);
      }
    }
    struct Group {
      Index root;
      double mass = 0.0;  // kg, of its pieces
      bool own = false;   // the particle lies in it
    };
    std::vector<Group> found;
    for (std::size_t k = 0; k < around_.size(); ++k) {
      const Index root = groups.root(static_cast<Index>(k));
      auto group = std::ranges::find(found, root, &Group::root);
      if (group == found.end()) group = found.insert(group, {root});
      const Piece& piece = pieces_[around_[k]];
      const std::size_t corner = corner_of(piece, particle);
      group->mass += piece.corner_mass;
      group->own =
          group->own || std::ranges::all_of(piece.now.cuts, [&](const CellCut& cut) { return cut[corner] > 0.0; });
    }
    if (found.size() < 2) return;
    std::ranges::stable_sort(found, std::greater(),
                             [](const Group& group) { return std::pair(group.own, group.mass); });
    found.front().mass += removed_mass_;  // removed cells stay with the particle's own number
    const double mass = body_.mass[particle];
    double whole = 0.0, sum = 0.0;
    for (const Group& group : found) whole += group.mass;
    const auto first_mass = static_cast<std::ptrdiff_t>(result_.masses.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      const Index copy = k == 0 ? particle : body_.spare(result_.copies.size());
      result_.masses.push_back({copy, k == 0 ? mass : 0.0, mass * std::max(found[k].mass / whole, least_mass)});
      sum += result_.masses.back().after;
      if (k == 0) continue;
      result_.copies.push_back({copy, particle, cut_.distance(particle) == 0.0});
      for (std::size_t p = 0; p < around_.size(); ++p) {
        if (groups.root(static_cast<Index>(p)) != found[k].root) continue;
        Piece& piece = pieces_[around_[p]];
        piece.now.particles[corner_of(piece, particle)] = copy;
      }
    }
    const auto heaviest =
        std::max_element(result_.masses.begin() + first_mass, result_.masses.end(),
                         [](const BodyCut::Mass& a, const BodyCut::Mass& b) { return a.after < b.after; });
    heaviest->after += mass - sum;
  }

  /// Clamped edges stay with the part of a wall that has the whole of them.
  void move_clamps() {
    for (Index row = 0; row < static_cast<Index>(body_.model.cells.size()); ++row) {
      const Cell& cell = body_.model.cells[row];
      if (cell.type != CellType::line || cell.material < 0) continue;
      const std::array<Index, 2> edge{cell.particles[0], cell.particles[1]};
      for (const Piece& piece : pieces_) {
        const auto has = [&](Index i) { return corner_of(piece, i) < piece.before.size(); };
        if (!is_wall_row(piece.row) || !std::ranges::all_of(edge, has)) continue;
        if (tissue_in_common(piece.before, piece.now.cuts, piece.before, {}, edge) < 1.0) continue;
        BodyCut::Part before = part_of(cell), after = before;
        for (std::size_t k = 0; k < edge.size(); ++k)
          after.particles[k] = piece.now.particles[corner_of(piece, edge[k])];
        if (after != before) result_.changed.push_back({row, std::move(before), std::move(after)});
        break;
      }
    }
  }

  static std::size_t corner_of(const Piece& piece, Index particle) {
    return static_cast<std::size_t>(std::ranges::find(piece.before, particle) - piece.before.begin());
  }

  const CutBody& body_;
  const CutCells& cut_;
  BodyCut result_;
  std::vector<Piece> pieces_;                        // a second part follows its first
  std::unordered_map<Index, std::size_t> piece_of_;  // by row: of pieces_, the first part
  // Of the particle at hand:
  std::vector<std::size_t> around_;  // pieces
  std::vector<Face> faces_;          // by their particles; `piece`: of around_
  double removed_mass_ = 0.0;        // kg, of the particle's corners in removed cells
  std::vector<FaceCut> cuts_of_face_;
};

void set(const BodyCut::Part& part, Cell& cell) {
  std::ranges::copy_n(part.particles.begin(), static_cast<std::ptrdiff_t>(cell.particles.size()),
                      cell.particles.begin());
  cell.share = part.share;
  cell.cuts = part.cuts;
}

}  // namespace

std::vector<Index> spare_particles_of(const Model& model) {
  Index last = -1;  // that a cell has
  for (const Cell& cell : model.cells) {
    for (const Index i : cell.particles) last = std::max(last, i);
  }
  std::vector<Index> spare;
  for (Index i = last + 1; last >= 0 && i < model.particle_count(); ++i) {
    const bool joined = i >= model.neighbours.rows() || model.neighbours.size(i) != 0;
    const bool has_mass = static_cast<std::size_t>(i) >= model.mass.size() || model.mass[i] != 0.0;
    if (!has_mass && !joined) spare.push_back(i);
  }
  return spare;
}

BodyCut cut_cells(const CutBody& body, const CutCells& cut) {
  return CellCutter(body, cut).run();
}

void make_cut(const BodyCut& cut, Model& model) {
  for (const BodyCut::Change& change : cut.changed) set(change.after, model.cells[change.row]);
  for (const BodyCut::Added& added : cut.added) {
    Cell cell = model.cells[added.of];
    set(added.part, cell);
    model.cells.push_back(std::move(cell));
  }
  for (const BodyCut::Copy& copy : cut.copies) {
    model.rest[copy.particle] = model.rest[copy.of];
    model.stiffness[copy.particle] = model.stiffness[copy.of];
  }
  if (model.components.empty()) return;
  std::unordered_map<Index, Index> cell_for;  // row of the other part
  std::unordered_map<Index, std::vector<Index>> copies_of;
  auto row = static_cast<Index>(model.cells.size() - cut.added.size());
  for (const BodyCut::Added& added : cut.added) cell_for[added.of] = row++;
  for (const BodyCut::Copy& copy : cut.copies) {
    if (copy.shared) copies_of[copy.of].push_back(copy.particle);
  }
  for (Component& component : model.components) {
    std::vector<Index> cells, particles;
    for (const std::vector<Index>* rows : {&component.cells, &component.cell_refs}) {
      for (const Index of : *rows) {
        if (const auto found = cell_for.find(of); found != cell_for.end()) cells.push_back(found->second);
      }
    }
    for (const Index of : component.particles) {
      if (const auto found = copies_of.find(of); found != copies_of.end()) {
        particles.insert(particles.end(), found->second.begin(), found->second.end());
      }
    }
    component.cell_refs.insert(component.cell_refs.end(), cells.begin(), cells.end());
    component.particles.insert(component.particles.end(), particles.begin(), particles.end());
  }
}

void undo_cut(const BodyCut& cut, Model& model, std::size_t cells) {
  for (const BodyCut::Change& change : cut.changed) set(change.before, model.cells[change.row]);
  for (const BodyCut::Copy& copy : cut.copies) model.stiffness[copy.particle] = 0.0;
  model.cells.resize(cells);
  for (Component& component : model.components) {
    while (!component.cell_refs.empty() && component.cell_refs.back() >= static_cast<Index>(cells))
      component.cell_refs.pop_back();
    while (!component.particles.empty() &&
           std::ranges::find(cut.copies, component.particles.back(), &BodyCut::Copy::particle) != cut.copies.end()) {
      component.particles.pop_back();
    }
  }
}

}  // namespace phymul
