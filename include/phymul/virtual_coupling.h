// SPDX-License-Identifier: MIT
//
// VirtualCoupling: a spring and a damper between a haptic device and a tool. The tool follows the hand as far as its
// contacts allow, and the hand feels the spring. So the device never renders a stiffness above that of the spring,
// whatever the tool touches (J. E. Colgate, M. C. Stanley, J. M. Brown, "Issues in the haptic display of tool use",
// IEEE/RSJ IROS 1995, 140-145).
#pragma once

#include <phymul/tool.h>

namespace phymul {

struct CouplingOptions {
  double stiffness = 500.0;        ///< N/m; at most what the device renders stably
  double damping = 5.0;            ///< N s/m
  double mass = 0.05;              ///< kg of the tool as the hand feels it
  double turning_stiffness = 0.5;  ///< N m/rad
  double turning_damping = 5e-3;   ///< N m s/rad
  double inertia = 5e-5;           ///< kg m^2, about any axis
  double largest_force = 5.0;      ///< N to the device
  double largest_torque = 0.1;     ///< N m to the device
};

/// In each tick, call follow(), ToolHandle::move_to(pose()) and step() once each, and send force() to the device.
///
/// The force of particles that a tool pushes without holding them acts a tick late. The tool oscillates without end if
/// they are too heavy: mass + dt * damping must be above their mass (on a lattice: density times half a spacing times
/// the contact area), and inertia + dt * turning_damping above their moment of inertia about the tool's position. (To
/// treat them as held does not help, because contact is lost and made again within a tick.)
class VirtualCoupling {
 public:
  /// The tool starts at the device's pose. Throws Error unless mass, inertia and the largest force and torque are above
  /// 0 and the other options at least 0, all finite, and for a pose that is not finite or has a zero orientation.
  VirtualCoupling(const CouplingOptions& options, const ToolPose& device);

  /// Computes the tool's pose at the end of a tick of `dt` s, and returns pose(). device: pose of the hand at that
  /// time, with its velocities. on_tool: Solver::tool_force() of the tick before, which was one call of step(); its
  /// means over the call and the held mass are used. It is stable for any stiffness of the spring and any held mass.
  /// Does not throw: if an argument or a result is not finite, dt is negative, or the device's orientation is zero, it
  /// omits this tick, and pose(), force() and torque() keep their values.
  const ToolPose& follow(const ToolPose& device, const ToolForce& on_tool, double dt);
  /// The same with a force, N, and torque, N m, of a tool that holds nothing. Unstable if the tool holds more than
  /// CouplingOptions::mass.
  const ToolPose& follow(const ToolPose& device, const Vec3& force_on_tool, const Vec3& torque_on_tool, double dt);

  /// Sets the tool to the device's pose and the force to 0, for example after the device was disconnected. Throws Error
  /// for an invalid pose, as the constructor does.
  void reset(const ToolPose& device);

  const Vec3& force() const { return force_; }    ///< N, on the device
  const Vec3& torque() const { return torque_; }  ///< N m, on the device
  const ToolPose& pose() const { return tool_; }  ///< of the tool: for ToolHandle::move_to()

 private:
  /// Motion of the tool in the tick before: m/s and rad/s, and their rates of change, per second.
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
