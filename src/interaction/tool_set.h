// SPDX-License-Identifier: MIT
//
// The tools of a scene as one solver moves them: their poses step by step, what they touch, hold and pierce, and what
// that does to them; and the threads, whose tips tools may hold. In double precision whatever the backend's own is.
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>

#include <functional>
#include <optional>
#include <vector>

#include "blade/blade_edge.h"
#include "contact_tool.h"
#include "joint_set.h"
#include "moved_tool.h"
#include "needle_path.h"
#include "predicted_step.h"
#include "surface_press.h"
#include "thread/thread_set.h"

namespace phymul {

class ToolSet {
 public:
  /// Takes over the scene's tools after a change; tools that stay keep what they hold. Allocates.
  void follow(const Scene& scene);
  bool empty() const { return tools_.empty() && threads_.empty(); }
  FollowedSurface& surface() { return surface_; }  ///< of the scene that follow() takes
  const ThreadState& thread(const SceneThread& wanted) const { return threads_.state(wanted); }
  std::size_t count() const { return tools_.size(); }

  void reset(const Scene& scene, const State& state);
  void read(const Scene& scene, State& state) const;  ///< what the scene still has

  /// A call of `steps` steps begins: looks for new poses and grasps. `at_once`: poses are reached in the first step.
  void begin_call(const Scene& scene, int steps, bool at_once);
  /// Where each tool is during the next step. Allocates only where `ways` has no room for count().
  void ways(double dt, std::vector<ToolWay>& ways) const;
  /// Whether a tool may touch something within the next steps, where any_in(region) says whether a particle may be
  /// there in that time. `wide`: m, no point of a surface's triangle is farther from all its corners.
  bool may_touch(int steps, double dt, double wide, const std::function<bool(const Region&)>& any_in) const;
  /// Moves all tools by steps in which they touch nothing. What joints did to them: in the last step, and summed.
  void pass(int steps, double dt, std::span<const JointSet::Pull> pulls, std::span<const JointSet::Pull> sums);
  /// What joints do to the tools in the step, by Scene::tools(). Before first_not_finite().
  void pull(std::span<const JointSet::Pull> pulls);
  /// Acts on one step: hold, pierce, cut, suck, press, then threads.
  void act(TouchedParticles& touched);
  void feel(TouchedParticles& touched);           ///< what pulled at the particles that tools hold: after all that acts
  const MovedTool* find(std::uint64_t id) const;  ///< null where follow() has not seen it
  // Of a row of Scene::tools().
  const MovedTool& moved(std::size_t row) const { return tools_[row].moved; }
  bool held_by_any(Index particle) const;
  bool is_let_go(std::size_t row) const { return tools_[row].is_let_go(); }  ///< a needle, in the next step
  // Goes on with tools that were moved elsewhere, by a solver that was reset there, or not yet.
  void set_moved(std::size_t row, const MovedTool& moved) { tools_[row].moved = moved; }
  void set_was_reset(bool was_reset) { was_reset_ = was_reset; }
  const char* first_not_finite() const;  ///< at the end of the step in question; "": nothing
  void accept();                         ///< the step counts
  void drop();                           ///< it does not: the next act() does it over

  /// Of a tool of the scene as it is now; where follow() has not seen it yet, no force and the scene's pose. Good until
  /// the next call of a function of this class.
  const ToolReport& report(const SceneTool& wanted) const;

 private:
  struct Moving {
    MovedTool moved;
    ShapeIn<double> shape;
    Tool tool;  // keeps what shape points to
    ContactLaw<double> law;
    Region bounds;  // of the shape in its own frame
    std::optional<NeedlePath> needle{};
    bool is_taken = false;  // a needle that was let go, in the next step
    std::optional<BladeEdge> blade{};
    std::optional<SurfacePress> surface{};  // of ToolContact::surface
    std::optional<MovedTool> before{};      // where it takes hold or lets go in the step in question
    JointSet::Pull pull{};                  // of joints, in the step in question
    ToolForce next_force{};                 // likewise, of what it touches
    bool is_let_go() const { return needle && ((needle->state().free && !is_taken) || moved.releases); }
  };

  void follow_body(const Scene& scene);
  Moving made(const SceneTool& tool, const Scene& scene);
  void take_hold(Moving& tool, TouchedParticles& touched);
  void hold(Moving& tool, TouchedParticles& touched);
  void act_by_threads(TouchedParticles& touched);
  void press(Moving& tool, TouchedParticles& touched);

  bool at_once_ = false;  // of the last begin_call()
  std::vector<Moving> tools_;
  FollowedSurface surface_;
  ThreadSet threads_;
  std::vector<Index> found_;
  std::uint64_t body_version_ = 0;  // Scene::body_version() that needles and surfaces are of
  bool was_reset_ = false;          // the first reset is that of a solver being made
  mutable ToolReport unseen_;       // of a tool that follow() has not seen yet
};

}  // namespace phymul
