// SPDX-License-Identifier: MIT
//
// Simulation::solve_static: what it refuses, whether the body can be at rest at all, and from where the search begins.
#include <phymul/bodies.h>
#include <phymul/error.h>
#include <phymul/load_frame.h>
#include <phymul/monitor.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/decimal.h"
#include "elastic/scaled_tables.h"
#include "interaction/tool_shape.h"
#include "simulation_parts.h"
#include "statics/rest_body.h"
#include "statics/rest_search.h"
#include "statics/rest_tools.h"

namespace phymul {
namespace {

/// Of strained_energy(): less is rounding.
constexpr double no_gain = 1e-12;
/// Of the forces and their moments: less is rounding.
constexpr double unbalanced = 1e-8;

[[noreturn]] void refuse(const std::string& what) {
  throw Error(ErrorCode::not_supported, "Simulation::solve_static: " + what + "; use run_to_rest()");
}

/// A tool that stands still, slides without friction and is known by all its numbers.
void require_supported(const SceneTool& tool, const Solver& solver) {
  const std::string name = "the tool \"" + tool.name + '"';
  const std::string_view more = beyond_pressing(tool.tool);
  if (!more.empty()) refuse(name + ' ' + std::string(more));
  if (tool.tool.friction > 0.0) refuse(name + " has friction, by which the rest shape depends on the way to it");
  if (tool.tool.compliance > 0.0 && tool.tool.contact == ToolContact::surface) {
    refuse(name + " has compliance and ToolContact::surface");
  }
  if (tool.pose.velocity != Vec3::Zero() || tool.pose.spin != Vec3::Zero()) {
    throw Error(ErrorCode::not_supported, "Simulation::solve_static: " + name +
                                              " has a velocity; move_to() the pose where it shall stand, without one");
  }
  if (!solver.has_grasp_ahead(tool.name)) return;
  refuse(name + (tool.grasping ? " is to grasp" : " is to release") + " in the next step: take a step before");
}

void require_supported(const TopologyTextures& topology, const Scene& scene, const Solver& solver) {
  if (topology.dimension == 2) refuse("expected a body in three dimensions, got one in two");
  const bool walls = !topology.walls.empty();
  if (walls && !topology.domains.empty()) refuse("expected a body of cells or of walls alone, got both in one model");
  if (walls && !scene.tools().empty()) refuse("the body has walls, and the scene has tools");
  if (walls && !scene.joints().empty()) refuse("the body has walls, and the scene has joints");
  if (!walls && !AveragedStiffness::is_all_of(topology)) {
    refuse("expected a body with a material, got stiffnesses in N/m");
  }
  std::vector<char> elastic(static_cast<std::size_t>(topology.particle_count), 0);
  for (const DomainTexel& domain : topology.domains) elastic[domain.particle] = 1;
  for (const WallTexel& wall : topology.walls) {
    for (std::size_t k = 0; k < 3; ++k) elastic[wall.vertex[k]] = 1;
  }
  for (Index i = 0; i < topology.particle_count; ++i) {
    if (elastic[i] != 0 || topology.mass[i] == 0.0) continue;
    refuse("particle " + std::to_string(i) + " is in no cell with a material");
  }
  for (const SceneTool& tool : scene.tools()) require_supported(tool, solver);
  if (!scene.threads().empty()) refuse("the scene has threads");
  if (scene.contacts()) refuse("the scene has contacts");
  if (!scene.volume_constraints().empty()) refuse("the scene has a volume constraint");
  for (std::size_t row = 0; row < scene.loads().size(); ++row) {
    const std::vector<ValueEvent>& events = scene.loads()[row].events;
    if (events.empty() || !(events.back().date > solver.time())) continue;
    refuse("load " + std::to_string(row) + " has an event at " + to_decimal(events.back().date) +
           " s, after the present " + to_decimal(solver.time()) + " s");
  }
}

/// J, of strains of about 1.
double strained_energy(const TopologyTextures& topology) {
  double energy = 0.0;
  for (const DomainTexel& domain : topology.domains)
    energy += topology.energies[domain.energy][0] / domain.inverse_volume;
  return energy;
}

/// The bodies of which imposed coordinates do not hold every rigid motion. A clamped edge (clamp_edges) of a wall keeps
/// its direction in space, so that it turns about none of its held particles.
std::vector<ConnectedBody> loose_bodies(const Model& model, const LoadFrame& loads) {
  std::vector<ConnectedBody> bodies = connected_bodies(model);
  std::vector<char> clamped(model.rest.size(), 0);
  for (const Cell& cell : model.cells) {
    if (cell.type != CellType::line || cell.material < 0 || loads.fixed.empty()) continue;
    for (const Index i : cell.particles) clamped[i] = loads.fixed[i] == 7;
  }
  std::erase_if(bodies, [&](const ConnectedBody& body) {
    return std::ranges::any_of(body.particles, [&](Index i) { return clamped[i] != 0; });
  });
  std::erase_if(
      bodies, [&](const ConnectedBody& body) { return free_motions(body.particles, model.rest, loads.fixed).empty(); });
  return bodies;
}

/// What is wrong if the loads drive a rigid motion of a body that meets no support; else empty. Whether joints and
/// tools hold a body is left to the search.
std::string why_no_rest(const Model& model, const LoadFrame& loads, RestTerms terms,
                        std::span<const ConnectedBody> loose) {
  std::vector<char> held(model.rest.size(), 0);
  for (const RestTerm* term : terms) term->mark_held(held);
  for (const ConnectedBody& body : loose) {
    if (std::ranges::any_of(body.particles, [&](Index i) { return held[i] != 0; })) continue;
    const std::vector<RigidMotion> motions = free_motions(body.particles, model.rest, loads.fixed);
    for (const RigidMotion& motion : motions) {
      double driving = 0.0, forces = 0.0;
      for (const Index i : body.particles) {
        Vec3 force = load_on(model.mass, loads, i);
        forces += force.norm();
        for (int axis = 0; axis < 3 && !loads.fixed.empty(); ++axis) {
          if ((loads.fixed[i] >> axis & 1) != 0) force[axis] = 0.0;
        }
        driving += force.dot(motion.at(model.rest[i]));
      }
      if (std::abs(driving) <= unbalanced * forces) continue;
      const std::string name =
          body.name.empty() ? "the body of particle " + std::to_string(body.particles.front()) : '"' + body.name + '"';
      if (terms.empty() && motions.size() == 6) {
        return "nothing holds " + name + ", and the loads drive it: it moves away; hold it, as with Scene::fix()";
      }
      return name +
             " has no rest as it lies: a rigid motion of it meets no support, and the loads drive it; hold it, or use "
             "run_to_rest()";
    }
  }
  return {};
}

/// Calls visit(pose, tool) for the tools of the state that the scene still has.
template <class Tools, class Visit>
void for_each_tool(const Scene& scene, Tools& tools, const Visit& visit) {
  for (auto& tool : tools) {
    const auto wanted = std::ranges::find(scene.tools(), tool.name, &SceneTool::name);
    if (wanted != scene.tools().end()) visit(wanted->pose, tool);
  }
}

/// What tools grasp goes where they are.
void hold_grasped(const Scene& scene, const State& state, LoadFrame& loads) {
  for_each_tool(scene, state.tools, [&](const ToolPose& pose, const ToolState& tool) {
    if (tool.held.empty()) return;
    loads.fixed.resize(state.position.size(), 0);
    loads.target.resize(state.position.size(), Vec3::Zero());
    for (std::size_t k = 0; k < tool.held.size(); ++k) {
      const Index i = tool.held[k];
      const Vec3 target = pose.position + pose.orientation * tool.held_at[k];
      for (int axis = 0; axis < 3; ++axis) {
        if ((loads.fixed[i] >> axis & 1) == 0) loads.target[i][axis] = target[axis];
      }
      loads.fixed[i] = 7;
    }
  });
}

/// Particles that no cell has stay where they are: removed ones, and spare ones.
void hold_removed(const TopologyTextures& topology, const State& state, LoadFrame& loads) {
  for (std::size_t i = 0; i < topology.mass.size(); ++i) {
    if (topology.mass[i] != 0.0) continue;
    loads.fixed.resize(state.position.size(), 0);
    loads.target.resize(state.position.size(), Vec3::Zero());
    loads.target[i] = state.position[i];
    loads.fixed[i] = 7;
  }
}

/// What grasped particles at rest do to their tools, by Scene::tools().
std::vector<ToolForce> of_held(const TopologyTextures& topology, const Scene& scene, const State& state,
                               RestTerms terms) {
  std::vector<ToolForce> all(scene.tools().size());
  if (std::ranges::all_of(state.tools, [](const ToolState& tool) { return tool.held.empty(); })) return all;
  LoadFrame loads;
  scene.prepare(loads);
  scene.evaluate(state.time, loads);
  VecList force(state.position.size());
  elastic_forces(topology, state.position, force);
  for (const RestTerm* term : terms) term->add_forces(state.position, force);
  for_each_tool(scene, state.tools, [&](const ToolPose& pose, const ToolState& tool) {
    ToolForce& felt = all[static_cast<std::size_t>(std::ranges::find(scene.tools(), tool.name, &SceneTool::name) -
                                                   scene.tools().begin())];
    for (const Index i : tool.held) {
      Vec3 own = force[i] + load_on(topology.mass, loads, static_cast<std::size_t>(i));
      for (int axis = 0; axis < 3 && !loads.fixed.empty(); ++axis) {
        if ((loads.fixed[i] >> axis & 1) != 0) own[axis] = 0.0;
      }
      felt.force += own;
      felt.torque += (state.position[i] - pose.position).cross(own);
      ++felt.particles;
    }
  });
  return all;
}

/// m^2: by how much imposed coordinates miss their places.
double squared_way_to_targets(const LoadFrame& loads, const VecList& position) {
  double sum = 0.0;
  for (std::size_t i = 0; i < loads.fixed.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double way = loads.target[i][axis] - position[i][axis];
      if ((loads.fixed[i] >> axis & 1) != 0) sum += way * way;
    }
  }
  return sum;
}

}  // namespace

