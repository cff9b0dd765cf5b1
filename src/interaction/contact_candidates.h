// SPDX-License-Identifier: MIT
//
// Which triangles a particle may touch, found with a larger search distance than a step needs and kept while that
// holds. What a step asks of them is in proportion to what is near; what may come near is looked for once in many
// steps.
//
// Why they hold: a particle and a point of a triangle, a mean of its corners, come nearer to each other by no more than
// their displacements since differ. All displacements lie in one box, so that is no more than the box's diagonal,
// whatever moves together. A pair counts in a step with `margin` where it is no further apart than
//   L(margin) = max(margin + its skins, how deep inside is inside).
// It was no further than L(margin) + diagonal apart then, and what was no further than L(margin then) + slack is kept.
//
// Why a search looks at little of a particle's own body: but for the faces of cuts, what may touch it there was further
// than its skin at rest. It still is where both have hardly moved against each other but for a rotation of the body.
//
// Why lists outlive an edit of the body: places then need not have been, as long as displacements since lie in the box.
// So a point that comes with the edit gets such a place, and only what is near new or changed triangles is looked for.
#pragma once

#include <phymul/scene.h>

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "base/box_tree.h"
#include "contact_surface.h"

namespace phymul {

class ContactCandidates {
 public:
  struct Near {
    Index triangle = -1;
    double least = 0.0;  // m: it was no nearer at the search
  };
  /// Of one particle those of one body; rows of the surface.
  struct List {
    std::size_t particle = 0;
    double nearer = 0.0;              // m: what may have come nearer since
    std::span<const Near> triangles;  // those of least `least` first
  };

  /// Takes over a surface, which must outlive the calls of each(). `before`: that of the call before, if it is still
  /// there: lists of what is the same in both stay. Allocates.
  void follow(const ContactSurface& surface, const ContactOptions& options, const ContactSurface* before = nullptr);
  /// Other options for the same surface.
  void change(const ContactOptions& options);

  /// Calls visit(List), in no order, for each particle and body whose gap may be within `margin`, m, with the triangles
  /// of that body that may be nearest to it. What the skin of a particle's own body leaves out is in no list; what is
  /// not finite touches nothing. `margin` is twice what the fastest particle goes in a step: two come nearer to each
  /// other by no more. visit() returns a gap, m, and is not called again before motion may have brought that within a
  /// margin. `gone`: PredictedStep::gone(), m. Allocates while lists grow, and in the first call after
  /// follow() kept lists.
  template <class Visit>
  void each(std::span<const Vec3> place, double margin, double gone, Visit visit) {
    double least = HUGE_VAL;
    least_until_ = -HUGE_VAL;  // where visit throws
    if (!to_search_.empty()) search_what_is_new(place, margin);
    if (hold(place, margin)) {
      see(place, gone);
      for (Kept& kept : kept_) {
        if (!(kept.until - gone > 0.5 * margin)) {
          kept.until = gone + 0.5 * visit(List{kept.particle, nearer_, {listed_.data() + kept.first, kept.count}});
        }
        least = std::min(least, kept.until);
      }
      least_until_ = least;
      return;
    }
    begin(place, margin);
    see(place, gone);
    gather_all([&](std::size_t particle) {
      const double until = gone + 0.5 * visit(List{particle, 0.0, keep(particle)});
      if (keeps_) kept_.back().until = until;
      least = std::min(least, until);
    });
    least_until_ = least;
    complete_ = keeps_;  // and not before, as visit and memory may throw
  }

  /// Whether each() would visit nothing, at a later gone() than `before`, m, that of the last call.
  bool none_within(double margin, double gone, double before) const {
    const double room = slack_ - nearer_ - 2.0 * (gone - before);
    return complete_ && least_until_ - gone > 0.5 * margin && room >= 0.0 && margin <= margin_ + room;
  }
  /// Places were set, and gone() may go on from elsewhere.
  void jump() {
    jumped_ = true;
    least_until_ = -HUGE_VAL;
  }

  std::size_t searches() const { return searches_; }  ///< since follow() kept no lists

 private:
  /// Of a length: more than rounding makes of it, and of the coordinates between which it is measured.
  static constexpr double of_length = 1e-9, of_places = 1e-14;
  /// Kept entries a particle: a heap of bodies that lie in each other has as many as it has pairs.
  static constexpr std::size_t most_each = 64;

