// SPDX-License-Identifier: MIT
//
// The parts of Solver that every implementation shares: shorthands, and the tools, joints and threads of its scene by
// name or handle.
#include <phymul/backend.h>
#include <phymul/elasticity.h>
#include <phymul/error.h>
#include <phymul/solver.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "elastic/local_steps.h"
#include "half_step.h"
#include "interaction/joint_set.h"
#include "interaction/stiff_joints.h"

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

// Energy of a state, and the forces that local steps and implicit joints change, in double precision for all backends.

VecList SolverBackend::substep_forces(const State& state, double dt, VecList further) const {
  const bool solves = stiff_joints_ && !scene_->joints().empty();
  if ((!local_steps_ && !solves) || !(dt > 0.0)) return further;
  VecList acceleration = free_accelerations(elastic(), *scene_, state, further);
  further.resize(state.position.size(), Vec3::Zero());
  if (local_steps_) {
    VecList x, a;
    for (const Index i : local_steps_->particle) {
      x.push_back(state.position[i]);
      a.push_back(acceleration[i]);
    }
    LocalForces forces(*local_steps_);
    LoadFrame now;
    scene_->prepare(now);
    for (std::size_t r = 0; r < x.size() && !now.fixed.empty(); ++r) {
      forces.imposed()[r] = now.fixed[local_steps_->particle[r]];
    }
    const std::span<const Vec3> change = forces.changes(x, a, dt, local_steps_->factor(scene_->stiffness_factors()));
    for (std::size_t r = 0; r < change.size(); ++r) {
      const Index i = local_steps_->particle[r];
      further[i] += change[r];
      acceleration[i] += change[r] / topology_->mass[i];
    }
  }
  if (solves) {
    LoadFrame now;
    scene_->prepare(now);
    StiffJointsNow now_solved(*scene_, state, *topology_, now.fixed, local_steps(), dt, options_.damping.factor_at(dt),
                              acceleration);
    for (const StiffJoints::Reached& reached : now_solved.joints.reached()) further[reached.particle] += reached.force;
  }
  return further;
}

void SolverBackend::set_last_velocities(std::vector<ToolState>& tools, double dt) const {
  for (std::size_t row = 0; row < scene_->tools().size(); ++row) {
    const auto own = std::ranges::find(tools, scene_->tools()[row].name, &ToolState::name);
    if (own == tools.end()) continue;
    const ToolReport& report = tool_report(row);
    const ToolPose &pose = report.pose, &last = report.last_pose;
    const Eigen::AngleAxisd turn(Eigen::Quaterniond(pose.orientation) *
                                 Eigen::Quaterniond(last.orientation).conjugate());
    if (pose.position != last.position) own->pose.velocity = (pose.position - last.position) / dt;
    if (turn.angle() > 0.0) own->pose.spin = turn.angle() / dt * turn.axis();
  }
}

Energy SolverBackend::energy_of(const State& state, double last_dt, const VecList& dissipative) const {
  LoadFrame now;  // not frame_: the scene may have changed since the last step
  scene_->prepare(now);
  scene_->evaluate(state.time, now);
  VecList force(state.position.size());
  elastic_forces(elastic(), state.position, force);
  Energy energy;
  VecList next = state.velocity;
  energy.elastic = elastic_energy(elastic(), state.position);
  if (!scene_->joints().empty()) energy.elastic += add_joint_forces(*scene_, read(), force);
  for (Index i = 0; i < topology_->particle_count; ++i) {
    const double m = topology_->mass[i];
    if (m == 0.0) continue;  // removed
    if (!now.force.empty()) force[i] += now.force[i];
    if (!dissipative.empty()) force[i] += dissipative[i];
    Vec3 a = force[i] / m + now.gravity;
    for (int axis = 0; axis < 3; ++axis) {
      if (!now.fixed.empty() && (now.fixed[i] >> axis & 1) != 0) a[axis] = 0.0;
    }
    next[i] += last_dt * a;
    energy.kinetic += 0.5 * m * state.velocity[i].dot(next[i]);
    energy.gravity -= m * now.gravity.dot(state.position[i] - topology_->rest[i]);
  }
  energy.kinetic += energy_of_larger_masses(state, next, last_dt, now.fixed);
  return energy;
}

double SolverBackend::energy_of_larger_masses(const State& state, const VecList& next, double dt,
                                              const std::vector<std::uint8_t>& fixed) const {
  double sum = 0.0;
  if (local_steps_ && !local_steps_->fine.empty()) {
    VecList v, later, free;
    for (const Index i : local_steps_->fine.particle) {
      v.push_back(state.velocity[i]);
      later.push_back(next[i]);
      Vec3& axes = free.emplace_back(1.0, 1.0, 1.0);
      for (int axis = 0; axis < 3; ++axis) {
        if (!fixed.empty() && (fixed[i] >> axis & 1) != 0) axes[axis] = 0.0;
      }
    }
    sum += local_steps_->fine.added_energy(v, later, free);
  }
  if (stiff_joints_ && !stiff_joints_->empty() && dt > 0.0) {
    const StiffJointsNow now(*scene_, read(), *topology_, fixed, local_steps(), dt, options_.damping.factor_at(dt),
                             VecList(next.size(), Vec3::Zero()));
    sum += now.joints.added_energy(state.velocity, next);
  }
  return sum;
}

}  // namespace phymul
