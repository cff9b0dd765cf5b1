// SPDX-License-Identifier: MIT
//
// FloatTools: the tools of a scene for backends that compute in float. Moved on the host in double precision; a device
// is given rows, and gives back sums. Needles, and tools that touch surfaces, act on the host: ToolSet.
//
// Places are seen from the middle of the rest shape and stand as two floats whose sum they are, so that neither the
// distance of a body from the origin nor its size costs a tool any digits: near a particle is a matter of differences.
#pragma once

#include <phymul/scene.h>
#include <phymul/state.h>

#include <span>
#include <vector>

#include "interaction/joint_set.h"
#include "interaction/moved_tool.h"
#include "table_rows.h"

namespace phymul {

/// What a batch of steps did to one tool, N and N m: summed over its steps, and in the last of them.
struct ToolSums {
  Float4 force{}, torque{};
  Float4 last_force{}, last_torque{};  // w of the force: particles that it touched
};

class FloatTools {
 public:
  // Rows as glsl/tools/tool_tables.glsl has them.
  static constexpr std::size_t law_rows = 4, frame_rows = 7, rest_rows = 2;
  /// Grids begin at multiples of so many values: a float counts those.
  static constexpr std::size_t grid_unit = 256;

  /// Room for batches of so many steps.
  explicit FloatTools(int most_steps) : most_steps_(static_cast<std::size_t>(most_steps)) {}

  /// Takes over the scene's tools after a change; tools that stay keep what they hold. Allocates.
  void follow(const Scene& scene);
  bool empty() const { return tools_.empty(); }
  int count() const { return static_cast<int>(tools_.size()); }
  bool any_grid() const { return !grid_values_.empty(); }

  void reset(const Scene& scene, const State& state);
  bool was_reset() const { return was_reset_; }
  void read(const Scene& scene, State& state) const;  ///< what the scene still has
  // Of a row of Scene::tools().
  const MovedTool& moved(std::size_t row) const { return tools_[row].moved; }
  void set_moved(std::size_t row, const MovedTool& moved);
  /// `let_go`: a needle that nothing pulls.
  void set_motion(std::size_t row, const ToolMotion& motion, bool let_go) {
    tools_[row].moved.motion = motion;
    tools_[row].let_go = let_go;
  }

  /// A call begins. True where what is held changes: hold() is then to be called before its first step.
  bool begin_call(const Scene& scene, int steps, bool at_once);
  bool grasps() const;  ///< hold() needs positions
  /// `fixed`: LoadFrame::fixed, or empty; `plane`: nothing moves along z.
  void hold(const VecList& position, std::span<const std::uint8_t> fixed, bool plane);
  /// No step was done since hold(): what it changed is to be done in the next call. False: it changed nothing.
  bool undo_hold();

  /// Fills frames() for steps from here on. How many of them leave all poses finite.
  int begin_batch(int steps, double dt);
  /// So many steps of the batch count; `sums` are of those. By tool, what joints did in the last one and summed.
  void accept(int steps, double dt, std::span<const ToolSums> sums, std::span<const JointSet::Pull> pulls,
              std::span<const JointSet::Pull> pull_sums);
  /// m, of the rest shape: what places are seen from. 0 without tools.
  const Vec3& middle() const { return middle_; }

  /// As ToolSet::report of src/interaction.
  const ToolReport& report(const SceneTool& wanted) const;

  const std::vector<Float4>& laws() const { return laws_; }  ///< [count][law_rows]
  /// [steps + 1][count][frame_rows], of the instants of the batch.
  std::span<const Float4> frames() const { return {frames_.data(), frames_filled_}; }
  std::size_t most_frames() const { return frames_.size(); }
  /// [particles][rest_rows]
  const std::vector<Float4>& rest() const { return rest_; }
  /// [particles] place in the frame of the tool that holds it, m, and that tool's row; -1: free.
  const std::vector<Float4>& held() const { return held_; }
  const std::vector<float>& grid_values() const { return grid_values_; }

 private:
  struct Moving {
    MovedTool moved;
    Tool tool;
    bool let_go = false;
  };
  void fill_laws();
  void fill_rest(const VecList& rest);
  void fill_held();
  void fill_frame(const ToolMotion& motion, Float4* rows) const;
  bool held_by_any(Index particle) const;

  std::size_t most_steps_;
  std::vector<Moving> tools_, before_hold_;  // the latter until a step counts
  std::span<const double> mass_;             // kg, the model's
  std::vector<ToolMotion> motions_;          // of a batch ahead
  Vec3 middle_{0, 0, 0};                     // m
  std::vector<Float4> laws_, frames_, rest_, held_;
  std::size_t frames_filled_ = 0;
  std::vector<float> grid_values_;
  bool was_reset_ = false;     // the first reset is that of a solver being made
  mutable ToolReport unseen_;  // of a tool that follow() has not seen yet
};

}  // namespace phymul
