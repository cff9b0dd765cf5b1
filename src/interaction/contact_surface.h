// SPDX-License-Identifier: MIT
//
// What of a model can touch: the points and triangles of its bodies' surfaces. Points are particles, or weighted means
// of particles where a cut crosses a cell.
#pragma once

#include <phymul/model.h>
#include <phymul/scene.h>
#include <phymul/surface.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "model/outer_faces.h"
#include "scene/loose_parts.h"

namespace phymul {

struct ContactSurface {
  struct Particle {
    Index row = -1, body = -1;  ///< -1: not a particle, but a point of a cut cell
    double edge = 0.0;          ///< m, mean length of the surface's edges around it
    TissueVertex at{};          ///< rows of the model, and their weights
    /// Of those, in an impulse and in the velocity that it acts against: their weights, but less for copies at a cut
    /// that are far lighter than the others, which would be flung where the point hardly moves.
    std::array<double, 4> shares{1.0};
    bool of_cut = false;   ///< on a face of a cut
    Vec3 normal{0, 0, 0};  ///< at rest, of the faces of cuts that it is on, their mean; 0 where a cut ends
  };
  struct Triangle {
    std::array<Index, 3> corner{};  ///< rows of `particles`
    Index body = -1;
    double edge = 0.0;        ///< m, the longest
    bool has_inside = false;  ///< of a body of volume cells; counter-clockwise seen from outside then
    bool of_cut = false;      ///< on a face of a cut
    Vec3 normal{0, 0, 0};     ///< at rest, where it is on a face of a cut
  };
  std::vector<Particle> particles;
  std::vector<Triangle> triangles;
  VecList rest;  ///< [particles] m
  double longest_edge = 0.0;
  std::vector<Index> body_of;  ///< [N] of the model, -1: removed
  Index bodies = 0;
  std::vector<char> is_cut;  ///< [bodies] 1: it has cuts, as all pieces of a body that was cut have; empty: none has

  // Constants of contact, of all backends.
  /// Edges: what is that near at rest does not touch, in one body. A little more than the two of a lattice, so that
  /// rounding does not decide.
  static constexpr double skin_factor = 2.001;
  /// Edges: what is that far inside a body has not got in through that side of it. Likewise a little more than a cell.
  static constexpr double depth_factor = 1.001;
  /// Of the longest edge, that a triangle counts as nearer the more it faces a particle (1: from straight above): where
  /// a particle is nearest to what triangles have in common, rounding parts their distances by less. One length for all
  /// of them: by its own edges a large triangle would face more than a small one that faces better.
  static constexpr double facing_share = 1e-5;
  static constexpr double usual_skin = 0.1;  ///< of either side where the scene names none, in edges
  /// Of an overlap, and of an edge, in a step: more would press the surface in, and the body would spring back from
  /// that.
  static constexpr double parted_share = 0.05, largest_parting = 0.002;
  /// Least mobility over that without imposed and held coordinates. Below it the free motion is nearly along the
  /// surface: a particle would be thrown far aside to make little room.
  static constexpr double least_mobility = 1e-4;

  /// m: how far from what it touches a surface stays, both sides together. Nothing between bodies with cuts: what a cut
  /// has parted lies on each other at rest. At walls, which need it to know their sides, only so little between those.
  double skins(const Particle& particle, std::size_t particle_row, const Triangle& triangle, double margin) const;

  /// Whether they are the two faces of a cut, or of a notch: they face each other at rest, and neither is behind
  /// the other.
  bool are_lips(const Particle& particle, std::size_t particle_row, const Triangle& triangle) const;

  double distance_at_rest(std::size_t particle_row, const Triangle& triangle) const;  ///< m
  bool are_cut(const Particle& particle, const Triangle& triangle) const {
    return !is_cut.empty() && is_cut[particle.body] != 0 && is_cut[triangle.body] != 0;
  }

  /// Whether a particle is too near a triangle at rest to touch it: neighbours in one body do not, unless a cut parts
  /// them.
  bool is_own_skin(const Particle& particle, std::size_t particle_row, const Triangle& triangle) const;
};

/// Of bodies with cuts the surface of the tissue (tissue_surface). Bodies without any facet have particles only, whose
/// edges are the ways to their neighbours.
ContactSurface make_contact_surface(const Model& model);

/// Of the body of one scene, made anew when it has changed, once for all that touch it.
class FollowedSurface {
 public:
  std::shared_ptr<const ContactSurface> of(const Scene& scene);

 private:
  BodyRows follow(const Scene& scene);

  OuterFaces outer_;
  std::shared_ptr<const ContactSurface> made_;
  std::uint64_t body_version_ = 0;  // Scene::body_version() that it is of
};

}  // namespace phymul
