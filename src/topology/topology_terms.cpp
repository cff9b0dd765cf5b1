// SPDX-License-Identifier: MIT
#include "topology_terms.h"

#include "corner_simplices.h"

#include <phymul/error.h>

#include <algorithm>

namespace phymul {
namespace {

SpringTexel spring(const Model& model, Index i, Index j, double stiffness) {
  return {{i, j}, (model.rest[j] - model.rest[i]).norm(), stiffness};
}

}  // namespace

std::vector<SpringTexel> neighbour_springs(const Model& model) {
  std::vector<std::array<Index, 2>> pairs;
  pairs.reserve(model.neighbours.entry.size());
  for (Index i = 0; i < model.particle_count(); ++i) {
    for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) {
      pairs.push_back({std::min(i, *j), std::max(i, *j)});
    }
  }
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
  std::vector<SpringTexel> springs;
  springs.reserve(pairs.size());
  for (const auto& [i, j] : pairs) {
    springs.push_back(spring(model, i, j, (model.stiffness[i] + model.stiffness[j]) / 2));
  }
  return springs;
}

std::vector<SpringTexel> springs_around(const Model& model, const std::vector<Index>& particles) {
  std::vector<SpringTexel> springs;
  for (const Index i : particles) {
    for (const Index* j = model.neighbours.begin(i); j != model.neighbours.end(i); ++j) {
      springs.push_back(spring(model, i, *j, model.stiffness[i]));
    }
  }
  return springs;
}

std::vector<VolumeTexel> volume_terms(const Model& model, double kappa) {
  std::vector<VolumeTexel> terms;
  for (const CornerSimplex& simplex : corner_simplices(model)) {
    terms.push_back({simplex.vertex, 1.0 / simplex.volume, kappa * simplex.share});
  }
  if (terms.empty()) {
    throw Error(model.dimension == 3
                    ? "a volume term needs tetrahedra, wedges, pyramids or hexahedra; the model has none. "
                      "Set volume_stiffness to 0, or add cells"
                    : "a volume term in 2-D needs triangles or quads; the model has none. Set "
                      "volume_stiffness to 0, or add cells");
  }
  return terms;
}

}  // namespace phymul
