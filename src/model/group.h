// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

/// [cells] 1: a cell of a type that `fits` (those that fill space by default) that set_material(model, material,
/// group_name) means. Throws Error for an unknown name.
std::vector<char> cells_of_group(const Model& model, std::string_view group_name,
                                 const std::function<bool(CellType)>& fits = {});

/// All particles with only the cells that a group means: those of cells_of_group(), or, if it has none, every cell
/// whose particles are all in it, as of a closed surface. Throws Error for an unknown name.
Model part_of(const Model& model, std::string_view group_name);

/// Adds an informative component with these cells. Throws Error for an empty name.
void add_cell_group(Model& model, std::string group_name, std::vector<Index> cells);

}  // namespace phymul
