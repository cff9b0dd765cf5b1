// SPDX-License-Identifier: MIT
#include "moved_tool.h"

#include <algorithm>

namespace phymul {
namespace {

ToolPose between(const ToolPose& from, const ToolPose& to, double share) {
  ToolPose pose = to;
  pose.position = from.position + share * (to.position - from.position);
  pose.orientation = from.orientation.slerp(share, to.orientation);
  return pose;
}

}  // namespace

void ToolMotion::place(const ToolPose& there) {
  pose = next_pose = to = there;
  steps = done = 0;
  placed = true;
}

void ToolMotion::advance(double dt) {
  if (done < steps) {
    const int next = done + 1;
    next_pose = next == steps ? to : between(from, to, static_cast<double>(next) / steps);
    return;
  }
  next_pose = pose;
  next_pose.position += dt * pose.velocity;
  const double angle = dt * pose.spin.norm();
  if (!(angle > 0.0)) return;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, pose.spin.normalized()));
  next_pose.orientation = Quaternion(turn * Eigen::Quaterniond(pose.orientation)).normalized();
}

void ToolMotion::accept() {
  pose = next_pose;
  placed = false;
  if (done < steps && ++done == steps) steps = done = 0;
}

const ToolPose& first_pose(const SceneTool& tool) {
  return tool.places == 0 ? tool.tool.pose : tool.pose;
}

MovedTool::MovedTool(const SceneTool& tool) : id(tool.id), name(tool.name) {
  place_first(tool);
}

void MovedTool::place_first(const SceneTool& tool) {
  place(first_pose(tool));
  seen_moves_ = tool.places == 0 ? 0 : tool.moves;
  seen_places_ = tool.places;
}

void MovedTool::place(const ToolPose& pose) {
  motion.place(pose);
  report.pose = report.last_pose = pose;
}

const ToolState* MovedTool::reset(const SceneTool& wanted, const State& state, std::span<const double> mass,
                                  bool first) {
  const auto row = std::ranges::find(state.tools, name, &ToolState::name);
  const ToolState* const known = row != state.tools.end() ? &*row : nullptr;
  if (first && !known) {  // what it was told before the solver was there, it does in the first step
    place_first(wanted);
  } else {
    place(known ? known->pose : wanted.pose);
    seen_moves_ = wanted.moves;
    seen_places_ = wanted.places;
  }
  held = known ? known->held : std::vector<Index>{};
  held_at = known ? known->held_at : VecList{};
  motion.placed = known == nullptr || known->placed;
  report.held = static_cast<int>(held.size());
  grasps = releases = false;
  report.grasps = seen_grasps_ = wanted.grasping && first && !known ? wanted.grasps - 1 : wanted.grasps;
  report.force = {};
  weigh_held(mass);
  return known;
}

void MovedTool::read(ToolState& to) const {
  to.name = name;
  to.pose = report.pose;
  to.placed = motion.placed;
  to.held = held;
  to.held_at = held_at;
  to.needle = {};
  to.blade.clear();
}

bool MovedTool::is_in(const Scene& scene) const {
  return std::ranges::find(scene.tools(), id, &SceneTool::id) != scene.tools().end();
}

bool MovedTool::begin_call(const SceneTool& wanted, int call_steps, bool at_once) {
  sum_force_.setZero();
  sum_torque_.setZero();
  summed_ = 0;
  const bool moves = seen_moves_ != wanted.moves;
  if (seen_places_ != wanted.places) {
    seen_places_ = wanted.places;
    seen_moves_ = wanted.moves;
    place(wanted.pose);
  } else if (seen_moves_ != wanted.moves || motion.done < motion.steps) {
    seen_moves_ = wanted.moves;
    motion.from = motion.pose;
    motion.to = wanted.pose;
    motion.steps = at_once ? 1 : call_steps;
    motion.done = 0;
  }
  if (report.grasps == wanted.grasps) return moves;
  releases = releases || wanted.released > report.grasps;  // a step that failed has not done it
  grasps = wanted.grasping;
  seen_grasps_ = wanted.grasps;
  grasp_distance = wanted.grasp_distance;
  return moves;
}

void MovedTool::take_hold(Index particle, const Vec3& at) {
  held.push_back(particle);
  held_at.push_back(at);
  report.held = static_cast<int>(held.size());
}

void MovedTool::let_go_of_removed(std::span<const double> mass) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < held.size(); ++k) {
    if (mass[static_cast<std::size_t>(held[k])] == 0.0) continue;
    held[kept] = held[k];
    held_at[kept++] = held_at[k];
  }
  held.resize(kept);
  held_at.resize(kept);
  report.held = static_cast<int>(kept);
  weigh_held(mass);  // also where all stay: they may have lost cells
}

void MovedTool::release() {
  held.clear();
  held_at.clear();
  report.held = 0;
  releases = false;
  weigh_held({});
}

void MovedTool::weigh_held(std::span<const double> mass) {
  double total = 0.0;
  Vec3 moment = Vec3::Zero();
  Mat3 inertia = Mat3::Zero();
  for (std::size_t k = 0; k < held.size(); ++k) {
    const double m = mass[static_cast<std::size_t>(held[k])];
    const Vec3& q = held_at[k];
    total += m;
    moment += m * q;
    inertia += m * (q.squaredNorm() * Mat3::Identity() - q * q.transpose());
  }
  report.force.held_mass = total;
  report.force.held_centre = total > 0.0 ? Vec3(moment / total) : Vec3(Vec3::Zero());
  report.force.held_inertia = inertia;
}

void MovedTool::accept_pose() {
  report.last_pose = motion.pose;
  motion.accept();
  report.pose = motion.pose;
  report.grasps = seen_grasps_;
}

void MovedTool::tell(const ToolForce& last, const Vec3& sum_force, const Vec3& sum_torque, int steps) {
  report.force.force = last.force;
  report.force.torque = last.torque;
  report.force.particles = last.particles;
  sum_force_ += sum_force;
  sum_torque_ += sum_torque;
  summed_ += steps;
  report.force.mean_force = sum_force_ / summed_;
  report.force.mean_torque = sum_torque_ / summed_;
}

}  // namespace phymul
