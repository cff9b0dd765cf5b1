// SPDX-License-Identifier: MIT
//
// Blade: a tool shape that cuts a body of tetrahedra, or walls (Simulation).
#pragma once

#include <phymul/types.h>

#include <array>

namespace phymul {

/// An edge in the tool's frame, which cuts toward -z. Its middle is the tool's position, its ends are `width` apart
/// along x. It is straight and cuts the plane y = 0, or an arc: `belly` bends it within that plane (a scalpel), `bow`
/// bends the plane itself, so that the edge is a gouge or a loop of wire. Behind it are sides that rub, or nothing.
struct Blade {
  double width = 0.0;      ///< m, > 0
  double toughness = 0.0;  ///< J/m^2, >= 0, work per area of cut. Tissue goes with the edge until the force is that
                           ///< much per length of edge in it, N/m: a large one is a dull blade. 0: cuts what it meets.
                           ///< In a wall the length of edge is the wall's thickness, more where the edge leans
  double belly = 0.0;   ///< m, by how much the ends are behind the middle, in z; at most width / 2. Below 0: before it
                        ///< (a sickle)
  double bow = 0.0;     ///< m, by how much the ends are aside of the middle, toward -y; at most width / 2, which is
                        ///< half a circle. Spacings of the body should be below the radius
  double height = 0.0;  ///< m, of the sides behind the edge
  double friction = 0.0;  ///< N/m^2, with which tissue resists the motion of the sides in it, per area of both together
  bool operator==(const Blade&) const = default;
};

/// Part of ToolState: a point of the edge and the tissue ahead of it that it holds, or of the sides and where it is in
/// the tissue.
struct BladePoint {
  Index place = -1;                 ///< of the points along the edge, then on the sides, ascending
  Index cell = -1;                  ///< row of Model::cells; what is cut is named by the row that it had
  std::array<double, 4> weights{};  ///< barycentric coordinates in it
  double along = 0.0;               ///< m, from the middle of the edge
  double ahead = 0.0;               ///< m, of the edge; below 0 on the sides
  bool slides = false;              ///< the force was at its limit in the last step
  bool operator==(const BladePoint&) const = default;
};

}  // namespace phymul
