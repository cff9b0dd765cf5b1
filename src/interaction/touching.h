// SPDX-License-Identifier: MIT
//
// What acts on a step after the tools: bodies on each other, then kept volumes, which have the last word.
#pragma once

#include "body_contacts.h"
#include "kept_volumes.h"

namespace phymul {

class Touching {
 public:
  /// Takes over a scene after a change. Allocates. `surface`: of it.
  void follow(const Scene& scene, FollowedSurface& surface) {
    contacts_.follow(scene, surface);
    volumes_.follow(scene);
  }
  void forget() { contacts_.forget(); }  ///< places changed otherwise than step by step
  void reset(const Scene& scene, const State& state) {
    forget();
    volumes_.reset(scene, state);
  }
  void accept() { volumes_.accept(); }  ///< the step counts
  void read(State& state) const { volumes_.read(state); }
  /// Of a row of Scene::volume_constraints().
  const FluidState& fluid(const Scene& scene, std::size_t row) const {
    return volumes_.fluid(scene.volume_constraints()[row]);
  }
  bool empty() const { return contacts_.empty() && volumes_.empty(); }
  /// Whether it may act in steps in which no particle goes farther than `going`, m, each, and the next one ends with
  /// PredictedStep::gone() no larger than `gone`, m.
  bool may_act(double going, double gone) const {
    return !volumes_.empty() || (!contacts_.empty() && !contacts_.none_near(going, gone));
  }

  /// The row of a volume that cannot be restored; -1: none.
  int act(TouchedParticles& touched) {
    if (!contacts_.empty()) contacts_.act(touched);
    return volumes_.empty() ? -1 : volumes_.act(touched);
  }

 private:
  BodyContacts contacts_;
  KeptVolumes volumes_;
};

}  // namespace phymul
