// SPDX-License-Identifier: MIT
#include "body_type.h"

#include <algorithm>

#include "base/decimal.h"

namespace phymul {
namespace {

bool is_without_tissue(const Component& component) {
  const std::string_view type = body_type(component);
  return is_immovable(component) || !(type.empty() || type == "FEM" || type == "interaction");
}

}  // namespace

std::string_view attribute_of(const Component& component, std::string_view name) {
  const auto found = std::ranges::find(component.attributes, name, &Attribute::name);
  return found == component.attributes.end() ? std::string_view() : std::string_view(found->value);
}

bool is_immovable(const Component& component) {
  const std::string_view type = body_type(component);
  if (type.empty() || type == "interaction") return false;
  return type == "rigid" || parse_decimal(attribute_of(component, "mass")) == 0.0;
}

bool needs_density(const Component& component) {
  const auto has = [&component](const char* name) { return attribute_of(component, name).data() != nullptr; };
  return body_type(component) == "FEM" && has("young") && has("poisson") && !has("density");
}

std::vector<Index> cells_of(const Component& component) {
  std::vector<Index> cells = component.cells;
  cells.insert(cells.end(), component.cell_refs.begin(), component.cell_refs.end());
  return cells;
}

std::vector<Index> particles_of(const Model& model, const Component& component) {
  std::vector<Index> particles = component.particles;
  for (const Index row : cells_of(component)) {
    particles.insert(particles.end(), model.cells[row].particles.begin(), model.cells[row].particles.end());
  }
  std::ranges::sort(particles);
  const auto again = std::ranges::unique(particles);
  particles.erase(again.begin(), again.end());
  return particles;
}

std::vector<char> interaction_cells(const Model& model) {
  std::vector<char> chosen(model.cells.size(), 0);
  for (const Component& component : model.components) {
    if (body_type(component) != "interaction") continue;
    for (const Index row : cells_of(component)) chosen[row] = 1;
  }
  return chosen;
}

std::vector<char> cells_without_tissue(const Model& model) {
  std::vector<char> chosen = interaction_cells(model);
  for (const Component& component : model.components) {
    if (!is_without_tissue(component)) continue;
    for (const Index row : cells_of(component)) chosen[row] = 1;
  }
  return chosen;
}

std::vector<char> particles_without_tissue(const Model& model) {
  std::vector<char> chosen(model.rest.size(), 0);
  for (const Component& component : model.components) {
    if (!is_without_tissue(component)) continue;
    for (const Index i : particles_of(model, component)) chosen[i] = 1;
  }
  return chosen;
}

}  // namespace phymul