std::string StaticResult::message() const {
  char numbers[160];
  std::snprintf(numbers, sizeof numbers, "after %d evaluations, residual %.3g of the loads, largest net force %.3g N",
                evaluations, residual, largest_force);
  if (status == RestStatus::failed) return "no rest shape found: " + cause;
  if (!converged()) return std::string("not at rest ") + numbers + "; the state is kept";
  std::string text = std::string("at rest ") + numbers;
  if (folded >= 0) text += "; cell " + std::to_string(folded) + " is flat or inside out";
  return text;
}

void Simulation::Parts::follow_at_rest(const LoadFrame& loads) {
  const std::vector<double>& factors = scene.stiffness_factors();
  // There is no body for walls, and where making one threw an error.
  if (at_rest.body != nullptr && at_rest.body_version == scene.body_version() && at_rest.factors == factors &&
      at_rest.fixed == loads.fixed) {
    return;
  }
  at_rest = {};  // before its tables change
  at_rest.body_version = scene.body_version();
  at_rest.factors = factors;
  at_rest.fixed = loads.fixed;
  at_rest.loose = loose_bodies(model, loads);
  const TopologyTextures& tables = elastic();
  if (tables.walls.empty()) at_rest.body = std::make_unique<RestBody>(tables, loads.fixed);
}

