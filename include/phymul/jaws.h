// SPDX-License-Identifier: MIT
//
// Jaws: a grasper, two plates on a hinge. They close with a limited force and hold tissue by friction alone. Or
// scissors, two edges on a hinge.
#pragma once

#include <phymul/scene.h>

#include <array>
#include <optional>
#include <string_view>

namespace phymul {

/// The plates go from the hinge along -z of the jaws' frame and turn about its x axis, one to +y, the other to -y. At
/// the angle 0 they lie on each other.
struct JawsOptions {
  /// m, > 0, of a plate; the width is along x. Thin plates cost more: they touch at more points.
  double length = 0.02, width = 0.006, thickness = 0.006;
  /// `particles` costs less, for plates of two spacings or more along both sides.
  ToolContact contact = ToolContact::surface;
  double friction = 0.5;  ///< Coulomb coefficient, >= 0
  /// N, > 0: the angle follows the force, so that each plate presses as this force at its end would: its torque about
  /// the hinge is grip * length.
  double grip = 1.0;
  double opening = 0.6;  ///< rad, in (0, 3]: largest angle between the plates, which is also the first one
  /// rad/s, > 0, with which they open, and close where nothing resists. Too fast for a stiff tissue they chatter: in a
  /// tick the force should rise by less than `grip`.
  double speed = 0.5;
  /// J/m^2, >= 0: scissors. In place of the plates are edges (Blade) of that toughness, in the plane x = 0, which cut
  /// toward each other; width, thickness, contact and friction are of no account. Where tissue takes more than `grip`
  /// they do not cut it.
  std::optional<double> toughness = {};
};

/// Two tools of a scene, boxes or blades, and the angle between them. In each tick, call follow() and
/// step() once each. The scene must outlive it. Small and copyable: the angle is that of the tools' target poses, so
/// that it comes back with a Snapshot of them, and recordings have it.
class Jaws {
 public:
  /// Adds the tools "<name> 1" (at +y) and "<name> 2" to a scene, open, with the hinge at a pose. Throws Error for
  /// options out of their range and as Scene::add_tool() does.
  Jaws(Scene& scene, std::string_view name, const JawsOptions& options, const ToolPose& hinge);

  void close() { closes_ = true; }  ///< from the next follow() on
  void open() { closes_ = false; }

  /// Moves both plates to where they are at the end of a tick of `dt` s, in which the hinge goes to a pose. `on_first`,
  /// `on_second`: Simulation::force_on() of the plates, of the tick before; their means over the call are used. Throws
  /// Error for a pose that is not finite or a dt that is negative.
  void follow(const ToolPose& hinge, const ToolForce& on_first, const ToolForce& on_second, double dt);

  const ToolHandle& first() const { return plates_[0]; }
  const ToolHandle& second() const { return plates_[1]; }
  double angle() const;                           ///< rad, between the plates at the end of the tick
  double grip() const { return grip_; }           ///< N at the end of a plate, in the tick before; the mean of both
  const Vec3& force() const { return force_; }    ///< N, on the handle, in the tick before, along the axes of the world
  const Vec3& torque() const { return torque_; }  ///< N m about the hinge, likewise

 private:
  ToolPose plate_pose(std::size_t side) const;

  JawsOptions options_;
  std::array<ToolHandle, 2> plates_;
  bool closes_ = false;
  double grip_ = 0.0;
  Vec3 force_{0, 0, 0}, torque_{0, 0, 0};
};

}  // namespace phymul
