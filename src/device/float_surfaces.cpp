// SPDX-License-Identifier: MIT
#include "float_surfaces.h"

#include <algorithm>
#include <map>

#include "interaction/contact_points.h"

namespace phymul {
namespace {

/// Tools share their patches and differ in the points of these.
void add_patches(const cpu::ContactPoints& points, FloatSurfaces& made) {
  for (const cpu::ContactPoints::Patch& patch : points.patches) {
    made.corners.push_back({patch.corner[0], patch.corner[1], patch.corner[2], -1});
  }
  for (std::size_t particle = 0; particle + 1 < points.patch_first.size(); ++particle) {
    const auto first = static_cast<Index>(points.patch_first[particle]),
               end = static_cast<Index>(points.patch_first[particle + 1]);
    made.ranges.push_back({first, end, 0, 0});
    for (Index row = first; row < end; ++row) {
      const Index patch = points.patch_of[static_cast<std::size_t>(row)];
      const auto& corner = points.patches[static_cast<std::size_t>(patch)].corner;
      const auto own = std::ranges::find(corner, static_cast<Index>(particle)) - corner.begin();
      made.around.push_back({patch, static_cast<Index>(own), 0, 0});
    }
  }
}

}  // namespace

FloatSurfaces pack_surfaces(const Scene& scene) {
  FloatSurfaces made;
  std::map<const std::vector<cpu::ContactPoints::Shares>*, Index> first_of;  // which all tools share
  for (const SceneTool& tool : scene.tools()) {
    made.law_of.push_back(-1);
    if (tool.tool.contact != ToolContact::surface) continue;
    const cpu::ContactPoints points = cpu::make_contact_points(scene.model(), tool.tool);
    if (made.empty()) add_patches(points, made);
    made.law_of.back() = static_cast<int>(made.laws.size());
    for (const cpu::ContactPoints::Patch& patch : points.patches) {
      const auto [known, is_new] = first_of.try_emplace(patch.points, static_cast<Index>(made.points.size()));
      for (const auto& share : *patch.points) {
        if (is_new) {
          made.points.push_back(
              {static_cast<float>(share[0]), static_cast<float>(share[1]), static_cast<float>(share[2]), 0.0f});
        }
      }
      const Index end = known->second + static_cast<Index>(patch.points->size());
      made.laws.push_back({known->second, end, bits_of(static_cast<float>(patch.area)), 0});
    }
  }
  return made;
}

}  // namespace phymul
