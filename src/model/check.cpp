// SPDX-License-Identifier: MIT
#include <phymul/check.h>
#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>

#include "base/decimal.h"
#include "cell_cutter.h"
#include "cell_geometry.h"
#include "duplicates.h"
#include "file_extras.h"

namespace phymul {
namespace {

constexpr double degenerate_ratio = 1e-6;  // volume / longest edge^3, area / longest edge^2
constexpr double same_point_ratio = 1e-9;  // distance / body size
constexpr double massless_ratio = 1e-9;    // mass / mean mass
constexpr double collinear_ratio = 1e-6;   // distance from the line / length of the line
constexpr double largest_body = 10.0;      // m
constexpr double smallest_body = 10.0e-6;  // m
constexpr std::size_t named_at_most = 5;

Index cell_number(const Model& model, Index row) {
  const Index number = model.cell_file_index(row);
  return number >= 0 ? number : row;
}

/// "1 particle has" or "3 particles have", as `one` and `many` say.
std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

/// The first few items, each as `name` writes it: "3, 7, 9 and 12 more".
template <class Items, class Name>
std::string first_few(const Items& items, Name name) {
  std::string text;
  for (std::size_t k = 0; k < std::min(items.size(), named_at_most); ++k) text += (k ? ", " : "") + name(items[k]);
  if (items.size() > named_at_most) text += " and " + std::to_string(items.size() - named_at_most) + " more";
  return text;
}

/// Before numbers of the file, or where it gave none before rows of the model, counted from 0.
std::string word_before(const std::vector<Index>& file_numbers) {
  return file_numbers.empty() ? "row " : "number ";
}

std::string particles_named(const Model& model, const std::vector<Index>& items) {
  return word_before(extras_of(model).particle_index) +
         first_few(items, [&](Index i) { return std::to_string(model.file_index(i)); });
}

std::string cells_named(const Model& model, const std::vector<Index>& items) {
  return word_before(extras_of(model).cell_index) +
         first_few(items, [&](Index row) { return std::to_string(cell_number(model, row)); });
}

double longest_edge(const Model& model, const Cell& cell) {
  double longest = 0.0;
  for (const CellEdge& edge : cell_edges(cell.type)) {
    const double length = (model.rest[cell.particles[edge[0]]] - model.rest[cell.particles[edge[1]]]).norm();
    longest = std::max(longest, length);
  }
  return longest;
}

bool repeats_a_vertex(const Cell& cell) {
  for (std::size_t a = 0; a < cell.particles.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (cell.particles[a] == cell.particles[b]) return true;
    }
  }
  return false;
}

/// Lines, whose only measure is their length, are degenerate by a repeated vertex alone; other cells also where their
/// measure is beyond the range of numbers.
bool is_degenerate(const Model& model, const Cell& cell) {
  if (cell_edges(cell.type).empty()) return false;
  if (repeats_a_vertex(cell)) return true;
  const double edge = longest_edge(model, cell);
  if (is_volume(cell.type)) {
    const double volume = signed_volume(cell.type, cell.particles, model.rest);
    return !(std::abs(volume) >= degenerate_ratio * edge * edge * edge) || volume == 0.0 || !std::isfinite(volume);
  }
  if (cell.type == CellType::line) return false;
  const double area = area_vector(cell.particles, model.rest).norm();
  return !(area >= degenerate_ratio * edge * edge) || area == 0.0 || !std::isfinite(area);
}

/// Cells that overlap one they share a face with, however they are wound: with all volumes made positive, both cells
/// see the face from the same side. `negative`: cells of negative volume; none, none overlap so.
std::vector<Index> tangled_cells(const Model& model, const std::vector<Index>& negative) {
  if (negative.empty()) return {};
  std::vector<char> is_negative(model.cells.size(), 0);
  for (const Index row : negative) is_negative[row] = 1;
  struct Side {
    Index cell;
    bool ascends;
  };
  std::map<std::array<Index, 4>, std::vector<Side>> sides;  // by the sorted particles of a face, -1 in front
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    if (!is_solid(model.dimension, model.cells[row]) || is_degenerate(model, model.cells[row])) continue;
    each_face(model.dimension, model.cells[row], [&](std::array<Index, 4> ring) {
      const auto end = std::ranges::find(ring, -1);
      const bool is_edge = end - ring.begin() == 2;
      if (!is_edge) std::rotate(ring.begin(), std::min_element(ring.begin(), end), end);
      const bool ascends = ring[is_edge ? 0 : 1] < *std::prev(end);
      std::ranges::sort(ring);
      sides[ring].push_back({row, ascends != (is_negative[row] != 0)});
    });
  }
  std::vector<std::array<Index, 2>> overlapping;
  std::vector<int> times(model.cells.size(), 0);
  const auto particles_of = [&](Index cell) {
    std::vector<Index> particles = model.cells[cell].particles;
    std::ranges::sort(particles);
    return particles;
  };
  for (const auto& [face, both] : sides) {
    if (both.size() != 2 || both[0].ascends != both[1].ascends) continue;
    if (particles_of(both[0].cell) == particles_of(both[1].cell)) continue;  // the same cell twice
    overlapping.push_back({both[0].cell, both[1].cell});
    for (const Side& side : both) ++times[side.cell];
  }
  // Of two cells that overlap the one that lies wrong overlaps others, too, or is wound as few are.
  const bool few_are_negative = 2 * negative.size() <= model.cells.size();
  std::vector<Index> tangled;
  for (const auto& [a, b] : overlapping) {
    tangled.push_back(times[a] > times[b] || (times[a] == times[b] && (is_negative[a] != 0) == few_are_negative) ? a
                                                                                                                 : b);
  }
  std::ranges::sort(tangled);
  tangled.erase(std::unique(tangled.begin(), tangled.end()), tangled.end());
  return tangled;
}

