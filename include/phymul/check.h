// SPDX-License-Identifier: MIT
//
// The mesh check at load: finds what makes simulations fail later, mends what has one right answer.
#pragma once

#include <phymul/model.h>

#include <string>
#include <vector>

namespace phymul {

enum class Flaw {
  winding,          ///< cell with negative volume; turned round
  tangled,          ///< cell that overlaps a neighbour, however both are wound; refused
  degenerate_cell,  ///< volume (area) below 1e-6 of its longest edge cubed (squared), infinite, or a vertex repeated
  duplicate_cell,   ///< two cells over the same particles
  duplicate_point,  ///< two particles closer than 1e-9 of the body size
  massless,         ///< particle whose mass is below 1e-9 of the mean, but not 0: spare, or its cells are removed
  isolated,         ///< particle without neighbours, or in no cell although others are
  few_neighbours,   ///< fewer than 3 neighbours (2 in 2-D), or all of them on one line
  self_neighbour,   ///< particle among its own neighbours; removed
  suspect_units     ///< body larger than 10 m or smaller than 10 micrometres: mm read as m, or the reverse
};

struct Finding {
  Flaw flaw;
  std::vector<Index> items;  ///< particles or cells, as the flaw says; all of them
  bool mended = false;
  std::string message;  ///< one sentence: what, how many, the first few by their file index, what was done or to do
};

/// Looks for every flaw; changes nothing. Expects a model that validate accepts. Of duplicates both sides are listed; a
/// particle without neighbours is both isolated and short of them. Lists (poly_line, poly_vertex, atom) are not looked
/// at.
std::vector<Finding> find_flaws(const Model& model);

/// Turns wrongly wound cells, removes self-neighbours; returns all findings and appends their messages to
/// model.notes, each after `source` and ": " where a source is given. Throws Error, and changes nothing, for tangled
/// cells: no order of their vertices makes them lie beside their neighbours.
std::vector<Finding> check_mesh(Model& model, const std::string& source = {});

}  // namespace phymul
