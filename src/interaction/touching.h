// SPDX-License-Identifier: MIT
//
// What acts on a step after the tools: bodies on each other, then kept volumes, which have the last word.
#pragma once

#include "body_contacts.h"
#include "joint_set.h"
#include "kept_volumes.h"
#include "stiff_joints.h"
#include "tool_set.h"

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
  const char* first_not_finite() const {  ///< at the end of the step in question; "": nothing
    return volumes_.is_finite() ? "" : "the pressure of a fluid would not be finite: its volume or its law is extreme";
  }
  void accept(double dt) { volumes_.accept(dt); }  ///< the step counts
  double flow() const { return volumes_.flow(); }  ///< m/s, KeptVolumes::flow()
  void read(const Scene& scene, State& state) const { volumes_.read(scene, state); }
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

/// At the end of a step on the host: joints and tools get the forces of implicit joints, null: none. Returns what is
/// not finite besides particles, as SolverBackend::Motion says it.
inline const char* settled(JointSet& joints, const StiffJoints* stiff, ToolSet& tools, const Touching& touching) {
  if (stiff != nullptr) stiff->tell(joints);
  tools.pull(joints.pulls());
  if (!joints.is_finite()) return "the force of a joint would not be finite: its anchors are extremely far apart";
  const char* const fluid = touching.first_not_finite();
  return *fluid != '\0' ? fluid : tools.first_not_finite();
}

}  // namespace phymul
