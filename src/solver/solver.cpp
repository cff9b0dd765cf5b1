// SPDX-License-Identifier: MIT
//
// The parts of Solver that every implementation shares: shorthands, and the tools, joints and threads of its scene by
// name or handle.
#include <phymul/backend.h>
#include <phymul/error.h>
#include <phymul/solver.h>

#include <algorithm>

namespace phymul {
namespace {

template <class Items>
std::size_t row_named(const Items& items, const std::string& kind, std::string_view name) {
  const auto own = std::ranges::find(items, name, &Items::value_type::name);
  if (own != items.end()) return own - items.begin();
  throw Error(ErrorCode::unknown_name, "the scene has no " + kind + " \"" + std::string(name) + '"');
}

template <class Items, class Handle>
std::size_t row_of(const Scene& scene, const Items& items, const std::string& kind, const Handle& handle) {
  if (!handle.is_of(scene)) {
    throw Error("the handle is of a " + kind + " of another scene than the solver's; take one from Scene::" + kind +
                " of that scene");
  }
  const auto own = std::ranges::find(items, handle.id(), &Items::value_type::id);
  if (own != items.end()) return own - items.begin();
  throw Error(ErrorCode::unknown_name, "the scene no longer has the " + kind + " of this handle; Scene::" + kind +
                                           " gives handles of those it has");
}

}  // namespace

const ThreadState& SolverBackend::do_thread_state(std::size_t) const {
  throw Error(ErrorCode::not_supported, "this backend does not take threads");
}

const FluidState& SolverBackend::do_fluid(std::size_t) const {
  throw Error(ErrorCode::not_supported,
              "Solver::fluid: this backend does not report fluids; use \"cpu\" or \"reference\"");
}

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
  return row_named(scene().tools(), "tool", name);
}

std::size_t Solver::tool_row(const ToolHandle& tool) const {
  return row_of(scene(), scene().tools(), "tool", tool);
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
  return joint_report_at(row_named(scene().joints(), "joint", name));
}

const JointReport& Solver::joint_report(const JointHandle& joint) const {
  return joint_report_at(row_of(scene(), scene().joints(), "joint", joint));
}

const ThreadState& Solver::thread_state(std::string_view name) const {
  return thread_state_at(row_named(scene().threads(), "thread", name));
}

const FluidState& Solver::fluid(std::string_view name) const {
  return fluid_at(row_named(scene().volume_constraints(), "volume constraint", name));
}

const ThreadState& Solver::thread_state(const ThreadHandle& thread) const {
  return thread_state_at(row_of(scene(), scene().threads(), "thread", thread));
}

}  // namespace phymul
