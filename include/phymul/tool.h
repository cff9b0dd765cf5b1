// SPDX-License-Identifier: MIT
//
// Tools: rigid things that somebody outside moves, which touch, hold or pierce a body. They push particles, and tell
// what the particles push back.
#pragma once

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

/// Not aligned, as all that stands in public structs.
using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

// Shapes, in the tool's own frame; m.
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
using ToolShape = std::variant<Sphere, Capsule, HalfSpace, Box, std::shared_ptr<const DistanceGrid>, Needle>;

struct ToolPose {
  Vec3 position{0, 0, 0};              ///< m
  Quaternion orientation{1, 0, 0, 0};  ///< turns the tool's frame to the world's; normalised when taken over
  Vec3 velocity{0, 0, 0};              ///< m/s of `position`; the tool goes on with it where no new pose comes
  Vec3 spin{0, 0, 0};                  ///< rad/s about axes of the world; likewise
  bool operator==(const ToolPose&) const = default;
};

struct Tool {
  ToolShape shape = Sphere{};
  /// Where it is at first, as if by ToolHandle::teleport(): what it covers there comes out in the first step.
  ToolPose pose{};
  double friction = 0.0;  ///< Coulomb's coefficient, sticking and sliding alike
  /// m/N: how far a particle enters per newton on it. 0: not at all, a particle ends each step outside. The spring is
  /// taken at the step's end, so that it is stable however stiff.
  double compliance = 0.0;
  /// m added around the shape. A tool touches particles, not what is between them: one thinner than a spacing slips
  /// through, without a force, unless its margin makes up for it: least_margin().
  double margin = 0.0;
};

/// m: the least Tool::margin with which no tool of this shape passes between the particles of the model's surface
/// without touching one. What goes through the surface goes through one of its triangles, and no point of a triangle is
/// farther from its nearest corner than the covering radius (of one without an obtuse angle that of the circle through
/// its corners; half the longest edge would be too little for an equilateral one). So the margin is the largest
/// covering radius, times `stretch`, less the shape's least radius: of a Sphere or a Capsule its radius, of a Box its
/// smallest half size, of a DistanceGrid 0, as it may be thin anywhere. 0 for a HalfSpace, and for a Needle, which
/// looks for the surface's triangles itself. `stretch`: by how much the surface's edges grow, above all where the tool
/// itself parts them; 1 is for the rest shape. Throws Error for a model without a surface and a stretch that is not
/// above 0.
double least_margin(const Model& model, const ToolShape& shape, double stretch = 1.25);

/// What the particles do to a tool, as a hand that holds it would feel it: N, and N m about the tool's position. (The
/// tool itself has neither mass nor weight.)
struct ToolForce {
  Vec3 force{0, 0, 0}, torque{0, 0, 0};            ///< of the last step
  Vec3 mean_force{0, 0, 0}, mean_torque{0, 0, 0};  ///< over the steps of the last call of step()
  int particles = 0;                               ///< that it pushed or held in the last step

  // What it grasps: rigidly its own while it does, and felt as its own inertia. Whoever turns the force into the next
  // pose needs it (VirtualCoupling). Axes are the tool's, from its position; particles with imposed coordinates count
  // with their whole mass. Zero where it grasps nothing.
  double held_mass = 0.0;            ///< kg
  Vec3 held_centre{0, 0, 0};         ///< m, centre of that mass
  Mat3 held_inertia = Mat3::Zero();  ///< kg m^2, about the tool's position: sum of m (|q|^2 1 - q q^T)
};

/// What a solver says of a tool after a step.
struct ToolReport {
  ToolPose pose{};  ///< where it is at the state's time
  ToolForce force{};
  int held = 0;                    ///< particles that it holds
  std::vector<ShaftLoad> shaft{};  ///< of a needle that bends
};

/// What a solver remembers of a tool between steps: with it, a state can be gone back to.
struct ToolState {
  std::string name{};
  ToolPose pose{};
  /// No step was taken since it was put there: in the next one particles that it covers come out without gaining speed.
  bool placed = true;
  std::vector<Index> held{};  ///< particles that it grasps
  VecList held_at{};          ///< [held] their places in the tool's frame, m
  NeedleState needle{};
  bool operator==(const ToolState&) const = default;
};

/// A tool as a scene has it. The counters grow by one at each call, so that a solver sees what is new; several solvers
/// may look at one scene.
struct SceneTool {
  std::uint64_t id = 0;  ///< of this scene's tools, never used again
  std::string name{};
  Tool tool;
  ToolPose pose{};           ///< the last one asked for
  std::uint64_t moves = 0;   ///< calls of move_to() and teleport()
  std::uint64_t places = 0;  ///< calls of teleport()
  std::uint64_t grasps = 0;  ///< calls of grasp() and release()
  bool grasping = false;
  double grasp_distance = 0.0;
};

}  // namespace phymul
