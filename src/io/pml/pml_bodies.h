// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/model.h>

#include <vector>

namespace phymul {

/// True for the cells that are springs between bodies, which makes no neighbours of their ends.
std::vector<char> interaction_cells(const Model& model);

/// Gives every material without a density (0) the mass of its cells by their volume; the mass of a particle counts by
/// the share of its cells that have the material. A material of no volume, or of a particle without a mass (NaN),
/// gets none. Cells of equal materials then have the first of them. Returns the rows that got a density.
std::vector<Index> densities_from_masses(Model& model);

}  // namespace phymul
