// SPDX-License-Identifier: MIT
//
// Groups of particles and of cells: named components.
#include "group.h"

#include <phymul/error.h>

#include <algorithm>
#include <set>

#include "cell_cutter.h"
#include "cell_geometry.h"

namespace phymul {
namespace {

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

std::string label_of(const std::string& group_name) {
  return "group \"" + group_name + "\": ";
}

/// Sets to 1, in [N], the component's particles.
void mark(std::vector<char>& particles, const Model& model, const Component& component) {
  const auto label = [&] { return label_of(component.name); };
  const auto mark_all = [&](const std::vector<Index>& members) {
    require_indices(members, particles.size(), "particles", label);
    for (const Index i : members) particles[i] = 1;
  };
  mark_all(component.particles);
  for (const std::vector<Index>* rows : {&component.cells, &component.cell_refs}) {
    require_indices(*rows, model.cells.size(), "cells", label);
    for (const Index row : *rows) mark_all(model.cells[row].particles);
  }
}

/// [components] 1: it has the name, or is in one that has it. Throws Error for an unknown name.
std::vector<char> components_named(const Model& model, std::string_view group_name) {
  if (!model.has_group(group_name)) {
    throw Error(ErrorCode::unknown_name,
                "expected the name of a group, got \"" + std::string(group_name) + "\": " + known_groups(model));
  }
  // Parents stand before children, so one pass finds all.
  std::vector<char> named;
  for (const Component& component : model.components) {
    named.push_back(component.name == group_name || (component.parent >= 0 && named[component.parent]));
  }
  return named;
}

/// [particles] 1: in the group. Throws Error for an unknown name.
std::vector<char> particles_named(const Model& model, std::string_view group_name) {
  const std::vector<char> named = components_named(model, group_name);
  std::vector<char> in_group(model.rest.size(), 0);
  for (std::size_t row = 0; row < named.size(); ++row) {
    if (named[row]) mark(in_group, model, model.components[row]);
  }
  return in_group;
}

bool are_all_marked(const std::vector<Index>& particles, const std::vector<char>& marks) {
  return std::ranges::all_of(particles, [&](Index i) { return marks[i] != 0; });
}

/// The rows whose mark is not 0.
std::vector<Index> marked(const std::vector<char>& marks) {
  std::vector<Index> rows;
  for (std::size_t row = 0; row < marks.size(); ++row) {
    if (marks[row] != 0) rows.push_back(static_cast<Index>(row));
  }
  return rows;
}

}  // namespace

std::vector<char> cells_of_group(const Model& model, std::string_view group_name,
                                 const std::function<bool(CellType)>& fits) {
  const auto is_meant = [&](CellType type) { return fits ? fits(type) : is_solid(model.dimension, type); };
  const std::vector<char> named = components_named(model, group_name);
  std::vector<char> chosen(model.cells.size(), 0);
  std::vector<char> is_loose(model.rest.size(), 0);  // particles of components that list no such cell
  for (std::size_t row = 0; row < named.size(); ++row) {
    if (!named[row]) continue;
    const Component& component = model.components[row];
    bool lists_one = false;
    for (const std::vector<Index>* cells : {&component.cells, &component.cell_refs}) {
      for (const Index cell : *cells) {
        if (!is_meant(model.cells[cell].type)) continue;
        chosen[cell] = 1;
        lists_one = true;
      }
    }
    if (!lists_one) mark(is_loose, model, component);
  }
  for (std::size_t row = 0; row < chosen.size(); ++row) {
    const Cell& cell = model.cells[row];
    if (is_meant(cell.type) && are_all_marked(cell.particles, is_loose)) chosen[row] = 1;
  }
  return chosen;
}

Model part_of(const Model& model, std::string_view group_name) {
  const std::vector<char> chosen = cells_of_group(model, group_name);
  const bool is_solid_part = std::ranges::find(chosen, 1) != chosen.end();
  const std::vector<char> in_group = particles_named(model, group_name);
  Model part;
  part.dimension = model.dimension;
  part.rest = model.rest;
  for (std::size_t row = 0; row < chosen.size(); ++row) {
    const Cell& cell = model.cells[row];
    if (is_solid_part ? chosen[row] != 0 : are_all_marked(cell.particles, in_group)) part.cells.push_back(cell);
  }
  return part;
}

void add_cell_group(Model& model, std::string group_name, std::vector<Index> cells) {
  model.add_group(std::move(group_name), {});
  model.components.back().cell_refs = std::move(cells);
}

bool Model::has_group(std::string_view group_name) const {
  return std::any_of(components.begin(), components.end(),
                     [&](const Component& component) { return component.name == group_name; });
}

std::vector<Index> Model::group(std::string_view group_name) const {
  return marked(particles_named(*this, group_name));
}

std::vector<Index> Model::particles_in(const Contains& contains) const {
  std::vector<Index> particles;
  const std::vector<Index> spare = spare_particles_of(*this);
  for (Index i = 0; i < particle_count(); ++i) {
    if (contains(rest[i]) && !std::ranges::binary_search(spare, i)) particles.push_back(i);
  }
  return particles;
}

std::vector<Index> Model::cells_in(const Contains& contains, std::span<const Vec3> position) const {
  if (position.empty()) position = rest;
  if (position.size() != rest.size()) {
    throw Error("Model::cells_in: expected " + std::to_string(rest.size()) + " positions or none, got " +
                std::to_string(position.size()));
  }
  const auto of_tissue = [this](const Cell& cell) { return is_tissue(*this, cell); };
  const bool has_tissue = std::ranges::any_of(cells, of_tissue);
  std::vector<Index> rows;
  for (std::size_t row = 0; row < cells.size(); ++row) {
    if (cells[row].share == 0.0 || cells[row].particles.empty()) continue;
    if (has_tissue && !of_tissue(cells[row])) continue;
    if (contains(cell_centre(cells[row], position))) rows.push_back(static_cast<Index>(row));
  }
  return rows;
}

Model& Model::add_group(std::string group_name, std::vector<Index> particles) {
  if (group_name.empty()) throw Error("expected a name for the group, got an empty one");
  require_indices(particles, rest.size(), "particles", [&] { return label_of(group_name); });
  const auto root = std::find_if(components.begin(), components.end(), [](const Component& component) {
    return component.parent < 0 && !component.exclusive && !component.structural;
  });
  Component added{.name = std::move(group_name),
                  .parent = static_cast<Index>(root - components.begin()),
                  .exclusive = false,
                  .particles = std::move(particles)};
  if (root == components.end()) {
    Component parent{.name = "Informative Components", .exclusive = false, .structural = false};
    components.push_back(std::move(parent));
  }
  components.push_back(std::move(added));
  return *this;
}

}  // namespace phymul
