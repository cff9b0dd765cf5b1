// SPDX-License-Identifier: MIT
#include "float_tools.h"

#include <phymul/distance_grid.h>

#include <algorithm>
#include <utility>

#include "interaction/distance_to_shape.h"
#include "interaction/tool_frame.h"
#include "interaction/tool_shape.h"

namespace phymul {

void FloatTools::follow(const Scene& scene) {
  before_hold_.clear();
  std::vector<Moving> now;
  for (const SceneTool& tool : scene.tools()) {
    const auto known = std::ranges::find(tools_, tool.id, [](const Moving& moving) { return moving.moved.id; });
    now.push_back(known != tools_.end() ? *known : Moving{MovedTool(tool), tool.tool});  // a copy may fail
  }
  tools_ = std::move(now);
  mass_ = scene.model().mass;
  for (Moving& moving : tools_) moving.moved.let_go_of_removed(mass_);
  fill_laws();
  fill_rest(scene.model().rest);
  fill_held();
  motions_.reserve(tools_.size());
  frames_.assign((most_steps_ + 1) * tools_.size() * frame_rows, Float4{});
  begin_batch(1, 0.0);
}

void FloatTools::fill_laws() {
  laws_.clear();
  grid_values_.clear();
  for (const Moving& moving : tools_) {
    const Tool& tool = moving.tool;
    const ToolExtent extent = extent_of(tool);
    laws_.push_back(float4(extent.size, static_cast<float>(kind_of(tool.shape))));
    laws_.push_back(
        {to_float(tool.margin), to_float(extent.thickness), to_float(tool.friction), to_float(tool.compliance)});
    const auto* grid = std::get_if<std::shared_ptr<const DistanceGrid>>(&tool.shape);
    if (!grid) {
      laws_.insert(laws_.end(), 2, Float4{});
      continue;
    }
    const auto [nx, ny, nz] = (*grid)->count();
    laws_.push_back(float4((*grid)->origin(), to_float((*grid)->spacing())));
    const std::size_t first = grid_values_.size() / grid_unit;
    laws_.push_back(
        {static_cast<float>(nx), static_cast<float>(ny), static_cast<float>(nz), static_cast<float>(first)});
    grid_values_.insert(grid_values_.end(), (*grid)->values().begin(), (*grid)->values().end());
    grid_values_.resize((grid_values_.size() + grid_unit - 1) / grid_unit * grid_unit, 0.0f);
  }
}

void FloatTools::fill_rest(const VecList& rest) {
  middle_.setZero();
  rest_.clear();
  if (empty()) return;
  for (const Vec3& X : rest) middle_ += X / static_cast<double>(rest.size());
  for (const Vec3& X : rest) {
    for (const Float4& half : halves(X - middle_)) rest_.push_back(half);
  }
}

void FloatTools::fill_held() {
  held_.assign(rest_.size() / rest_rows, Float4{0.0f, 0.0f, 0.0f, -1.0f});
  for (std::size_t row = 0; row < tools_.size(); ++row) {
    const MovedTool& tool = tools_[row].moved;
    for (std::size_t k = 0; k < tool.held.size(); ++k) {
      held_[static_cast<std::size_t>(tool.held[k])] = float4(tool.held_at[k], static_cast<float>(row));
    }
  }
}

void FloatTools::set_moved(std::size_t row, const MovedTool& moved) {
  tools_[row].moved = moved;
  fill_held();
}

void FloatTools::reset(const Scene& scene, const State& state) {
  before_hold_.clear();
  for (std::size_t row = 0; row < tools_.size(); ++row) {
    tools_[row].moved.reset(scene.tools()[row], state, mass_, !was_reset_);
  }
  was_reset_ = true;
  fill_held();
}

void FloatTools::read(const Scene& scene, State& state) const {
  state.tools.resize(tools_.size());
  std::size_t count = 0;
  for (const Moving& tool : tools_) {
    if (tool.moved.is_in(scene)) tool.moved.read(state.tools[count++]);
  }
  state.tools.resize(count);
}

bool FloatTools::begin_call(const Scene& scene, int steps, bool at_once) {
  if (steps == 0) return false;
  for (std::size_t row = 0; row < tools_.size(); ++row) {
    tools_[row].moved.begin_call(scene.tools()[row], steps, at_once);
  }
  return std::ranges::any_of(tools_, [](const Moving& tool) { return tool.moved.grasps || tool.moved.releases; });
}

bool FloatTools::grasps() const {
  return std::ranges::any_of(tools_, [](const Moving& tool) { return tool.moved.grasps; });
}

bool FloatTools::held_by_any(Index particle) const {
  return std::ranges::any_of(tools_,
                             [&](const Moving& tool) { return std::ranges::count(tool.moved.held, particle) > 0; });
}

bool FloatTools::undo_hold() {
  if (before_hold_.empty()) return false;
  tools_ = std::exchange(before_hold_, {});
  fill_held();
  return true;
}

void FloatTools::hold(const VecList& position, std::span<const std::uint8_t> fixed, bool plane) {
  before_hold_ = tools_;
  for (Moving& tool : tools_) {
    if (tool.moved.releases) tool.moved.release();
  }
  for (Moving& tool : tools_) {
    MovedTool& moved = tool.moved;
    if (!moved.grasps) continue;
    moved.grasps = false;
    for (const auto& [i, at] : particles_to_grasp(tool.tool, moved.motion.pose, moved.grasp_distance, position)) {
      const int axes = (fixed.empty() ? 0 : fixed[static_cast<std::size_t>(i)]) | (plane ? 4 : 0);
      if (axes == 7 || held_by_any(i)) continue;
      moved.take_hold(i, at);
    }
    moved.weigh_held(mass_);
  }
  fill_held();
}

/// Of a motion whose next pose is known.
void FloatTools::fill_frame(const ToolMotion& motion, Float4* rows) const {
  const Mat3 turn = motion.pose.orientation.toRotationMatrix();
  const Mat3 gain = motion.next_pose.orientation.toRotationMatrix() - turn;
  const Vec3 gone = motion.next_pose.position - motion.pose.position;
  const auto [high, low] = halves(motion.pose.position - middle_);
  for (int axis = 0; axis < 3; ++axis) {
    rows[axis] = float4(turn.col(axis), high[static_cast<std::size_t>(axis)]);
    rows[4 + axis] = float4(gain.col(axis), static_cast<float>(gone[axis]));
  }
  rows[3] = {low[0], low[1], low[2], motion.placed ? 1.0f : 0.0f};
}

int FloatTools::begin_batch(int steps, double dt) {
  int finite = steps;
  motions_.clear();
  for (const Moving& tool : tools_) motions_.push_back(tool.moved.motion);
  Float4* rows = frames_.data();
  for (int step = 0; step <= steps; ++step) {
    for (std::size_t row = 0; row < motions_.size(); ++row) {
      ToolMotion& motion = motions_[row];
      motion.advance(dt);
      if (!is_finite(motion.next_pose)) finite = std::min(finite, step);
      fill_frame(motion, rows);
      if (tools_[row].let_go) rows[3][3] = -1.0f;
      rows += frame_rows;
      motion.accept();
    }
  }
  frames_filled_ = static_cast<std::size_t>(rows - frames_.data());
  return finite;
}

void FloatTools::accept(int steps, double dt, std::span<const ToolSums> sums, std::span<const JointSet::Pull> pulls,
                        std::span<const JointSet::Pull> pull_sums) {
  before_hold_.clear();
  for (std::size_t row = 0; row < tools_.size(); ++row) {
    MovedTool& tool = tools_[row].moved;
    for (int step = 0; step < steps; ++step) {
      tool.motion.advance(dt);
      tool.accept_pose();
    }
    const ToolForce last{.force = widened(sums[row].last_force) + pulls[row].force,
                         .torque = widened(sums[row].last_torque) + pulls[row].torque,
                         .particles = static_cast<int>(sums[row].last_force[3])};
    tool.tell(last, widened(sums[row].force) + pull_sums[row].force, widened(sums[row].torque) + pull_sums[row].torque,
              steps);
  }
}

const ToolReport& FloatTools::report(const SceneTool& wanted) const {
  const auto known = std::ranges::find(tools_, wanted.id, [](const Moving& moving) { return moving.moved.id; });
  if (known != tools_.end()) return known->moved.report;
  unseen_ = {};
  unseen_.pose = unseen_.last_pose = first_pose(wanted);
  return unseen_;
}

}  // namespace phymul
