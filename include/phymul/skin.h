// SPDX-License-Identifier: MIT
//
// Skin: points that move with a body: the vertices of a visible surface, landmarks, a centreline.
#pragma once

#include <phymul/model.h>
#include <phymul/surface.h>

#include <cstdint>
#include <span>
#include <vector>

namespace phymul {

/// Each point belongs to a cell of the body at rest and is interpolated by the cell's shape functions (linear in
/// tetrahedra, trilinear in hexahedra). A uniform strain of the body is therefore also that of the skin. A point
/// outside belongs to the nearest cell, in sizes of the cell, and is extrapolated. The model is not needed afterwards.
class Skin {
 public:
  /// Binds points [M], m, in the frame of Model::rest. `most_outside`: largest distance of a point from its cell, in
  /// sizes of the cell (height of a tetrahedron, side of a hexahedron). Throws Error for a body without volume cells,
  /// and for the first point that is not finite or is farther outside; its frame or unit is then usually wrong.
  Skin(const Model& model, std::span<const Vec3> points, double most_outside = 1.0);

  /// The vertices of tissue_surface(model): a body that has been cut, to be shown with the surface's triangles. Made
  /// anew after each cut. Throws Error for a particle that the model does not have.
  Skin(const Model& model, const TissueSurface& surface);

  std::size_t size() const { return first_.size() - 1; }

  /// Whether its points were bound to this body: a model of the same Model::rest.
  bool is_bound_to(const Model& model) const;

  /// Largest distance of a point from the body, in sizes of its cell; 0 if all are inside.
  double farthest_outside() const { return farthest_outside_; }

  /// Positions of the points, [M] m, for particles at `position` [N], m. From displacements it computes displacements.
  /// Resizes `points` to M; does not allocate if it has that size. Throws Error for another number of particles.
  /// surface_normals() (surface.h) gives the normals of triangles of the points.
  void deform(std::span<const Vec3> position, VecList& points) const;
  VecList deform(std::span<const Vec3> position) const;

  /// Particles that a point (< size()) is interpolated from, at most 8, and their weights, of sum 1. Valid as the skin.
  std::span<const Index> particles(std::size_t point) const { return {particle_.data() + first_[point], count(point)}; }
  std::span<const double> weights(std::size_t point) const { return {weight_.data() + first_[point], count(point)}; }

 private:
  friend class StateTransfer;
  /// The particles of another body, each in the cell that holds its tissue; those without mass are bound to nothing.
  Skin(const Model& model, const Model& other, double most_outside);
  void bind(std::span<const Index> particles, std::span<const double> weights);
  std::size_t count(std::size_t point) const { return first_[point + 1] - first_[point]; }

  std::size_t particle_count_ = 0;
  std::uint64_t rest_hash_ = 0;
  std::vector<std::size_t> first_{0};  // [M + 1]
  std::vector<Index> particle_;
  std::vector<double> weight_;
  double farthest_outside_ = 0.0;
};

}  // namespace phymul
