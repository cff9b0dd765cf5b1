// SPDX-License-Identifier: MIT
//
// Where tools with ToolContact::surface touch bodies: at points that are fixed to the triangles of a surface, each a
// mean of three particles, or of up to four where a cut crosses a cell. Bodies without triangles are touched at their
// particles.
#pragma once

#include <phymul/tool.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "contact_surface.h"

namespace phymul {

struct ContactPoints {
  using Shares = std::array<double, 4>;  // of a patch's corners in a point, sum 1

  struct Patch {                    // a triangle, or a particle
    std::array<Index, 4> corner{};  // rows of the model: the particles that its points are means of, `corners` of them
    int corners = 0;
    bool of_cut_cell = false;  // its corners are particles of a cell, not of a triangle
    std::shared_ptr<const std::vector<Shares>> points{};
    double area = 0.0;  // m^2 of the rest surface that each of its points stands for; a particle's is 1
    std::span<const Index> particles() const { return {corner.data(), static_cast<std::size_t>(corners)}; }
  };
  std::vector<Patch> patches;
  std::vector<std::size_t> patch_first;  // [N + 1] of a particle in patch_of
  std::vector<Index> patch_of;           // rows of the patches that have it, ascending
  std::size_t most_points = 0;           // sum over all patches
};

/// Points of a triangle are the centres of its k^2 like parts, k from 3 to 12: their distance, about the longest edge
/// over k, is to be at most a third of `least_radius`, m, so that a tool of that radius does not pass between them
/// where they are drawn apart. `least_radius` may be infinite; 0: not known, k is 6.
ContactPoints make_contact_points(const ContactSurface& surface, double least_radius);

/// m: the six planes of a box, of which low is negative and high positive.
struct BoxPlanes {
  Vec3 low, high;
};

/// The face of a box that is its nearest surface to a place inside or before it: twice its axis, one more at the
/// negative end; -1: the place is over an edge. Places of one face are convex: a triangle whose corners are there
/// touches no other.
inline int face_of(const BoxPlanes& box, const Vec3& q) {
  int nearest = 0, before = 0;
  double least = -HUGE_VAL;  // m, that the place is off that face
  for (int axis = 0; axis < 3; ++axis) {
    const double above = q[axis] - box.high[axis], below = box.low[axis] - q[axis], off = std::max(above, below);
    before += off > 0.0 ? 1 : 0;
    if (off > least) {
      least = off;
      nearest = 2 * axis + (below > above ? 1 : 0);
    }
  }
  return before > 1 ? -1 : nearest;
}

/// Integrals of a triangle's depth below the nearest face of a box, over what of the triangle is in it.
struct DepthInBox {
  double square = 0.0, whole = 0.0;  // m^4, of the squared depth; m^3, of the depth
  Vec3 load{0, 0, 0};                // m^3: of the depth times the share of each corner
  Mat3 push = Mat3::Zero();          // m^3, a column for each corner: likewise, times the face's normal
};

/// Exact: the parts of the triangle whose nearest surface is one face are convex, and the depth is linear in each.
/// All change continuously with the places. `push` is minus half the gradient of `square` by the corners' places.
/// `corner`, m: of the triangle, in the box's frame; `area`, m^2: of the triangle.
DepthInBox depth_in(const BoxPlanes& box, const std::array<Vec3, 3>& corner, double area);

/// A point of a triangle at which integrals over its depth in a box are evaluated.
struct DepthPoint {
  ContactPoints::Shares share{};
  double weight = 0.0;  // m^2: of the integral over the area; 0: of a line
  double depth = 0.0;   // m
  int face = 0;         // twice the axis of the nearest face, one more at the low end
  // A line between parts whose nearest surfaces are two faces: the integral of `depth` times Dirac's function of the
  // difference of both depths. m^2.
  int other_face = -1;
  double line_weight = 0.0;
};

/// Calls visit(DepthPoint): the integral of the squared depth has the first derivatives of the sum over points, and
/// with those of lines, by minus the square of what the difference of both depths changes, the second. Exact. `area`:
/// m^2, of the triangle. Points have a weight above 0.
void integrate_depth(const BoxPlanes& box, const std::array<Vec3, 3>& corner, double area,
                     const std::function<void(const DepthPoint&)>& visit);

/// As the tool's radius and margin ask for.
ContactPoints make_contact_points(const ContactSurface& surface, const Tool& tool);

/// All particles, as of ToolContact::particles.
ContactPoints make_particle_points(const Model& model);

}  // namespace phymul
