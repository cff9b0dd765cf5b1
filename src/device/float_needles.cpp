// SPDX-License-Identifier: MIT
#include "float_needles.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "model/surface_facets.h"
#include "scene/needle_measures.h"

namespace phymul {
namespace {

/// Spacings: as far as weights reach that were made wider by half until their particles span space, on a lattice.
constexpr double widest = 2.25;

/// A ball of this radius lies in 27 cells of that side about its middle's, wherever it is: at rest no more than this
/// can be in it.
int most_within(double radius, const Model& model) {
  using Cell = std::array<int, 3>;
  std::map<Cell, int> own, around;
  for (const Vec3& X : model.rest) {
    const Vec3 q = ((X - model.rest.front()) / radius).array().floor();
    ++own[{static_cast<int>(q.x()), static_cast<int>(q.y()), static_cast<int>(q.z())}];
  }
  int most = 0;
  for (const auto& [cell, count] : own) {
    for (int k = 0; k < 27; ++k) {
      int& sum = around[{cell[0] + k / 9 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k % 3 - 1}];
      sum += count;
      most = std::max(most, sum);
    }
  }
  return most;
}

}  // namespace

FloatNeedles::FloatNeedles(const Scene& scene) {
  const Model& model = scene.model();
  for (std::size_t row = 0; row < scene.tools().size(); ++row) {
    const Tool& tool = scene.tools()[row].tool;
    const auto* const needle = std::get_if<Needle>(&tool.shape);
    if (!needle) continue;
    One one{.tool = static_cast<int>(row), .needle = *needle, .friction = tool.friction};
    one.spread = needle_spread(*needle, model);
    one.reach = needle_support_radius(one.spread, model);
    const double inside = std::min(needle->length, body_size(model));
    one.nodes = static_cast<int>(std::min(8.0 + 2.0 * std::ceil(inside / one.spread), double{most_nodes}));
    one.particles = most_within(std::max(one.reach, widest * needle_spacing(model)), model);
    needles.push_back(one);
  }
  if (!needles.empty()) facets = outward_triangles(model);
}

}  // namespace phymul
