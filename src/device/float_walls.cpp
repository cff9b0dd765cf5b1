// SPDX-License-Identifier: MIT
#include "float_walls.h"

#include <algorithm>

#include "float_range.h"
#include "topology/transpose.h"

namespace phymul {
namespace {

void pack_law(const WallTexel& wall, std::vector<Float4>& law) {
  law.push_back(texel(wall.tangent[0], wall.shear));
  law.push_back(texel(wall.tangent[1], wall.compliance));
  for (std::size_t ab = 0; ab < 3; ++ab) law.push_back(texel(wall.second[ab], wall.bending[ab]));
  const auto twist = [&](std::size_t vertex) { return wall.hessian[vertex][2]; };
  for (std::size_t k = 1; k < 6; ++k) {
    law.push_back(texel({wall.gradient[k][0], wall.gradient[k][1], wall.hessian[k][0]}, wall.hessian[k][1]));
  }
  law.push_back(texel({twist(1), twist(2), twist(3)}, twist(4)));
  law.push_back(texel({twist(5), wall.bending[3], wall.bending[4]}, wall.bending[5]));
}

}  // namespace

FloatWalls pack_walls(const TopologyTextures& topology) {
  FloatWalls to;
  std::vector<const WallTexel*> walls;
  for (const WallTexel& wall : topology.walls) {
    if (wall.shear != 0.0) walls.push_back(&wall);
  }
  if (walls.empty()) return to;
  for (const WallTexel* const wall : walls) {
    std::array<Index, 6> v = wall->vertex;
    std::ranges::replace(v, none, v[0]);
    to.vertex.push_back({v[0], v[1], v[2], v[3]});
    to.vertex.push_back({v[4], v[5], none, none});
    pack_law(*wall, to.law);
  }
  to.entries = transpose(topology.particle_count, to.count(), 8, [&](Index row, Index corner) {
    return corner < 6 ? walls[row]->vertex[static_cast<std::size_t>(corner)] : none;
  });
  return to;
}

}  // namespace phymul