/// Tells of some items, where there are any.
void tell(Flaw flaw, std::vector<Index> items, bool mended, const std::string& message,
          std::vector<Finding>& findings) {
  if (!items.empty()) findings.push_back({flaw, std::move(items), mended, message});
}

void look_at_cells(const Model& model, bool mending, std::vector<Finding>& findings) {
  std::vector<Index> wound, flat;
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    const Cell& cell = model.cells[row];
    if (cell.share == 0.0) continue;
    if (is_degenerate(model, cell)) {
      flat.push_back(row);
    } else if (signed_measure(model.dimension, cell, model.rest) < 0.0) {
      wound.push_back(row);
    }
  }
  const std::vector<Index> tangled = tangled_cells(model, wound);
  if (!tangled.empty()) {
    const Vec3& at = model.rest[model.cells[tangled.front()].particles.front()];
    tell(Flaw::tangled, tangled, false,
         counted(tangled.size(), "cell overlaps its", "cells overlap their") +
             " neighbours, whatever the order of the vertices: " + cells_named(model, tangled) + ", near " +
             place_text(at) + "; a vertex lies beyond the faces around it: move it back, or mesh the body again",
         findings);
    wound.clear();
  }
  tell(Flaw::winding, wound, mending,
       counted(wound.size(), "cell is wound", "cells are wound") + " the wrong way, with negative " +
           (model.dimension == 3 ? "volume: " : "area: ") + cells_named(model, wound) +
           (mending ? "; turned round" : "; check_mesh mends this"),
       findings);
  tell(Flaw::degenerate_cell, flat, false,
       counted(flat.size(), "cell is", "cells are") +
           " degenerate, with no volume or area for the length of the edges, a size beyond the range of numbers or a "
           "vertex repeated: " +
           cells_named(model, flat) + "; remove such cells, or mend their places or the order of the vertices",
       findings);
}