StaticResult Simulation::solve_static(const StaticOptions& options) {
  if (!(options.tolerance > 0.0) || !std::isfinite(options.tolerance)) {
    throw Error("StaticOptions::tolerance must be finite and above 0; got " + to_decimal(options.tolerance));
  }
  if (options.most_evaluations < 1) {
    throw Error("StaticOptions::most_evaluations must be at least 1; got " + std::to_string(options.most_evaluations));
  }
  const TopologyTextures& topology = parts_->elastic();
  State state = solver().read();
  require_supported(topology, scene(), solver());
  LoadFrame loads;
  scene().prepare(loads);
  scene().evaluate(state.time, loads);
  hold_grasped(scene(), state, loads);
  hold_removed(topology, state, loads);
  RestJoints joints(scene(), state);
  const bool has_tools = !scene().tools().empty();
  parts_->follow_at_rest(loads);
  const std::vector<ConnectedBody>& loose = parts_->at_rest.loose;
  RestBody* const body = parts_->at_rest.body.get();
  const std::span<const Mat3> diagonal = body != nullptr ? body->diagonal() : std::span<const Mat3>();
  std::unique_ptr<RestTools>& tools = parts_->at_rest.tools;
  const auto make_tools = [&] { tools = std::make_unique<RestTools>(scene(), diagonal, loads.fixed); };
  const bool follows = options.predict && parts_->at_rest.end == state.position;
  if (!follows || !tools->follow(scene())) make_tools();
  std::vector<RestTerm*> terms;
  if (!joints.empty()) terms.push_back(&joints);
  if (has_tools) terms.push_back(tools.get());
  StaticResult result;
  result.cause = why_no_rest(model(), loads, terms, loose);
  const bool walls = !topology.walls.empty();
  if (walls && !loose.empty() && result.cause.empty()) {
    result.cause = "a wall is not held against every rigid motion; hold it, or use run_to_rest()";
  }
  if (!result.cause.empty()) return result;

  double gain = 0.0;  // J, by beginning at the rest shape, where springs and tools alone may have energy
  if (!follows && state.position != topology.rest) {
    gain = potential_energy(topology, loads, terms, state.position);
    for (const RestTerm* term : terms) gain -= term->energy(topology.rest);
  }
  // What is imposed in parts is not begun anew: imposed coordinates that are nearer their places stay.
  const bool begins_anew =
      gain > no_gain * strained_energy(topology) &&
      squared_way_to_targets(loads, topology.rest) <= squared_way_to_targets(loads, state.position);
  if (begins_anew) state.position = topology.rest;
  const auto search = [&](int most_evaluations) {
    if (walls) return search_wall_rest(topology, loads, options.tolerance, most_evaluations, state.position);
    StaticOptions own = options;
    own.most_evaluations = most_evaluations;
    return search_rest(*body, loads, terms, loose, own, state.position);
  };
  parts_->at_rest.end.clear();
  RestSearchEnd end = search(options.most_evaluations);
  result.evaluations = end.evaluations;
  if (end.stuck && !begins_anew && end.evaluations < options.most_evaluations) {
    state.position = topology.rest;
    make_tools();  // without the estimates of the search that got stuck
    if (has_tools) terms.back() = tools.get();
    end = search(options.most_evaluations - end.evaluations);
    result.evaluations += end.evaluations;
  }
  result.residual = end.residual;
  result.largest_force = end.largest_force;
  const std::string overloaded = end.at_rest ? joints.overloaded(state.position) : std::string();
  if (!overloaded.empty()) {
    result.cause = "at rest a spring of joint \"" + overloaded +
                   "\" would carry more than its breaking force; use run_to_rest(), in which it breaks";
  } else if (end.at_rest) {
    for (Vec3& velocity : state.velocity) velocity.setZero();
    std::vector<ToolForce> forces = of_held(topology, scene(), state, terms);
    tools->add_reactions(state.position, forces);
    joints.add_reactions(state.position, forces);
    for_each_tool(scene(), state.tools, [](const ToolPose& pose, ToolState& tool) {
      tool.pose = pose;
      tool.placed = true;  // points of a surface may be inside by a little, and are to come out without a force
    });
    parts_->start_at_rest(state, forces, joints.reports(state.position));
    parts_->at_rest.end = solver().read().position;
    result.status = RestStatus::converged;
    result.folded = first_folded_cell(model(), state.position);
  } else if (end.stuck) {
    result.cause =
        "the search got stuck where no small step lowers the energy, as where cells fold; load in smaller parts";
  } else {
    result.status = RestStatus::step_limit;
  }
  return result;
}

}  // namespace phymul
