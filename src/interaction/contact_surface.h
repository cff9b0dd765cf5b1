// SPDX-License-Identifier: MIT
//
// What of a model can touch: the particles and triangles of its bodies' surfaces.
#pragma once

#include <phymul/model.h>

#include <array>
#include <vector>

namespace phymul {

struct ContactSurface {
  struct Particle {
    Index row = -1, body = -1;
    double edge = 0.0;  ///< m, mean length of the surface's edges around it
  };
  struct Triangle {
    std::array<Index, 3> corner{};  ///< rows of `particles`
    Index body = -1;
    double edge = 0.0;        ///< m, the longest
    bool has_inside = false;  ///< of a body of volume cells; counter-clockwise seen from outside then
  };
  std::vector<Particle> particles;
  std::vector<Triangle> triangles;
  VecList rest;  ///< [particles] m
  double longest_edge = 0.0;

  // Constants of contact, of all backends.
  /// Edges: what is that near at rest does not touch, in one body. A little more than the two of a lattice, so that
  /// rounding does not decide.
  static constexpr double skin_factor = 2.001;
  /// Edges: what is that far inside a body has not got in through that side of it. Likewise a little more than a cell.
  static constexpr double depth_factor = 1.001;
  /// Of the longest edge, that a triangle counts as nearer the more it faces a particle (1: from straight above): where
  /// a particle is nearest to what triangles have in common, rounding parts their distances by less. One length for all
  /// of them: by its own edges a large triangle would face more than a small one that faces better. See DESIGN.md.
  static constexpr double facing_share = 1e-5;
  static constexpr double usual_skin = 0.1;  ///< of either side where the scene names none, in edges
  /// Of an overlap, and of an edge, in a step: more would press the surface in, and the body would spring back from
  /// that.
  static constexpr double parted_share = 0.05, largest_parting = 0.002;

  /// Whether a particle is too near a triangle at rest to touch it: neighbours in one body do not.
  bool is_own_skin(const Particle& particle, std::size_t particle_row, const Triangle& triangle) const;
};

/// Bodies without any facet have particles only, whose edges are the ways to their neighbours.
ContactSurface make_contact_surface(const Model& model);

}  // namespace phymul
