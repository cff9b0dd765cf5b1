// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "base/decimal.h"
#include "model/body_type.h"
#include "pml_bodies.h"
#include "pml_reader.h"

namespace phymul {

/// Masses, and no shape stiffness where the component's is that of its springs.
void PmlReader::take_body_constants() {
  for (const Component& component : model_.components) {
    const std::string_view type = body_type(component);
    if (type.empty() || type == "interaction") continue;
    const double mass = parse_decimal(attribute_of(component, "mass")).value_or(0.0);
    for (const Index row : own_particles(model_, component)) {
      if (mass > 0.0 && std::isnan(model_.mass[row])) model_.mass[row] = mass;
      if (type != "FEM" && std::isnan(model_.stiffness[row])) model_.stiffness[row] = 0.0;
    }
  }
}

void PmlReader::weigh_materials() {
  const auto unweighed = [this] {
    return std::ranges::any_of(model_.cells, [this](const Cell& cell) {
      return cell.material >= 0 && model_.materials[cell.material].density == 0.0;
    });
  };
  if (!unweighed()) return;
  for (const Index row : densities_from_masses(model_)) {
    const Material& material = model_.materials[row];
    xml_.note(xml_.root(), "the material of young " + to_decimal(material.young) + " Pa and poisson " +
                               to_decimal(material.poisson) + " has no density; " + to_decimal(material.density) +
                               " kg/m^3 follows from the masses and volumes of its cells");
  }
  if (!unweighed()) return;
  xml_.note(xml_.root(),
            "a body has young and poisson, but neither a density nor masses and volume that give one; its "
            "cells get no material");
  for (Cell& cell : model_.cells) {
    if (cell.material >= 0 && model_.materials[cell.material].density == 0.0) cell.material = -1;
  }
}

/// A mass of 0 means a body that does not move; its particles still need one.
void PmlReader::fill_immovable_bodies() {
  for (const Component& component : model_.components) {
    if (!is_immovable(component)) continue;
    for (const Index row : own_particles(model_, component)) {
      if (std::isnan(model_.mass[row])) model_.mass[row] = options_.default_mass;
    }
  }
}

}  // namespace phymul