  struct Box {  // empty unless something is added
    Vec3 low = Vec3::Constant(HUGE_VAL), high = Vec3::Constant(-HUGE_VAL);
    void add(const Vec3& from, const Vec3& to) {  // but for what is no number
      for (int a = 0; a < 3; ++a) {
        low[a] = from[a] < low[a] ? from[a] : low[a];
        high[a] = to[a] > high[a] ? to[a] : high[a];
      }
    }
    void widen(double by) {
      low.array() -= by;
      high.array() += by;
    }
    /// m: more than rounding makes of a distance between such places.
    double rounding() const { return of_places * std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff()); }
    double squared_distance(const Box& other) const {  // m2
      double sum = 0.0;
      for (int a = 0; a < 3; ++a) {
        const double off = std::max(std::max(low[a] - other.high[a], other.low[a] - high[a]), 0.0);
        sum += off * off;
      }
      return sum;
    }
  };
  /// What it takes to see that particles and triangles of one body are apart by more than their skins at rest.
  struct Motion {
    Box shift{};                   // m, displacements but for the body's rotation
    double least_edge = HUGE_VAL;  // m
    double cover = 0.0;            // m: no point of a triangle is further from all its corners
    bool of_cut = false;           // some are
    void join(const Motion& other) {
      shift.add(other.shift.low, other.shift.high);
      least_edge = std::min(least_edge, other.least_edge);
      cover = std::max(cover, other.cover);
      of_cut = of_cut || other.of_cut;
    }
    double least_apart(const Motion& triangles) const;
  };
  struct Cluster {                   // particles of a body that are near each other at rest
    std::size_t first = 0, end = 0;  // items of particles_
    Index body = -1;
    double edge = 0.0;  // m, the longest
    Box box{};
    Motion motion{};
  };
  struct Turn {  // of a body since rest, and sums that it is found from
    Mat3 rotation = Mat3::Identity(), product = Mat3::Zero();
    Vec3 place = Vec3::Zero(), rest = Vec3::Zero();
    double count = 0.0;
  };
  struct Kept {
    std::size_t particle = 0, first = 0, count = 0;
    double until = -HUGE_VAL;  // m, of gone(): half a margin before it nothing touches
  };

  void drop_lists();
  void build_whole_trees();
  void build_trees(const std::vector<Index>& particles, const std::vector<Index>& triangles);
  void keep_lists_of(const ContactSurface& before);
  bool list_new_triangles();
  void merge(std::vector<std::pair<std::size_t, Near>>& added);
  void search_what_is_new(std::span<const Vec3> place, double margin);
  double reach() const;
  double reach_of(const Kept& list) const;
  bool are_near(const Box& a, const Box& b) const;
  Box box_at(std::size_t triangle, std::span<const Vec3> place) const;
  std::pair<std::vector<Index>, std::vector<Index>> to_search() const;
  template <class Found>
  void gather_all(Found found);
  bool hold(std::span<const Vec3> place, double margin);
  void see(std::span<const Vec3> place, double gone);
  void begin(std::span<const Vec3> place, double margin);
  bool measure(std::span<const Vec3> place);
  void find_shifts(std::span<const Vec3> place);
  Motion motion_of(std::size_t particle) const;
  bool meet(const Cluster& cluster, std::size_t body);
  struct Distance {  // m: of a triangle, which is no nearer and no further
    double least = HUGE_VAL, most = HUGE_VAL;
  };
  Distance distance_to(const Vec3& x, std::size_t triangle, const Box& box, double distance_limit) const;
  bool gather(std::size_t particle, const Vec3& x, std::size_t body);
  std::span<const Near> keep(std::size_t particle);
  double search_distance(double edge) const;
  template <class Visit>
  void visit_items(const Box& box, const Motion* own, std::size_t body, double distance_limit, Visit visit) const;

  const ContactSurface* surface_ = nullptr;
  ContactOptions options_;
  double usual_edge_ = 0.0;        // m, that slack is measured by
  BoxTree particles_, triangles_;  // items are rows of the surface
  bool has_all_ = false;           // and all of them
  std::vector<Cluster> clusters_;
  std::vector<double> node_edge_;  // [nodes of triangles_] m, the longest
  std::vector<double> item_edge_;  // [items of triangles_] m
  std::size_t searches_ = 0;

  // Of the last search.
  bool complete_ = false;              // all that it found is kept, and was finite
  bool keeps_ = false;                 // so far, while it goes on
  int tight_searches_ = 0;             // that are still to go without slack, as lists were too long with it
  bool lost_ = false;                  // a place is so far away that nothing is found
  double margin_ = 0.0, slack_ = 0.0;  // m
  double ranked_edge_ = 0.0;           // m: what may rank first by facing is listed up to this longest edge
  double nearer_ = 0.0;                // m: what may have come nearer until the last each()
  VecList then_;                       // [particles] where they were
  std::vector<Kept> kept_;
  VecList seen_;              // [particles] m, of the last each(), or not a number
  double seen_gone_ = 0.0;    // m, likewise
  bool jumped_ = false;       // jump() since
  double least_until_ = 0.0;  // of what the last each() visited or passed over
  std::vector<Near> listed_;
  // Between follow() and the next each(), where lists stay: particles to look for anew, triangles that are new. In
  // then_ what is new is not a number.
  std::vector<char> to_search_;                    // [particles]; empty: not between them
  std::vector<char> is_new_triangle_;              // [triangles]
  std::vector<Box> node_box_, item_box_;           // of triangles_; a little more than rounding makes of a distance
  std::vector<Motion> node_motion_, item_motion_;  // of triangles_
  std::vector<Turn> turns_;                        // [bodies]
  VecList shift_;                                  // [particles] m, displacements but for their body's rotation
  std::vector<double> node_search_, item_search_;  // m, by their edges
  std::vector<Index> met_;                         // items that the cluster in question meets
  std::vector<Near> near_;                         // of the particle in question
};

/// Calls found(particle) with what gather() has found, for each particle and each body.
template <class Found>
void ContactCandidates::gather_all(Found found) {
  for (const Cluster& cluster : clusters_) {
    for (std::size_t body = 0; body + 1 < triangles_.groups.size(); ++body) {
      if (!meet(cluster, body)) continue;
      for (std::size_t k = cluster.first; k < cluster.end; ++k) {
        const auto particle = static_cast<std::size_t>(particles_.items[k]);
        if (gather(particle, then_[particle], body)) found(particle);
      }
    }
  }
}

}  // namespace phymul
