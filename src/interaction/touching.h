// SPDX-License-Identifier: MIT
//
// What acts on a step after the tools: bodies on each other, then kept volumes, which have the last word.
#pragma once

#include "body_contacts.h"
#include "kept_volumes.h"

namespace phymul::cpu {

class Touching {
 public:
  /// Takes over a scene after a change. Allocates.
  void follow(const Scene& scene) {
    contacts_.follow(scene);
    volumes_.follow(scene);
  }
  void forget() { contacts_.forget(); }  ///< places changed otherwise than step by step
  bool empty() const { return contacts_.empty() && volumes_.empty(); }

  /// The row of a volume that cannot be restored; -1: none.
  int act(TouchedParticles& touched) {
    if (!contacts_.empty()) contacts_.act(touched);
    return volumes_.empty() ? -1 : volumes_.act(touched);
  }

 private:
  BodyContacts contacts_;
  KeptVolumes volumes_;
};

}  // namespace phymul::cpu
