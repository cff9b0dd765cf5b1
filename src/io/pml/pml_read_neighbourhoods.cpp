// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "base/decimal.h"
#include "model/body_type.h"
#include "model/cell_geometry.h"
#include "pml_reader.h"

namespace phymul {
namespace {

void fill_unset(std::vector<double>& values, double value) {
  for (double& it : values) {
    if (std::isnan(it)) it = value;
  }
}

/// m^3 (2-D: m^2), however the cell is wound.
double measure(const Model& model, const Cell& cell) {
  return std::abs(tissue_volume(model, cell));
}

/// Of each vertex of the cell.
double share(const Model& model, const Cell& cell) {
  return measure(model, cell) / static_cast<double>(cell.particles.size());
}

}  // namespace

void PmlReader::open_neighbourhoods(pugi::xml_node component) {
  if (neighbourhoods_) {
    xml_.fail(component, "expected one component \"Neighborhoods\", got a second one; the first is on line " +
                             std::to_string(xml_.line(neighbourhoods_)) + "; put their cells together");
  }
  neighbourhoods_ = component;
  const pugi::xml_attribute mass = component.attribute("mass");
  const pugi::xml_attribute stiffness = component.attribute("stiffness");
  if (mass) component_mass_ = positive(component, "mass", mass.value(), false);
  if (stiffness) component_stiffness_ = positive(component, "stiffness", stiffness.value(), true);
}

void PmlReader::read_neighbourhood(pugi::xml_node cell, const CellHead& head) {
  constexpr std::string_view prefix = "Atom #";
  if (head.type != CellType::poly_vertex) {
    xml_.fail(head.node, std::string("expected a neighbourhood of type POLY_VERTEX, got ") + cell_name(head.type));
  }
  const std::optional<std::int64_t> number = parse_integer(head.name.substr(prefix.size()));
  const Index row = number ? atoms_.find(*number) : -1;
  if (row < 0) {
    xml_.fail(head.node, "expected a neighbourhood named \"Atom #\" and the index of an atom, got " +
                             XmlSource::cite(head.name) + ", which names no atom");
  }
  if (neighbourhood_cell_.empty()) neighbourhood_cell_.resize(model_.rest.size());
  if (neighbourhood_cell_[row]) {
    xml_.fail(head.node, "expected one neighbourhood for each atom, got another for atom " + std::to_string(*number) +
                             "; the first is on line " + std::to_string(xml_.line(neighbourhood_cell_[row])));
  }
  neighbourhood_cell_[row] = cell;
  if (head.index >= 0) {
    if (extras_.neighbourhood_index.empty()) extras_.neighbourhood_index.assign(model_.rest.size(), -1);
    extras_.neighbourhood_index[row] = head.index;
  }
  // Read even where the atom has its own: a wrong number is an error wherever it stands.
  if (head.mass.data() != nullptr) {
    const double mass = positive(head.node, "mass", head.mass, false);
    if (std::isnan(model_.mass[row])) model_.mass[row] = mass;
  }
  if (head.stiffness.data() != nullptr) {
    const double stiffness = positive(head.node, "stiffness", head.stiffness, true);
    if (std::isnan(model_.stiffness[row])) model_.stiffness[row] = stiffness;
  }
}

void PmlReader::finish_neighbourhoods() {
  if (neighbourhood_cell_.empty()) {
    if (neighbourhoods_)
      xml_.note(neighbourhoods_, "no neighbourhood in \"Neighborhoods\"; they are made from the cells");
    const std::vector<char> springs = interaction_cells(model_);
    if (std::ranges::find(springs, 1) == springs.end()) {
      model_.neighbours = neighbours_from_cells(model_.cells, model_.particle_count());
      return;
    }
    std::vector<Cell> tissue;
    for (std::size_t row = 0; row < springs.size(); ++row) {
      if (!springs[row]) tissue.push_back(model_.cells[row]);
    }
    model_.neighbours = neighbours_from_cells(tissue, model_.particle_count());
    return;
  }
  std::vector<Index> row_entries;
  std::vector<Index> missing;
  for (Index row = 0; row < model_.particle_count(); ++row) {
    row_entries.clear();
    const pugi::xml_node cell = neighbourhood_cell_[row];
    if (cell) {
      read_cell_parts(cell, row_entries);
      keep_neighbourhood_fields(cell, row);
    } else {
      missing.push_back(row);
    }
    if (model_.neighbours.entry.size() + row_entries.size() > largest_count) {
      xml_.fail(cell, "expected fewer than 2^31 neighbours in all, got more");
    }
    model_.neighbours.push_row(row_entries.begin(), row_entries.end());
  }
  if (!missing.empty()) note_missing(missing);
}

void PmlReader::keep_neighbourhood_fields(pugi::xml_node cell, Index row) {
  NeighbourhoodFields fields;
  fields.particle = row;
  fields.attributes =
      xml_.other_attributes(cell.child("cellProperties"), {"index", "name", "type", pml_mark_attribute});
  if (const pugi::xml_node node = cell.child("color")) fields.colour = colour(node);
  if (!fields.attributes.empty() || fields.colour) {
    extras_.neighbourhood_fields.push_back(std::move(fields));
  }
}

void PmlReader::note_missing(const std::vector<Index>& rows) {
  constexpr std::size_t shown = 10;
  std::string list;
  for (std::size_t i = 0; i < rows.size() && i < shown; ++i) {
    const Index row = rows[i];
    list += (i == 0 ? "" : ", ") + std::to_string(extras_.particle_index.empty() ? row : extras_.particle_index[row]);
  }
  if (rows.size() > shown) list += ", ...";
  xml_.note(neighbourhoods_,
            std::to_string(rows.size()) + " atom(s) have no neighbourhood and get no neighbours: " + list);
}

void PmlReader::note_defaults() {
  const auto unset_in = [](const std::vector<double>& values) {
    return std::ranges::count_if(values, [](double value) { return std::isnan(value); });
  };
  const std::string of = " of " + std::to_string(model_.particle_count()) + " atom(s) have no ";
  const auto massless = unset_in(model_.mass);
  if (massless > 0) {
    xml_.note(xml_.root(), std::to_string(massless) + of + "mass: " + to_decimal(options_.default_mass) +
                               " kg each is assumed (PmlOptions::default_mass), until set_material gives another");
  }
  // Materials of the cells leave no use for it.
  const bool elastic = std::ranges::any_of(model_.cells, [](const Cell& cell) { return cell.material >= 0; });
  const auto slack = elastic ? 0 : unset_in(model_.stiffness);
  if (slack > 0) {
    xml_.note(xml_.root(),
              std::to_string(slack) + of + "stiffness: " + to_decimal(options_.default_stiffness) +
                  " N/m each is assumed (PmlOptions::default_stiffness), until set_material gives another");
  }
}

void PmlReader::finish_particles() {
  fill_unset(model_.mass, component_mass_);
  fill_unset(model_.stiffness, component_stiffness_);
  take_body_constants();
  add_bodies_to_weigh();
  weigh_bodies();
  fill_immovable_bodies();
  note_defaults();
  fill_unset(model_.mass, options_.default_mass);
  fill_unset(model_.stiffness, options_.default_stiffness);
}

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
