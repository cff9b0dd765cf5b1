// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "base/decimal.h"
#include "model/body_type.h"
#include "pml_bodies.h"
#include "pml_reader.h"

namespace phymul {

/// Masses, and no shape stiffness where the component's is that of its springs. A mass of 0 means a body that does not
/// move, whose particles still need one.
void PmlReader::take_body_constants() {
  for (const Component& component : model_.components) {
    const std::string_view type = body_type(component);
    if (type.empty() || type == "interaction") continue;
    const std::optional<double> mass = parse_decimal(attribute_of(component, "mass"));
    for (const Index row : own_particles(model_, component)) {
      if (mass && std::isnan(model_.mass[row])) model_.mass[row] = *mass > 0.0 ? *mass : options_.default_mass;
      if (type != "FEM" && std::isnan(model_.stiffness[row])) model_.stiffness[row] = 0.0;
    }
  }
}

void PmlReader::finish_densities() {
  for (const Index row : densities_from_masses(model_)) {
    const Material& material = model_.materials[row];
    xml_.note(xml_.root(), "the material of young " + to_decimal(material.young) + " Pa and poisson " +
                               to_decimal(material.poisson) + " has no density; " + to_decimal(material.density) +
                               " kg/m^3 follows from the masses and volumes of its cells");
  }
}

}  // namespace phymul