/// All rows in the pairs, each once, sorted.
std::vector<Index> rows_of(const Repeats& repeats) {
  std::vector<Index> rows;
  for (const auto& [row, original] : repeats) rows.insert(rows.end(), {row, original});
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

void look_for_repeats(const Model& model, const std::vector<char>& spare, std::vector<Finding>& findings) {
  Repeats cells = repeated_cells(model.cells);
  std::erase_if(cells, [&](const auto& pair) {  // parts of one cell where a cut ends
    return model.cells[pair.first].share < 1.0 && model.cells[pair.second].share < 1.0;
  });
  const std::string cell_names = first_few(cells, [&](const std::pair<Index, Index>& pair) {
    return std::to_string(cell_number(model, pair.first)) + " repeats " +
           std::to_string(cell_number(model, pair.second));
  });
  tell(Flaw::duplicate_cell, rows_of(cells), false,
       counted(cells.size(), "cell stands", "cells stand") + " over the particles of another: " +
           word_before(extras_of(model).cell_index) + cell_names + "; keep one of each, or their volume counts twice",
       findings);
  Repeats points = repeated_points(model.rest, same_point_ratio * body_size(model));
  std::erase_if(points, [&](const auto& pair) { return spare[pair.first] != 0 || spare[pair.second] != 0; });
  const std::string point_names = first_few(points, [&](const std::pair<Index, Index>& pair) {
    return std::to_string(model.file_index(pair.first)) + " on " + std::to_string(model.file_index(pair.second));
  });
  tell(Flaw::duplicate_point, rows_of(points), false,
       counted(points.size(), "particle lies", "particles lie") +
           " on the place of another: " + word_before(extras_of(model).particle_index) + point_names +
           "; merge such pairs, unless the body is meant to be cut there",
       findings);
}

void look_at_masses(const Model& model, std::vector<Finding>& findings) {
  const double sum = std::accumulate(model.mass.begin(), model.mass.end(), 0.0);
  const double least = massless_ratio * sum / static_cast<double>(model.mass.size());
  std::vector<Index> items;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (model.mass[i] > 0.0 && model.mass[i] < least) items.push_back(i);  // 0: spare, or all cells are removed
  }
  tell(Flaw::massless, items, false,
       counted(items.size(), "particle has", "particles have") + " next to no mass beside the mean: " +
           particles_named(model, items) + "; give more, or the stable step becomes tiny",
       findings);
}

/// Neighbours of a particle other than itself, each once.
void gather_neighbours(const Model& model, Index i, std::vector<Index>& others) {
  others.assign(model.neighbours.begin(i), model.neighbours.end(i));
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  others.erase(std::remove(others.begin(), others.end(), i), others.end());
}

bool on_one_line(const Model& model, const std::vector<Index>& others) {
  const Vec3& a = model.rest[others.front()];
  Vec3 line = Vec3::Zero();
  for (const Index j : others) {
    const Vec3 to = model.rest[j] - a;
    if (to.squaredNorm() > line.squaredNorm()) line = to;
  }
  const double width = collinear_ratio * line.squaredNorm();
  return std::all_of(others.begin(), others.end(),
                     [&](Index j) { return line.cross(model.rest[j] - a).norm() <= width; });
}

/// Particles that no cell holds though the body is made of cells.
std::vector<char> outside_the_cells(const Model& model) {
  const bool made_of_cells = std::any_of(model.cells.begin(), model.cells.end(),
                                         [&](const Cell& cell) { return is_solid(model.dimension, cell.type); });
  std::vector<char> outside(model.rest.size(), made_of_cells);
  for (const Cell& cell : model.cells) {
    if (cell_edges(cell.type).empty()) continue;
    for (const Index i : cell.particles) outside[i] = 0;
  }
  return outside;
}

