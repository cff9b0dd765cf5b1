// SPDX-License-Identifier: MIT
//
// Skin: points that move with a body: the vertices of a visible surface, landmarks, a centreline.
#pragma once

#include <phymul/model.h>

#include <span>
#include <vector>

namespace phymul {

/// Each point belongs to a cell of the body at rest and moves by the cell's shape functions (linear in tetrahedra,
/// trilinear in hexahedra), so that a body that is strained evenly strains its skin in the same way. A point outside
/// the body goes by the cell that it is least outside of. The skin does not refer to the model afterwards.
class Skin {
 public:
  /// Binds points [M], m, in the frame of Model::rest. Throws Error for a body without volume cells. Throws Error,
  /// which names the first such point, if a point is not finite or lies outside its cell by more than `most_outside`: 1
  /// is the height of a tetrahedron, the side of a hexahedron. Body and skin are then in other frames or units, most
  /// often.
  Skin(const Model& model, std::span<const Vec3> points, double most_outside = 1.0);

  std::size_t size() const { return first_.size() - 1; }

  /// Largest distance of a point from the body, in sizes of its cell; 0 if all are inside.
  double farthest_outside() const { return farthest_outside_; }

  /// Where the points are while the particles are at `position` [N], m. Of displacements it makes displacements.
  /// `points` gets size M; nothing is allocated where it has it. Throws Error for another number of particles.
  /// surface_normals() (surface.h) gives the normals of triangles of the points.
  void deform(std::span<const Vec3> position, VecList& points) const;
  VecList deform(std::span<const Vec3> position) const;

  /// Particles that a point is interpolated from, at most 8, and their weights, of sum 1.
  std::span<const Index> particles(std::size_t point) const { return {particle_.data() + first_[point], count(point)}; }
  std::span<const double> weights(std::size_t point) const { return {weight_.data() + first_[point], count(point)}; }

 private:
  std::size_t count(std::size_t point) const { return first_[point + 1] - first_[point]; }

  std::size_t particle_count_ = 0;
  std::vector<std::size_t> first_{0};  // [M + 1]
  std::vector<Index> particle_;
  std::vector<double> weight_;
  double farthest_outside_ = 0.0;
};

}  // namespace phymul
