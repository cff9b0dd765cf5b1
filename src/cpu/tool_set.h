// SPDX-License-Identifier: MIT
//
// The tools of a scene as one solver moves them: their poses step by step, what they touch, hold and pierce, and what
// that does to them. In double precision whatever the backend's own is.
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>
#include <phymul/topology_textures.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "../free_step.h"
#include "contact_tool.h"
#include "needle_path.h"
#include "tool_frame.h"

namespace phymul::cpu {

class ToolSet {
 public:
  /// Takes over the scene's tools after a change; tools that stay keep what they hold. Allocates.
  void follow(const Scene& scene);
  bool empty() const { return tools_.empty(); }
  std::size_t count() const { return tools_.size(); }

  void reset(const Scene& scene, const State& state);
  void read(State& state) const;

  /// A call of `steps` steps begins: looks for new poses and grasps. `at_once`: poses are reached in the first step.
  void begin_call(const Scene& scene, int steps, bool at_once);
  /// Acts on one step; the poses are those of the step's end.
  void act(TouchedParticles& touched);
  void accept();  ///< the step counts; without it the next act() does it over

  /// Of a tool of the scene as it is now; where follow() has not seen it yet, no force and the scene's pose. Good until
  /// the next call of a function of this class.
  const ToolReport& report(const SceneTool& wanted) const;

 private:
  struct Moving {
    std::uint64_t id = 0;
    std::string name;
    ShapeIn<double> shape;
    std::shared_ptr<const DistanceGrid> grid;  // keeps what shape points to
    ContactLaw<double> law;
    Region reach;  // of the shape in its own frame

    ToolReport report;        // pose of the state, force of the last step
    ToolPose next_pose;       // of the end of the step in question
    ToolPose from, to;        // of this call's motion
    int steps = 0, done = 0;  // of it; steps 0: the tool goes on with its velocity
    std::uint64_t seen_moves = 0, seen_places = 0, seen_grasps = 0;
    bool grasps = false, releases = false;  // in the next step
    double grasp_distance = 0.0;
    std::vector<Index> held;
    VecList held_at;
    std::optional<NeedlePath> needle;

    ToolForce next_force;
    Vec3 sum_force{0, 0, 0}, sum_torque{0, 0, 0};  // over the steps of this call
    int summed = 0;
  };

  static Moving made(const SceneTool& tool, const Scene& scene);
  static void place(Moving& tool, const ToolPose& pose);
  static void advance(Moving& tool, double dt);
  void take_hold(Moving& tool, TouchedParticles& touched);
  void hold(Moving& tool, TouchedParticles& touched);
  void press(Moving& tool, TouchedParticles& touched);
  bool held_by_any(Index particle) const;

  std::vector<Moving> tools_;
  std::vector<Index> found_;
  mutable ToolReport unseen_;  // of a tool that follow() has not seen yet
};

}  // namespace phymul::cpu
