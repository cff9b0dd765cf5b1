// SPDX-License-Identifier: MIT
//
// A spring and a damper between a haptic device and a tool: the tool follows the hand as its contacts let it, the hand
// feels the spring. So a device never meets a force that is stiffer than the spring, whatever the tool meets (J. E.
// Colgate, M. C. Stanley, J. M. Brown, "Issues in the haptic display of tool use", IEEE/RSJ IROS 1995, 140-145).
#pragma once

#include <phymul/tool.h>

namespace phymul {

struct CouplingOptions {
  double stiffness = 500.0;        ///< N/m; what the device can show without shaking
  double damping = 5.0;            ///< N s/m
  double mass = 0.05;              ///< kg of the tool as the hand feels it
  double turning_stiffness = 0.5;  ///< N m/rad
  double turning_damping = 5e-3;   ///< N m s/rad
  double inertia = 5e-5;           ///< kg m^2, about any axis
  double largest_force = 5.0;      ///< N to the device
  double largest_torque = 0.1;     ///< N m to the device
};

/// Once a tick of the device: follow(), the pose to the tool, one call of step() over the tick, force() to the device.
///
/// What a tool pushes without holding it feels a tick late, and swings for ever where that is heavier than the tool:
/// mass + dt damping must be above the mass of the particles pushed, for a lattice density times half a spacing times
/// the area that touches; inertia likewise above theirs about the tool's position. (Taken as held, what is pushed does
/// not come to rest: it is let go and met again within a tick.)
class VirtualCoupling {
 public:
  /// The tool starts at the device's pose. Throws Error unless mass, inertia and limits are above 0 and the rest not
  /// below, and for a pose that is not finite or has a zero orientation.
  VirtualCoupling(const CouplingOptions& options, const ToolPose& device);

  /// Where the tool goes within `dt` s: device is where the hand is then, on_tool what Solver::tool_force said of the
  /// tick before, which was one call of step(). Its means over the call are what counts, and what the tool holds moves
  /// with the tool in this very tick: stable however stiff the spring, and however heavy what is held. Does not throw:
  /// where a number given is not finite, or so large that a result is not, dt is negative, or the device's orientation
  /// is zero, this tick is left out, and pose(), force() and torque() are those of the tick before.
  const ToolPose& follow(const ToolPose& device, const ToolForce& on_tool, double dt);
  /// The same of a force alone, as that of a tool that holds nothing. One that holds more than CouplingOptions::mass
  /// grows unstable under it.
  const ToolPose& follow(const ToolPose& device, const Vec3& force_on_tool, const Vec3& torque_on_tool, double dt);

  /// The tool at the device's pose, no force: after a device was away. Throws Error as the constructor does, for poses.
  void reset(const ToolPose& device);

  const Vec3& force() const { return force_; }    ///< N, on the device
  const Vec3& torque() const { return torque_; }  ///< N m, on the device
  const ToolPose& pose() const { return tool_; }  ///< of the tool: for ToolHandle::move_to()

 private:
  /// How the tool was moved in the tick before, along and around: m/s, rad/s, and what they grew by, a second.
  struct Moved {
    Vec3 velocity{0, 0, 0}, spin{0, 0, 0}, acceleration{0, 0, 0}, spin_up{0, 0, 0};
    double dt = 0.0;  // s
    void to(const Vec3& next_velocity, const Vec3& next_spin, double over);
  };
  struct Velocities {
    Vec3 velocity, spin;
  };
  Velocities carrying(const ToolForce& load, const Vec3& pull, const Vec3& twist, double mass, double inertia,
                      double dt) const;
  const ToolPose& leave_out(double dt);

  CouplingOptions options_;
  Moved moved_;
  ToolPose tool_;
  Vec3 force_{0, 0, 0}, torque_{0, 0, 0};
};

}  // namespace phymul
