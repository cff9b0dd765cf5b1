// SPDX-License-Identifier: MIT
#include <algorithm>
#include <numeric>

#include "calibrated_bases.h"
#include "cell_geometry.h"

namespace phymul {
namespace {

// Mean of grad N_v over the cell, 1/m. Moving vertex v by d changes the volume by d . integral of grad N_v, and the
// volume is linear in each vertex, so a difference of any length gives the integral exactly.
CellTexel mean_gradient(const Model& model, const Cell& cell) {
  const std::size_t count = cell.particles.size();
  std::array<Index, 8> place{};
  std::iota(place.begin(), place.end(), 0);
  const std::span<const Index> vertices(place.data(), count);
  std::array<Vec3, 8> position{};
  double reach = 0.0;
  for (std::size_t v = 0; v < count; ++v) {
    position[v] = model.rest[cell.particles[v]] - model.rest[cell.particles[0]];
    reach = std::max(reach, position[v].norm());
  }
  const double volume = signed_volume(cell.type, vertices, position);
  CellTexel texel;
  for (std::size_t v = 0; v < count; ++v) {
    texel.vertex[v] = cell.particles[v];
    texel.gradient[v].setZero();
    for (int axis = 0; axis < 3; ++axis) {
      std::array<Vec3, 8> moved = position;
      moved[v][axis] += reach;
      texel.gradient[v][axis] = (signed_volume(cell.type, vertices, moved) - volume) / (reach * volume);
    }
  }
  for (std::size_t v = count; v < 8; ++v) texel.gradient[v].setZero();
  return texel;
}

}  // namespace

std::vector<CellTexel> cell_terms(const Model& model, const std::vector<Calibration>& calibration, double share) {
  std::vector<CellTexel> terms;
  for (const Cell& cell : model.cells) {
    if (!is_volume(cell.type)) continue;
    const Calibration& material = calibration[cell.material];
    const double volume = cell_volume(model, cell);
    CellTexel texel = mean_gradient(model, cell);
    texel.shape_stiffness = share * material.c * volume;
    texel.volume_stiffness = share * material.kappa * volume;
    terms.push_back(texel);
  }
  return terms;
}

}  // namespace phymul
