// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/model.h>

#include <algorithm>

#include "base/bounding_box.h"
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

}  // namespace phymul