void look_at_neighbours(const Model& model, const std::vector<char>& spare, bool mending,
                        std::vector<Finding>& findings) {
  const std::size_t needed = model.dimension == 3 ? 3 : 2;
  const std::vector<char> outside = outside_the_cells(model);
  std::vector<Index> isolated, few, own, others;
  for (Index i = 0; i < model.particle_count(); ++i) {
    if (spare[i] != 0) continue;
    gather_neighbours(model, i, others);
    if (others.empty() || outside[i]) isolated.push_back(i);
    // Two points always lie on a line, which in the plane is all that a base needs.
    if (others.size() < needed || (model.dimension == 3 && on_one_line(model, others))) few.push_back(i);
    if (std::find(model.neighbours.begin(i), model.neighbours.end(i), i) != model.neighbours.end(i)) {
      own.push_back(i);
    }
  }
  tell(Flaw::isolated, isolated, false,
       counted(isolated.size(), "particle has", "particles have") +
           " no neighbours or no cell around: " + particles_named(model, isolated) +
           "; nothing elastic holds such a particle: remove it, or add it to the mesh",
       findings);
  tell(Flaw::few_neighbours, few, false,
       counted(few.size(), "particle has", "particles have") + " fewer than " + std::to_string(needed) + " neighbours" +
           (model.dimension == 3 ? " or all of them on one line: " : ": ") + particles_named(model, few) +
           "; add neighbours, or choose what becomes of sparse particles",
       findings);
  tell(Flaw::self_neighbour, own, mending,
       counted(own.size(), "particle is among its own neighbours: ", "particles are among their own neighbours: ") +
           particles_named(model, own) + (mending ? "; removed from the lists" : "; check_mesh mends this"),
       findings);
}

void look_at_units(const Model& model, std::vector<Finding>& findings) {
  const double size = body_size(model);
  if (size <= largest_body && (size >= smallest_body || size == 0.0)) return;
  char text[160];
  std::snprintf(text, sizeof text, "the body is %g m large: perhaps %s; set the length unit when reading", size,
                size > largest_body ? "millimetres were read as metres" : "metres were read as millimetres");
  findings.push_back({Flaw::suspect_units, {}, false, text});
}

std::vector<Finding> look(const Model& model, bool mending) {
  std::vector<Finding> findings;
  look_at_cells(model, mending, findings);
  std::vector<char> spare(model.rest.size(), 0);
  for (const Index i : spare_particles_of(model)) spare[i] = 1;
  look_for_repeats(model, spare, findings);
  look_at_masses(model, findings);
  look_at_neighbours(model, spare, mending, findings);
  look_at_units(model, findings);
  return findings;
}

void turn_round(Cell& cell) {
  const std::span<const int> place = cell_reversal(cell.type);
  const std::vector<Index> old = cell.particles;
  const std::vector<CellCut> cuts = cell.cuts;
  for (std::size_t v = 0; v < old.size(); ++v) {
    cell.particles[v] = old[place[v]];
    for (std::size_t k = 0; k < cuts.size(); ++k) cell.cuts[k][v] = cuts[k][place[v]];
  }
}

void remove_self_neighbours(RaggedList& neighbours) {
  RaggedList kept;
  std::vector<Index> row;
  for (Index i = 0; i < neighbours.rows(); ++i) {
    row.assign(neighbours.begin(i), neighbours.end(i));
    row.erase(std::remove(row.begin(), row.end(), i), row.end());
    kept.push_row(row.begin(), row.end());
  }
  neighbours = std::move(kept);
}

}  // namespace

std::vector<Finding> find_flaws(const Model& model) {
  return look(model, false);
}

std::vector<Finding> check_mesh(Model& model, const std::string& source) {
  std::vector<Finding> findings = look(model, true);
  const auto tangled = std::ranges::find(findings, Flaw::tangled, &Finding::flaw);
  if (tangled != findings.end()) {
    throw Error(ErrorCode::invalid_model, (source.empty() ? "" : source + ": ") + tangled->message);
  }
  for (const Finding& finding : findings) {
    if (finding.flaw == Flaw::winding) {
      for (const Index row : finding.items) turn_round(model.cells[row]);
    }
    if (finding.flaw == Flaw::self_neighbour) remove_self_neighbours(model.neighbours);
    model.notes.push_back(source.empty() ? finding.message : source + ": " + finding.message);
  }
  return findings;
}

}  // namespace phymul
