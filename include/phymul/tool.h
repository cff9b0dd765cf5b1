// SPDX-License-Identifier: MIT
//
// Tools: rigid objects that the application moves. They touch, hold or pierce a body and report its force.
#pragma once

#include <phymul/blade.h>
#include <phymul/needle.h>
#include <phymul/types.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace phymul {

class DistanceGrid;  // distance_grid.h
struct Model;        // model.h

/// Not aligned: public structs have no alignment beyond that of double.
using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

// Shapes, in the tool's frame; lengths in m.
struct Sphere {
  double radius = 0.0;  ///< around the tool's position
  bool operator==(const Sphere&) const = default;
};
struct Capsule {  ///< all points within `radius` of the segment from the tool's position along +z
  double radius = 0.0, length = 0.0;
  bool operator==(const Capsule&) const = default;
};
struct HalfSpace {  ///< solid where z < 0: a floor, whose normal is the tool's +z
  bool operator==(const HalfSpace&) const = default;
};
struct Box {
  Vec3 half_size{0, 0, 0};  ///< centred at the tool's position
  bool operator==(const Box&) const = default;
};
using ToolShape = std::variant<Sphere, Capsule, HalfSpace, Box, std::shared_ptr<const DistanceGrid>, Needle, Blade>;

struct ToolPose {
  Vec3 position{0, 0, 0};              ///< m
  Quaternion orientation{1, 0, 0, 0};  ///< rotates the tool's frame to the world's; any length but 0, is normalised
  Vec3 velocity{0, 0, 0};              ///< m/s of `position`, with which the tool continues without a new pose
  Vec3 spin{0, 0, 0};                  ///< rad/s about axes of the world; likewise
  bool operator==(const ToolPose&) const = default;
};

/// Which points of a body a tool touches.
enum class ToolContact {
  /// All particles. A tool thinner than the spacing can pass between them, and its force depends on where it is.
  particles,
  /// The triangles of the surface, at points that are fixed to them. The force on a point acts on the particles of its
  /// triangle by barycentric weights. A body without triangles (points, springs, 2-D) is touched at its particles.
  surface
};

struct Tool {
  ToolShape shape = Sphere{};
  ToolPose pose{};        ///< first pose, as set by ToolHandle::teleport()
  double friction = 0.0;  ///< Coulomb coefficient, >= 0, static and kinetic
  /// m/N, >= 0: how far a particle enters the tool per newton of force on this particle. 0: each step ends with all
  /// particles outside (ToolContact::surface: points may stay inside for a few steps). The spring is integrated
  /// implicitly, so that no value limits the step.
  double compliance = 0.0;
  /// m, >= 0, added around the shape. With ToolContact::particles a tool thinner than the spacing passes through
  /// without force unless it has a margin, see least_margin().
  double margin = 0.0;
  /// Must be `particles` for a Needle, which finds the surface's triangles itself, and for a Blade.
  ToolContact contact = ToolContact::particles;
  /// N, >= 0: what draws tissue toward the shape. Particles within `suction_reach`, m, > 0, of its surface share it by
  /// mass, with weights that fall from 1 at the surface to 0 at the reach, so that their sum is at most `suction`. 0
  /// for a Needle and a Blade.
  double suction = 0.0, suction_reach = 0.0;
};

/// Smallest Tool::margin, m, with which no tool of this shape passes between the particles of the model's surface
/// without touching one; ToolContact::surface needs none. It is stretch * r - t, but at least 0: r is the largest
/// covering radius of the surface's triangles, the distance from the farthest point of a triangle to its nearest
/// corner. t is the least radius of the shape: the radius of a Sphere or Capsule, the least half size of a Box, 0 for a
/// DistanceGrid. The result is 0 for a HalfSpace, for a Needle, which finds the surface's triangles itself, and for a
/// Blade. `stretch` > 0: factor by which edges of the surface grow, in particular where the tool parts them; 1 is for
/// the rest shape. Throws Error for a model without a surface and for a stretch that is not above 0.
double least_margin(const Model& model, const ToolShape& shape, double stretch = 1.25);

/// Force, N, and torque about the tool's position, N m, of the particles on a tool, along the axes of the world. A tool
/// has no mass of its own (VirtualCoupling gives it one).
struct ToolForce {
  Vec3 force{0, 0, 0}, torque{0, 0, 0};            ///< of the last step
  Vec3 mean_force{0, 0, 0}, mean_torque{0, 0, 0};  ///< over the steps of the last call of step()
  int particles = 0;                               ///< number of particles pushed or held in the last step

  // Grasped particles move rigidly with the tool, and their inertia is part of the force. An application that computes
  // the next pose from the force needs these values (VirtualCoupling). Axes are the tool's, the origin is its position.
  // Particles with some imposed coordinates count with their whole mass. All are 0 if nothing is grasped.
  double held_mass = 0.0;            ///< kg
  Vec3 held_centre{0, 0, 0};         ///< m, centre of that mass
  Mat3 held_inertia = Mat3::Zero();  ///< kg m^2: sum of m (|q|^2 1 - q q^T)
  bool operator==(const ToolForce&) const = default;
};

/// State of a tool after a step, as a backend reports it.
struct ToolReport {
  ToolPose pose{};       ///< at the state's time
  ToolPose last_pose{};  ///< before the last step; `pose` if it was teleported or no step was done since
  ToolForce force{};
  int held = 0;                    ///< number of particles that it holds
  int tissue_gave_way = 0;         ///< as StepReport::tissue_gave_way, since the solver was made
  std::uint64_t grasps = 0;        ///< SceneTool::grasps as of the last step
  std::vector<ShaftLoad> shaft{};  ///< of a needle that bends
};

/// Part of a State: what a solver remembers of a tool between steps.
struct ToolState {
  std::string name{};
  ToolPose pose{};
  /// No step was done since ToolHandle::teleport(): the next one moves covered particles out without giving them speed.
  bool placed = true;
  std::vector<Index> held{};  ///< [H] particles that it grasps
  VecList held_at{};          ///< [H] their positions in the tool's frame, m
  NeedleState needle{};
  std::vector<BladePoint> blade{};  ///< points that hold tissue
  bool operator==(const ToolState&) const = default;
};

/// Part of a Scene: a tool and what was last asked of it. Counters grow with each call, so that any number of solvers
/// can see what is new.
struct SceneTool {
  std::uint64_t id = 0;  ///< unique in its scene, also after tools were removed
  std::string name{};
  Tool tool;
  ToolPose pose{};             ///< the last target pose
  std::uint64_t moves = 0;     ///< number of calls of move_to() and teleport()
  std::uint64_t places = 0;    ///< number of calls of teleport()
  std::uint64_t grasps = 0;    ///< number of calls of grasp() and release()
  std::uint64_t released = 0;  ///< `grasps` after the last call of release()
  bool grasping = false;
  double grasp_distance = 0.0;  ///< m
};

}  // namespace phymul
