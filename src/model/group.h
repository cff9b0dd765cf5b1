// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/error.h>
#include <phymul/model.h>
#include <phymul/types.h>

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace phymul {

/// Throws Error for the first index that is not from 0 to count - 1. `what` they are: "particles". `label()` says
/// where, with a colon and a blank behind it; it is asked only then.
template <class Indices, class Label>
void require_indices(const Indices& indices, std::size_t count, const char* what, const Label& label,
                     ErrorCode code = ErrorCode::invalid_argument) {
  for (const Index index : indices) {
    if (index >= 0 && static_cast<std::size_t>(index) < count) continue;
    throw Error(code, label() + "expected " + what + " from 0 to " + std::to_string(static_cast<long long>(count) - 1) +
                          ", got " + std::to_string(index));
  }
}

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
