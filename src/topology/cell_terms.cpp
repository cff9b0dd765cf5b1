// SPDX-License-Identifier: MIT
#include "cell_terms.h"

#include <algorithm>
#include <numeric>

#include "model/cell_geometry.h"

namespace phymul {

// Moving vertex v by d changes the volume by d . integral of grad N_v, and the volume is linear in each vertex, so that
// a difference of any length gives the integral exactly.
std::array<Vec3, 8> mean_gradients(const Model& model, const Cell& cell) {
  const std::size_t count = cell.particles.size();
  std::array<Index, 8> place{};
  std::iota(place.begin(), place.end(), 0);
  const std::span<const Index> vertices(place.data(), count);
  std::array<Vec3, 8> position;
  position.fill(Vec3::Zero());
  double reach = 0.0;
  for (std::size_t v = 0; v < count; ++v) {
    position[v] = model.rest[cell.particles[v]] - model.rest[cell.particles[0]];
    reach = std::max(reach, position[v].norm());
  }
  const double volume = signed_volume(cell.type, vertices, position);
  std::array<Vec3, 8> gradient;
  gradient.fill(Vec3::Zero());
  for (std::size_t v = 0; v < count; ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      std::array<Vec3, 8> moved = position;
      moved[v][axis] += reach;
      gradient[v][axis] = (signed_volume(cell.type, vertices, moved) - volume) / (reach * volume);
    }
  }
  return gradient;
}

std::vector<CellTexel> cell_terms(const Model& model, const std::vector<Calibration>& calibration,
                                  const std::vector<CellShare>& share) {
  std::vector<CellTexel> terms;
  for (std::size_t row = 0; row < model.cells.size(); ++row) {
    const Cell& cell = model.cells[row];
    if (!is_volume(cell.type) || share[row].shape <= 0.0) continue;
    const Calibration& material = calibration[cell.material];
    const double volume = cell_volume(model, cell);
    CellTexel texel;
    std::ranges::copy(cell.particles, texel.vertex.begin());
    texel.gradient = mean_gradients(model, cell);
    texel.shape_stiffness = share[row].shape * material.c * volume;
    texel.volume_stiffness = share[row].volume * material.kappa * volume;
    terms.push_back(texel);
  }
  return terms;
}

}  // namespace phymul
