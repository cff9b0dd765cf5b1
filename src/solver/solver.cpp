// SPDX-License-Identifier: MIT
//
// The parts of Solver that every implementation shares: shorthands, and the tools and joints of its scene by name or
// handle.
#include <phymul/error.h>
#include <phymul/solver.h>

namespace phymul {

Solver::Solver() = default;
Solver::~Solver() = default;

void Solver::reset() {
  reset(rest_state(model()));
}

RestResult Solver::run_to_rest(int max_steps, double dt) {
  return run_to_rest(max_steps, dt, options().damping);
}

State Solver::read() const {
  State state;
  read(state);
  return state;
}

std::size_t Solver::tool_row(std::string_view name) const {
  const std::vector<SceneTool>& tools = scene().tools();
  for (std::size_t row = 0; row < tools.size(); ++row) {
    if (tools[row].name == name) return row;
  }
  throw Error(ErrorCode::unknown_name, "the scene has no tool \"" + std::string(name) + '"');
}

std::size_t Solver::tool_row(const ToolHandle& tool) const {
  if (!tool.is_of(scene())) {
    throw Error("the handle is of a tool of another scene than the solver's; take one from Scene::tool of that scene");
  }
  const std::vector<SceneTool>& tools = scene().tools();
  for (std::size_t row = 0; row < tools.size(); ++row) {
    if (tools[row].id == tool.id()) return row;
  }
  throw Error(ErrorCode::unknown_name,
              "the scene no longer has the tool of this handle; Scene::tool gives handles of those it has");
}

const ToolForce& Solver::tool_force(const ToolHandle& tool) const {
  return tool_report(tool_row(tool)).force;
}

const ToolPose& Solver::tool_pose(const ToolHandle& tool) const {
  return tool_report(tool_row(tool)).pose;
}

const ToolForce& Solver::tool_force(std::string_view name) const {
  return tool_report(tool_row(name)).force;
}

const ToolPose& Solver::tool_pose(std::string_view name) const {
  return tool_report(tool_row(name)).pose;
}

int Solver::held(const ToolHandle& tool) const {
  return tool_report(tool_row(tool)).held;
}

int Solver::held(std::string_view name) const {
  return tool_report(tool_row(name)).held;
}

bool Solver::has_grasp_ahead(std::string_view name) const {
  const std::size_t row = tool_row(name);
  return tool_report(row).grasps != scene().tools()[row].grasps;
}

VecList Solver::needle_points(std::string_view name, int count) const {
  const std::size_t row = tool_row(name);
  const auto* const needle = std::get_if<Needle>(&scene().tools()[row].tool.shape);
  if (needle == nullptr) throw Error("tool \"" + std::string(name) + "\": expected a needle, got another shape");
  const ToolReport& report = tool_report(row);
  VecList points = shaft_points(*needle, report.shaft, count);
  for (Vec3& point : points) point = report.pose.position + report.pose.orientation * point;
  return points;
}

const JointReport& Solver::joint_report(std::string_view name) const {
  const std::vector<SceneJoint>& joints = scene().joints();
  for (std::size_t row = 0; row < joints.size(); ++row) {
    if (joints[row].name == name) return joint_report_at(row);
  }
  throw Error(ErrorCode::unknown_name, "the scene has no joint \"" + std::string(name) + '"');
}

const JointReport& Solver::joint_report(const JointHandle& joint) const {
  if (!joint.is_of(scene())) {
    throw Error(
        "the handle is of a joint of another scene than the solver's; take one from Scene::joint of that scene");
  }
  const std::vector<SceneJoint>& joints = scene().joints();
  for (std::size_t row = 0; row < joints.size(); ++row) {
    if (joints[row].id == joint.id()) return joint_report_at(row);
  }
  throw Error(ErrorCode::unknown_name,
              "the scene no longer has the joint of this handle; Scene::joint gives handles of those it has");
}

}  // namespace phymul
