// SPDX-License-Identifier: MIT
//
// The attribute bodyType of a component. SOFA's reader of PML tells bodies apart by it: "FEM" is an elastic solid,
// "stiffSpring" a net of springs, "rigid" a rigid body, "interaction" springs between two bodies. There are others.
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

/// Rigid, or a body of mass 0.
bool is_immovable(const Component& component);

/// A solid with young and poisson, but no density.
bool needs_density(const Component& component);

/// Cells that the component has or refers to; particles of these and those it lists, sorted, each once.
std::vector<Index> cells_of(const Component& component);
std::vector<Index> particles_of(const Model& model, const Component& component);

/// [cells] 1: springs between bodies, which make one body of them as little as joints do.
std::vector<char> interaction_cells(const Model& model);

/// Cells that need no material, and particles that need no cell with one: those of bodies that are no movable solids.
std::vector<char> cells_without_tissue(const Model& model);
std::vector<char> particles_without_tissue(const Model& model);

}  // namespace phymul
