// SPDX-License-Identifier: MIT
//
// Which triangles a particle may touch, found with a reach larger than a step needs and kept while that holds. What is
// asked of them at each step costs as much as there is to touch; what is not near is looked for once in many steps.
//
// Why they hold: a particle p and a point of a triangle, a mean of its corners, come nearer to each other by no more
// than the difference of their displacements since. All displacements lie in one box, so it is no more than the box's
// diagonal, whatever moves together. A pair that a step with `margin` asks for is nearer than
//   L(margin) = max(margin + its skins, how deep inside is inside),
// so it was nearer than L(margin) + diagonal, and is listed where that is no more than L(margin then) + slack.
#pragma once

#include <phymul/scene.h>

#include <span>
#include <vector>

#include "../contact_surface.h"
#include "point_grid.h"

namespace phymul::cpu {

class ContactCandidates {
 public:
  /// Candidates of a particle: rows of the surface.
  struct List {
    std::size_t particle = 0;
    std::span<const Index> triangles;  // in no order
  };

  /// Takes over a surface, which must outlive this or the next follow(). Allocates.
  void follow(const ContactSurface& surface, const ContactOptions& options);

  /// Calls visit(List) for each particle of the surface that may touch something with its gap within `margin`, m;
  /// ascending. Triangles that its own body's skin leaves out are not among them; what is not finite touches nothing.
  template <class Visit>
  void each(std::span<const Vec3> place, double margin, Visit visit) {
    if (hold(place, margin)) {
      for (const Kept& kept : kept_) visit(List{kept.particle, {listed_.data() + kept.first, kept.count}});
      return;
    }
    begin(place, margin);
    for (std::size_t k = 0; k < place.size() && !meant_.empty(); ++k) {
      gather(k, place[k]);
      if (near_.empty()) continue;
      keep(k);
      visit(List{k, near_});
    }
  }

  std::size_t searches() const { return searches_; }  ///< since follow()

 private:
  struct Box {
    Vec3 low{0, 0, 0}, high{0, 0, 0};
  };
  struct Kept {
    std::size_t particle = 0, first = 0, count = 0;
  };

  bool hold(std::span<const Vec3> place, double margin) const;
  void begin(std::span<const Vec3> place, double margin);
  void measure(std::span<const Vec3> place);
  bool meets_another(Index body, const Box& box) const;
  void gather(std::size_t particle, const Vec3& x);
  void keep(std::size_t particle);
  double reach_of(const ContactSurface::Particle& own, const ContactSurface::Triangle& triangle) const;

  const ContactSurface* surface_ = nullptr;
  ContactOptions options_;
  double mean_edge_ = 0.0;  // m, of the surface's particles
  std::size_t most_ = 0;    // entries of listed_ that are worth their memory
  std::size_t searches_ = 0;

  // Of the last search.
  bool complete_ = false;                            // all that it found is kept, and was finite
  double margin_ = 0.0, slack_ = 0.0, reach_ = 0.0;  // m; reach_: the largest of any pair, with slack
  VecList then_;                                     // [particles] where they were
  std::vector<Kept> kept_;
  std::vector<Index> listed_;

  // For the search.
  std::vector<Box> around_;   // [bodies]
  std::vector<Box> box_;      // [triangles] around them, and a little more than rounding makes of a distance
  std::vector<Index> meant_;  // triangles in the grid: without contact of a body with itself those near another
  VecList middle_;            // of their boxes
  PointGrid grid_;
  std::vector<Index> near_;       // of the particle in question
  std::vector<double> furthest_;  // [bodies] m, of the pairs of the particle in question; 0: none
  std::vector<Index> met_;        // bodies where it is not 0
};

}  // namespace phymul::cpu
