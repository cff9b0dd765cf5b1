// SPDX-License-Identifier: MIT
//
// Cells with flaws, and whether they were found.
#pragma once

#include <phymul/check.h>

#include <algorithm>
#include <vector>

#include "model/cell_geometry.h"

namespace phymul {

inline bool has(const std::vector<Finding>& findings, Flaw flaw) {
  return std::ranges::find(findings, flaw, &Finding::flaw) != findings.end();
}

/// Turns a cell inside out.
inline void mirror(Cell& cell) {
  const std::vector<Index> old = cell.particles;
  for (std::size_t v = 0; v < old.size(); ++v) cell.particles[v] = old[cell_reversal(cell.type)[v]];
}

}  // namespace phymul
