// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/topology_textures.h>

#include <array>
#include <vector>

namespace phymul {

/// Mean over a volume cell of the gradients of its shape functions, 1/m; zero beyond its vertices.
std::array<Vec3, 8> mean_gradients(const Model& model, const Cell& cell);

/// How much of a cell's calibrated energy is taken from its mean deformation, 0 to 1.
struct CellShare {
  double shape = 0.0;
  double volume = 0.0;
};

/// Mean-gradient terms of the volume cells with a share, stiffness c V and kappa V times it. Shape of `share`: one per
/// row of Model::cells.
std::vector<CellTexel> cell_terms(const Model& model, const std::vector<Calibration>& calibration,
                                  const std::vector<CellShare>& share);

}  // namespace phymul
