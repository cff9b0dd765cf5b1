// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/model.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "base/box_tree.h"
#include "cell_geometry.h"
#include "file_extras.h"

namespace phymul {
namespace {

struct CellTypeRow {
  int size;
  const char* name;
};

// Rows in the order of CellType.
constexpr CellTypeRow cell_types[] = {{1, "ATOM"},        {2, "LINE"},       {3, "TRIANGLE"}, {4, "QUAD"},
                                      {4, "TETRAHEDRON"}, {6, "WEDGE"},      {5, "PYRAMID"},  {8, "HEXAHEDRON"},
                                      {0, "POLY_LINE"},   {0, "POLY_VERTEX"}};

/// What is yet to be validated may have cells of any size.
void require_whole(const Cell& cell) {
  const int size = cell_size(cell.type);
  if (size == 0 || cell.particles.size() == static_cast<std::size_t>(size)) return;
  throw Error(std::string("expected a ") + cell_name(cell.type) + " of " + std::to_string(size) + " particles, got " +
              std::to_string(cell.particles.size()));
}

}  // namespace

int cell_size(CellType type) {
  return cell_types[static_cast<int>(type)].size;
}

bool is_volume(CellType type) {
  return type == CellType::tetrahedron || type == CellType::wedge || type == CellType::pyramid ||
         type == CellType::hexahedron;
}

const char* cell_name(CellType type) {
  return cell_types[static_cast<int>(type)].name;
}

bool Model::operator==(const Model& other) const {
  return name == other.name && dimension == other.dimension && rest == other.rest && mass == other.mass &&
         stiffness == other.stiffness && neighbours == other.neighbours && cells == other.cells &&
         components == other.components && materials == other.materials && most_mass_moved == other.most_mass_moved &&
         (extras == other.extras || extras_of(*this) == extras_of(other));
}

double cell_volume(const Model& model, const Cell& cell) {
  require_whole(cell);
  return signed_volume(cell.type, cell.particles, model.rest);
}

double mean_spacing(const Model& model) {
  double sum = 0.0;
  for (Index i = 0; i < model.neighbours.rows(); ++i) {
    for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) {
      sum += (model.rest[*j] - model.rest[i]).norm();
    }
  }
  return model.neighbours.entry.empty() ? 0.0 : sum / static_cast<double>(model.neighbours.entry.size());
}

double body_size(const Model& model) {
  return model.rest.empty() ? 0.0 : bounding_box(model.rest).sizes().maxCoeff();
}

RaggedList neighbours_from_cells(const std::vector<Cell>& cells, Index particle_count) {
  for (const Cell& cell : cells) require_whole(cell);
  std::vector<std::int64_t> start(static_cast<std::size_t>(particle_count) + 1, 0);
  const auto each_edge = [&](auto&& visit) {
    for (const Cell& cell : cells) {
      for (const CellEdge& edge : cell_edges(cell.type)) visit(cell.particles[edge[0]], cell.particles[edge[1]]);
    }
  };
  each_edge([&](Index a, Index b) {
    if (std::min(a, b) < 0 || std::max(a, b) >= particle_count) {
      throw Error("expected cells over particles from 0 to " + std::to_string(particle_count - 1) + ", got one over " +
                  std::to_string(std::min(a, b) < 0 ? std::min(a, b) : std::max(a, b)));
    }
    ++start[a + 1];
    ++start[b + 1];
  });
  for (Index i = 0; i < particle_count; ++i) start[i + 1] += start[i];
  std::vector<Index> entry(static_cast<std::size_t>(start.back()));
  std::vector<std::size_t> next(start.begin(), start.end() - 1);
  each_edge([&](Index a, Index b) {
    entry[next[a]++] = b;
    entry[next[b]++] = a;
  });
  RaggedList list;
  list.offset.reserve(start.size());
  for (Index i = 0; i < particle_count; ++i) {
    const auto place = [&](Index row) { return entry.begin() + static_cast<std::ptrdiff_t>(start[row]); };
    const auto first = place(i), last = place(i + 1);
    std::sort(first, last);
    list.push_row(first, std::remove(first, std::unique(first, last), i));
  }
  return list;
}

std::shared_ptr<const FileExtras> FileExtras::share() && {
  while (!cell_index.empty() && cell_index.back() < 0) cell_index.pop_back();
  return *this == FileExtras{} ? nullptr : std::make_shared<const FileExtras>(std::move(*this));
}

const FileExtras& extras_of(const Model& model) {
  static const FileExtras empty;
  return model.extras ? *model.extras : empty;
}

Index Model::file_index(Index particle) const {
  const std::vector<Index>& index = extras_of(*this).particle_index;
  return index.empty() ? particle : index[particle];
}

Index Model::cell_file_index(Index cell) const {
  const std::vector<Index>& index = extras_of(*this).cell_index;
  return static_cast<std::size_t>(cell) < index.size() ? index[cell] : -1;
}

namespace {

/// Distances that differ by less are the same: on a lattice the choice among equals would be rounding's.
constexpr double same = 1.0 + 1e-6;

int longest_axis(const VecList& rest) {
  int axis = 0;
  bounding_box(rest).sizes().maxCoeff(&axis);
  return axis;
}

}  // namespace

RaggedList nearest_neighbours(const VecList& rest, int count) {
  const auto particles = static_cast<Index>(rest.size());
  if (count < 1 || count >= particles) {
    throw Error("nearest_neighbours: expected 1 to " + std::to_string(particles - 1) + " neighbours of " +
                std::to_string(particles) + " particles, got " + std::to_string(count));
  }
  const auto at_infinity = std::ranges::find_if(rest, [](const Vec3& x) { return !x.allFinite(); });
  if (at_infinity != rest.end()) {
    throw Error("nearest_neighbours: expected finite places, got another one of particle " +
                std::to_string(at_infinity - rest.begin()));
  }
  // Outward from each particle in the order along one axis, until that distance alone is larger than the last one's.
  const int axis = longest_axis(rest);
  std::vector<Index> order(rest.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](Index a, Index b) { return std::pair(rest[a][axis], a) < std::pair(rest[b][axis], b); });
  std::vector<std::vector<Index>> rows(rest.size());
  std::vector<std::pair<double, Index>> near;  // by distance; the first `count` and those as near as the last of them
  const auto limit = [&] {
    const auto last = static_cast<std::size_t>(count) - 1;
    return near.size() <= last ? std::numeric_limits<double>::infinity() : same * near[last].first;
  };
  for (Index place = 0; place < particles; ++place) {
    const Index i = order[place];
    near.clear();
    const auto away = [&](Index at) {
      return at < 0 || at >= particles ? std::numeric_limits<double>::infinity()
                                       : std::abs(rest[order[at]][axis] - rest[i][axis]);
    };
    Index below = place - 1, above = place + 1;
    while (below >= 0 || above < particles) {
      // A distance may be infinite although both places are not.
      const Index at = above >= particles || (below >= 0 && away(below) < away(above)) ? below-- : above++;
      if (away(at) > limit()) break;
      const std::pair entry{(rest[order[at]] - rest[i]).norm(), order[at]};
      if (entry.first > limit()) continue;
      near.insert(std::ranges::upper_bound(near, entry), entry);
      while (near.back().first > limit()) near.pop_back();
    }
    for (const auto& [distance, j] : near) {
      rows[i].push_back(j);
      rows[j].push_back(i);
    }
  }
  RaggedList list;
  for (std::vector<Index>& row : rows) {
    std::ranges::sort(row);
    row.erase(std::ranges::unique(row).begin(), row.end());
    list.push_row(row.begin(), row.end());
  }
  return list;
}

}  // namespace phymul
