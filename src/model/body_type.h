// SPDX-License-Identifier: MIT
//
// The attribute bodyType of a component, by which SOFA's reader of PML tells what a body is: an elastic solid ("FEM"),
// a net of springs ("stiffSpring"), a rigid body ("rigid"), or springs between two bodies ("interaction").
#pragma once

#include <phymul/model.h>

#include <string_view>
#include <vector>

namespace phymul {

/// Value of an attribute of a component; data() is null where it has none.
std::string_view attribute_of(const Component& component, std::string_view name);

/// Empty where the file does not say.
inline std::string_view body_type(const Component& component) {
  return attribute_of(component, "bodyType");
}

/// Rigid, or of mass 0.
bool is_immovable(const Component& component);

/// Particles of the component's own cells and those it lists, sorted, each once.
std::vector<Index> own_particles(const Model& model, const Component& component);

/// Cells that need no material, and particles that need no cell with one: of nets of springs and of bodies that do not
/// move; also the cells between bodies.
std::vector<char> cells_without_tissue(const Model& model);
std::vector<char> particles_without_tissue(const Model& model);

}  // namespace phymul
