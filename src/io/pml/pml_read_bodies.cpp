// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "base/decimal.h"
#include "model/body_type.h"
#include "model/cell_geometry.h"
#include "pml_reader.h"

namespace phymul {
namespace {

/// m^3 (2-D: m^2), however the cell is wound.
double measure(const Model& model, const Cell& cell) {
  return std::abs(tissue_volume(model, cell));
}

/// Of each vertex of the cell.
double share(const Model& model, const Cell& cell) {
  return measure(model, cell) / static_cast<double>(cell.particles.size());
}

}  // namespace

/// Masses of bodies, and no shape stiffness where the component's is that of its springs.
void PmlReader::take_body_constants() {
  for (std::size_t row = 0; row < model_.components.size(); ++row) {
    const Component& component = model_.components[row];
    const std::string_view type = body_type(component);
    if (type != "FEM" && type != "stiffSpring" && type != "rigid") continue;
    const std::string_view text = attribute_of(component, "mass");
    const std::optional<double> mass = parse_decimal(text);
    if (text.data() != nullptr && !(mass && *mass >= 0.0)) {
      xml_.note(component_nodes_[row], "expected one mass of 0 kg or more for each particle of the component, got " +
                                           XmlSource::cite(text) + "; it is left out");
    }
    for (const Index i : particles_of(model_, component)) {
      if (mass && *mass > 0.0 && std::isnan(model_.mass[i])) model_.mass[i] = *mass;
      if (type != "FEM" && std::isnan(model_.stiffness[i])) model_.stiffness[i] = 0.0;
    }
  }
  take_masses_of_densities();
}

/// Where a solid has a density and no masses.
void PmlReader::take_masses_of_densities() {
  std::vector<double> mass;
  for (const Component& component : model_.components) {
    if (body_type(component) != "FEM") continue;
    for (const Index row : cells_of(component)) {
      const Cell& cell = model_.cells[row];
      if (cell.material < 0) continue;
      mass.resize(model_.rest.size(), 0.0);
      for (const Index i : cell.particles) mass[i] += model_.materials[cell.material].density * share(model_, cell);
    }
  }
  for (std::size_t i = 0; i < mass.size(); ++i) {
    if (std::isnan(model_.mass[i]) && mass[i] > 0.0) model_.mass[i] = mass[i];
  }
}

/// The material of a component that needs_density(), for its cells without one. Its density is 0 until it is known.
void PmlReader::add_bodies_to_weigh() {
  for (std::size_t row = 0; row < model_.components.size(); ++row) {
    const Component& component = model_.components[row];
    const auto lacks_material = [this](Index cell) { return model_.cells[cell].material < 0; };
    if (!needs_density(component) || unweighed_[row] || std::ranges::none_of(cells_of(component), lacks_material)) {
      continue;
    }
    const pugi::xml_node node = component_nodes_[row];
    Material material{xml_.number(node, "young"), xml_.number(node, "poisson"), 1.0};
    if (node.attribute("thickness")) material.thickness = xml_.number(node, "thickness");
    require_material(node, material);
    material.density = 0.0;
    to_weigh_.push_back({node, static_cast<Index>(model_.materials.size())});
    model_.materials.push_back(material);
    for (const Index cell : cells_of(component)) {
      if (model_.cells[cell].material < 0) model_.cells[cell].material = to_weigh_.back().material;
    }
  }
}

/// A density is mass over volume of the cells of a material; the mass of a particle counts by its share of the volume
/// of its cells that have a material.
void PmlReader::weigh_bodies() {
  if (to_weigh_.empty()) return;
  std::vector<double> around(model_.rest.size(), 0.0);
  std::vector<double> mass(model_.materials.size(), 0.0), volume(model_.materials.size(), 0.0);
  for (const Cell& cell : model_.cells) {
    if (cell.material < 0) continue;
    for (const Index i : cell.particles) around[i] += share(model_, cell);
  }
  for (const Cell& cell : model_.cells) {
    if (cell.material < 0 || !(measure(model_, cell) > 0.0)) continue;
    volume[cell.material] += measure(model_, cell);
    for (const Index i : cell.particles) mass[cell.material] += model_.mass[i] * share(model_, cell) / around[i];
  }
  std::vector<Index> row_of(model_.materials.size());
  for (std::size_t row = 0; row < row_of.size(); ++row) row_of[row] = static_cast<Index>(row);
  for (const auto& [node, row] : to_weigh_) {
    Material& material = model_.materials[row];
    const double density = mass[row] / volume[row];  // NaN without masses or volume
    if (!(density > 0.0) || !std::isfinite(density)) {
      xml_.note(node,
                "expected a density, or masses and cells that fill space, besides young and poisson; no material "
                "is set");
      row_of[row] = -1;
      continue;
    }
    material.density = density;
    xml_.note(node, "a density of " + to_decimal(density) + " kg/m^3 follows from the masses and volumes of its cells");
    row_of[row] =
        material_rows_.try_emplace({material.young, material.poisson, density, material.thickness}, row).first->second;
  }
  for (Cell& cell : model_.cells) {
    if (cell.material >= 0) cell.material = row_of[cell.material];
  }
}

/// The particles of a body that does not move still need a mass.
void PmlReader::fill_immovable_bodies() {
  for (const Component& component : model_.components) {
    if (!is_immovable(component)) continue;
    for (const Index row : particles_of(model_, component)) {
      if (std::isnan(model_.mass[row])) model_.mass[row] = options_.default_mass;
    }
  }
}

}  // namespace phymul
