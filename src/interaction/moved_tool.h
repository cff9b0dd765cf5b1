// SPDX-License-Identifier: MIT
//
// A tool of a scene as one solver moves it, whatever the backend: its pose step by step, what it holds, and what its
// calls of step() have felt. In double precision.
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>

#include <span>
#include <string>
#include <vector>

namespace phymul {

/// Where a tool goes. Cheap to copy.
struct ToolMotion {
  ToolPose pose;            // at the state's time
  ToolPose next_pose;       // of the end of the step in question
  bool placed = true;       // since the last step: it was put where it is, not moved there
  ToolPose from, to;        // of this call's motion
  int steps = 0, done = 0;  // of it; steps 0: the tool goes on with its velocity

  void place(const ToolPose& there);
  void advance(double dt);  ///< next_pose
  void accept();            ///< the step counts; without it the next advance() does it over
};

/// Where a tool is that no solver has moved yet: where it was added, or put since by ToolHandle::teleport().
const ToolPose& first_pose(const SceneTool& tool);

struct MovedTool {
  explicit MovedTool(const SceneTool& tool);

  /// To what a state says of it, which is returned; null where it says nothing: to where the scene has it, holding
  /// nothing. Moves and grasps asked for count as done, but by a solver that is being made: `first`. `mass`: of all
  /// particles, kg.
  const ToolState* reset(const SceneTool& wanted, const State& state, std::span<const double> mass, bool first);
  void read(ToolState& to) const;        ///< all but needles
  bool is_in(const Scene& scene) const;  ///< which may have another tool of that name by now
  /// A call of `call_steps` steps, above 0, begins: looks for new poses and grasps. `at_once`: poses are reached in the
  /// first step. True where there is a new pose.
  bool begin_call(const SceneTool& wanted, int call_steps, bool at_once);
  void take_hold(Index particle, const Vec3& at);  ///< m, in the tool's frame
  void release();
  void let_go_of_removed(std::span<const double> mass);  ///< particles without mass
  /// After held has changed. `mass`: of all particles, kg.
  void weigh_held(std::span<const double> mass);
  void accept_pose();
  /// What so many more steps of the call did to it: in the last one, and summed up.
  void tell(const ToolForce& last, const Vec3& sum_force, const Vec3& sum_torque, int steps);

  std::uint64_t id = 0;
  std::string name;
  ToolMotion motion;
  ToolReport report;                      // pose and hold of the state, force of the last step
  bool grasps = false, releases = false;  // in the next step
  double grasp_distance = 0.0;            // m
  std::vector<Index> held;
  VecList held_at;  // [held] in the tool's frame, m

 private:
  void place(const ToolPose& pose);
  void place_first(const SceneTool& tool);

  std::uint64_t seen_moves_ = 0, seen_places_ = 0, seen_grasps_ = 0;
  Vec3 sum_force_{0, 0, 0}, sum_torque_{0, 0, 0};  // over the steps of this call
  int summed_ = 0;
};

}  // namespace phymul
