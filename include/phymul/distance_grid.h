// SPDX-License-Identifier: MIT
//
// A closed surface as the signed distances from it at the corners of cubes: what a tool of any form is made of.
#pragma once

#include <phymul/model.h>

#include <array>
#include <memory>
#include <vector>

namespace phymul {

/// Distances in m, negative inside, linear between the corners. Written once, shared by any number of tools.
class DistanceGrid {
 public:
  /// [count.z][count.y][count.x] values from `origin` on, `spacing` apart. Throws Error for fewer than 2 corners along
  /// an axis, values that do not fit or are not finite, or no value below 0.
  DistanceGrid(const Vec3& origin, double spacing, const std::array<int, 3>& count, std::vector<float> values);

  const Vec3& origin() const { return origin_; }
  double spacing() const { return spacing_; }
  const std::array<int, 3>& count() const { return count_; }
  const std::vector<float>& values() const { return values_; }
  double depth() const { return depth_; }  ///< m: of the deepest corner inside
  bool operator==(const DistanceGrid&) const = default;

 private:
  Vec3 origin_;
  double spacing_ = 0.0;
  std::array<int, 3> count_{};
  std::vector<float> values_;
  double depth_ = 0.0;
};

/// Of the model's triangles and quads (cut in two), or where it has volume cells, of their surface: exact distances to
/// the triangles, computed in double precision, on cubes of edge `spacing` with two more around the shape. The tool's
/// frame is the model's. Throws Error for a surface that is not closed or not wound one way, and names an edge; for a
/// spacing that gives too many cubes, or too few for the shape to have an inside.
std::shared_ptr<const DistanceGrid> make_distance_grid(const Model& surface, double spacing);

}  // namespace phymul
