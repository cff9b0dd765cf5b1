// SPDX-License-Identifier: MIT
//
// The shape of a tool: its bounds, its distance function, the particles that it can grasp. least_margin() of
// <phymul/tool.h> is defined here as well.
#pragma once

#include <phymul/tool.h>

#include <optional>
#include <string_view>
#include <vector>

#include "distance_to_shape.h"

namespace phymul {

/// A tool's shape in numbers, in its own frame; nothing of a needle, edge and sides of a blade.
struct ToolExtent {
  Vec3 size{0, 0, 0};                // m; sphere: radius; capsule: radius, length; box: half sizes
  double thickness = 0.0;            // m: a way shorter than half of it cannot pass through
  Vec3 low{0, 0, 0}, high{0, 0, 0};  // m: around it and its margin
};

ToolExtent extent_of(const Tool& tool);

/// What makes a tool more than a shape that pushes particles out or holds them: "is a needle". Empty: nothing.
std::string_view beyond_pressing(const Tool& tool);

/// The edge of a blade in the tool's frame. `along`: m, along the edge as seen along z, from its middle.
class BladeCurve {
 public:
  explicit BladeCurve(const Blade& blade);
  double length() const { return length_; }  ///< m, as seen along z
  Vec3 at(double along) const;
  /// The unit vector across the edge in the surface that it cuts.
  Vec3 way(double along) const;
  Vec3 normal(double along) const;  ///< of the surface that it cuts, on the side of +y
  /// Length of the edge over its length as seen along z.
  double stretch(double along) const;
  /// m: along the edge, off the surface that it cuts, behind the edge.
  Vec3 unrolled(const Vec3& x) const;

 private:
  double slope(double along) const;
  double behind(double along) const;

  double length_ = 0.0;
  double bend_ = 0.0, radius_ = 0.0;  // m, radii of belly and bow with their signs; 0: straight
};

/// m: a ball of this radius goes wherever the shape goes through a surface, 0 for a DistanceGrid; empty for a
/// HalfSpace, a Needle and a Blade, which do not go through.
std::optional<double> least_radius(const ToolShape& shape);

struct GraspedParticle {
  Index particle = 0;
  Vec3 at{0, 0, 0};  ///< in the tool's frame, m
};

/// The particles whose position is inside the tool or within `distance`, m, of its surface, in order. The tool must not
/// be a needle. For backends whose positions are on a device.
std::vector<GraspedParticle> particles_to_grasp(const Tool& tool, const ToolPose& pose, double distance,
                                                const VecList& position);

/// As distance_to() takes it; points to the values of a grid, which must outlive it. Nothing of a needle.
ShapeIn<double> shape_of(const Tool& tool);

}  // namespace phymul
