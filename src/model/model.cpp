// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/model.h>

#include <algorithm>
#include <set>

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

std::string known_groups(const Model& model) {
  std::set<std::string> names;
  for (const Component& component : model.components) {
    if (!component.name.empty()) names.insert(component.name);
  }
  if (names.empty()) return "the model has no named groups; add one with Model::add_group";
  std::string text = "known groups are";
  for (const std::string& known : names) text += (text.ends_with("are") ? " \"" : ", \"") + known + '"';
  return text;
}

/// What is yet to be validated may have cells of any size.
void require_whole(const Cell& cell) {
  const int size = cell_size(cell.type);
  if (size == 0 || cell.particles.size() == static_cast<std::size_t>(size)) return;
  throw Error(std::string("expected a ") + cell_name(cell.type) + " of " + std::to_string(size) + " particles, got " +
              std::to_string(cell.particles.size()));
}

void append(std::vector<Index>& particles, const Model& model, const Component& component) {
  particles.insert(particles.end(), component.particles.begin(), component.particles.end());
  for (const std::vector<Index>* rows : {&component.cells, &component.cell_refs}) {
    for (const Index row : *rows) {
      const std::vector<Index>& of_cell = model.cells[row].particles;
      particles.insert(particles.end(), of_cell.begin(), of_cell.end());
    }
  }
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

bool Model::has_group(std::string_view group_name) const {
  return std::any_of(components.begin(), components.end(),
                     [&](const Component& component) { return component.name == group_name; });
}

std::vector<Index> Model::group(std::string_view group_name) const {
  if (!has_group(group_name)) {
    throw Error(ErrorCode::unknown_name,
                "expected the name of a group, got \"" + std::string(group_name) + "\": " + known_groups(*this));
  }
  // Parents stand before children, so one pass takes a named component with all that it contains.
  std::vector<char> named(components.size(), 0);
  std::vector<Index> particles;
  for (std::size_t row = 0; row < components.size(); ++row) {
    const Component& component = components[row];
    named[row] = component.name == group_name || (component.parent >= 0 && named[component.parent]);
    if (named[row]) append(particles, *this, component);
  }
  std::sort(particles.begin(), particles.end());
  particles.erase(std::unique(particles.begin(), particles.end()), particles.end());
  return particles;
}

std::vector<Index> Model::particles_in(const Contains& contains) const {
  std::vector<Index> particles;
  for (Index i = 0; i < particle_count(); ++i) {
    if (contains(rest[i])) particles.push_back(i);
  }
  return particles;
}

Model& Model::add_group(std::string group_name, std::vector<Index> particles) {
  if (group_name.empty()) throw Error("expected a name for the group, got an empty one");
  for (const Index particle : particles) {
    if (particle < 0 || particle >= particle_count()) {
      throw Error("group \"" + group_name + "\": expected particles from 0 to " + std::to_string(particle_count() - 1) +
                  ", got " + std::to_string(particle));
    }
  }
  const auto root = std::find_if(components.begin(), components.end(), [](const Component& component) {
    return component.parent < 0 && !component.exclusive && !component.structural;
  });
  Component added;
  added.name = std::move(group_name);
  added.exclusive = false;
  added.particles = std::move(particles);
  added.parent = static_cast<Index>(root - components.begin());
  if (root == components.end()) {
    Component parent;
    parent.name = "Informative Components";
    parent.exclusive = false;
    parent.structural = false;
    components.push_back(std::move(parent));
  }
  components.push_back(std::move(added));
  return *this;
}

bool Model::operator==(const Model& other) const {
  return name == other.name && dimension == other.dimension && rest == other.rest && mass == other.mass &&
         stiffness == other.stiffness && neighbours == other.neighbours && cells == other.cells &&
         components == other.components && materials == other.materials &&
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
  if (model.rest.empty()) return 0.0;
  Vec3 low = model.rest.front(), high = low;
  for (const Vec3& x : model.rest) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).maxCoeff();
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
  std::vector<std::int64_t> next(start.begin(), start.end() - 1);
  each_edge([&](Index a, Index b) {
    entry[next[a]++] = b;
    entry[next[b]++] = a;
  });
  RaggedList list;
  list.offset.reserve(start.size());
  for (Index i = 0; i < particle_count; ++i) {
    const auto first = entry.begin() + start[i], last = entry.begin() + start[i + 1];
    std::sort(first, last);
    list.push_row(first, std::remove(first, std::unique(first, last), i));
  }
  return list;
}

}  // namespace phymul
