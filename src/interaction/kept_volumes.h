// SPDX-License-Identifier: MIT
//
// Scene::constrain_volume, in double precision whatever the backend's own is. Along the gradient of the volume at the
// step's start, over the masses, the particles of the surface go as far as brings the volume at the step's end to the
// one that the fluid then has (the scheme of constraints in Verlet's method, which keeps angular momentum too). Of a
// fluid with a law of pressure the push is the mean of its pressures at the ends of this step and of the one before,
// (p+ + 2 p + p-) / 4: Newmark's average acceleration, which is stable in any step and neither gains nor loses energy
// (Hughes, The Finite Element Method, 1987, ch. 9). Unknown is the push alone. Of volumes that open into each other
// FluidExchange first finds how much fluid each has at the end; then each is as a closed one.
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>

#include "fluid_exchange.h"
#include "predicted_step.h"

namespace phymul {

class KeptVolumes {
 public:
  void follow(const Scene& scene);  ///< allocates
  /// To the fluids of a state; those without an entry are what the scene says.
  void reset(const Scene& scene, const State& state);
  bool empty() const { return surfaces_.empty(); }

  /// After all else that acts on the step. The row of a volume that cannot be restored; -1: none.
  int act(TouchedParticles& touched);
  bool is_finite() const;  ///< the fluids at the end of the step
  /// m/s: speed of the walls of a cube of VolumeConstraint::volume, or the fastest of several, that would take up what
  /// flowed in the last step that counts. Of held walls, too.
  double flow() const { return flow_; }
  void accept(double dt);                             ///< the step counts
  void read(const Scene& scene, State& state) const;  ///< with the volumes that the scene has by now
  /// Of a constraint of the scene, also of one that follow() has not seen.
  const FluidState& fluid(const VolumeConstraint& wanted) const;

 private:
  struct Surface {
    std::vector<Index> particles;
    std::vector<std::array<Index, 3>> triangles;  // rows of `particles`
    bool open = false;                            // not kept
    VecList start, end, gradient, along;          // [particles]
    Fluid law;                                    // with all that opens outside
    double whole = 0.0;                           // m^3, VolumeConstraint::volume
    FluidState now, next;
    bool linked = false;            // of a group
    double reached = 0.0;           // m^3, at the end of the step without a push
    std::array<double, 3> cubic{};  // volume_along() from there
    bool has_pressure = false;      // now.pressure_before is that of a step, of this much fluid
    std::uint64_t seen = 0;         // VolumeConstraint::changes
  };
  static Surface made(const VolumeConstraint& kept);
  static bool is_of(const Surface& surface, const VolumeConstraint& kept);
  /// Volumes that are open into each other.
  struct Group {
    std::vector<std::size_t> rows;
    FluidExchange exchange;
  };
  void find_groups(const Scene& scene);
  static FluidPush predicted(Surface& surface, TouchedParticles& touched);
  /// `otherwise`: Pa, the pressure if nothing is free to move.
  static bool restore(Surface& surface, const FluidPush& push, TouchedParticles& touched, double otherwise = 0.0);
  int restore(Group& group, TouchedParticles& touched);

  std::vector<Surface> surfaces_;
  std::vector<Group> groups_;
  double flow_ = 0.0;
  mutable FluidState unseen_;
};

}  // namespace phymul
