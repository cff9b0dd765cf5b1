// SPDX-License-Identifier: MIT
#include "tool_set.h"

#include <phymul/distance_grid.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace phymul::cpu {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

struct Extent {
  ShapeIn<double> shape;
  Vec3 low, high;
};

Extent extent_of(const Sphere& sphere) {
  const double r = sphere.radius;
  return {{.kind = ShapeKind::sphere, .size = {r, 0, 0}, .thickness = r}, {-r, -r, -r}, {r, r, r}};
}
Extent extent_of(const Capsule& capsule) {
  const double r = capsule.radius;
  return {{.kind = ShapeKind::capsule, .size = {r, capsule.length, 0}, .thickness = r},
          {-r, -r, -r},
          {r, r, capsule.length + r}};
}
Extent extent_of(const HalfSpace&) {
  return {{.kind = ShapeKind::half_space, .thickness = infinite}, Vec3::Constant(-infinite), Vec3::Constant(infinite)};
}
Extent extent_of(const Box& box) {
  return {{.kind = ShapeKind::box, .size = unpacked(box.half_size), .thickness = box.half_size.minCoeff()},
          -box.half_size,
          box.half_size};
}

Extent extent_of(const std::shared_ptr<const DistanceGrid>& grid) {
  const auto [nx, ny, nz] = grid->count();
  const GridValues<double> values{grid->values().data(), nx, ny, nz, unpacked(grid->origin()), grid->spacing()};
  return {{.kind = ShapeKind::grid, .thickness = std::min(grid->depth(), grid->spacing()), .grid = values},
          grid->origin(),
          grid->origin() + grid->spacing() * Vec3(nx - 1, ny - 1, nz - 1)};
}

/// The world's box around one in the tool's frame.
void grow(Region& region, const ToolFrame& frame, const Region& own) {
  const Vec3 centre = frame.outside(0.5 * (own.low + own.high));
  const Vec3 half = frame.turn.cwiseAbs() * (0.5 * (own.high - own.low));
  region.low = region.low.cwiseMin(centre - half);
  region.high = region.high.cwiseMax(centre + half);
}

/// Where a shape may meet a particle on the way between two poses. Corners go along arcs: a turn by an angle takes them
/// off their chords by at most their distance times 1 - cos of half of it.
Region reach_between(const ShapeIn<double>& shape, const Region& own, const ToolFrame& start, const ToolFrame& end,
                     double more) {
  Region region;
  if (shape.kind == ShapeKind::half_space) {
    region.low = Vec3::Constant(-infinite);
    region.high = Vec3::Constant(infinite);
    region.normal = end.turn.col(2);
    region.offset = region.normal.dot(end.position) + shape.margin + more;
    return region;
  }
  region.low = Vec3::Constant(infinite);
  region.high = Vec3::Constant(-infinite);
  grow(region, start, own);
  grow(region, end, own);
  const double cosine = 0.5 * ((start.turn.transpose() * end.turn).trace() - 1.0);
  const double off = 1.0 - std::sqrt(std::clamp(0.5 * (1.0 + cosine), 0.0, 1.0));
  const double around = more + off * own.low.cwiseAbs().cwiseMax(own.high.cwiseAbs()).norm();
  region.low.array() -= around;
  region.high.array() += around;
  return region;
}

ToolPose between(const ToolPose& from, const ToolPose& to, double share) {
  ToolPose pose = to;
  pose.position = from.position + share * (to.position - from.position);
  pose.orientation = from.orientation.slerp(share, to.orientation);
  return pose;
}

}  // namespace

ToolSet::Moving ToolSet::made(const SceneTool& tool, const Scene& scene) {
  Moving moving;
  moving.id = tool.id;
  moving.name = tool.name;
  const auto take = [&](const auto& shape) {
    using Shape = std::decay_t<decltype(shape)>;
    if constexpr (std::is_same_v<Shape, Needle>) {
      moving.needle.emplace(shape, tool.tool.friction, scene.model());
    } else {
      if constexpr (std::is_same_v<Shape, std::shared_ptr<const DistanceGrid>>) moving.grid = shape;
      const Extent extent = extent_of(shape);
      moving.shape = extent.shape;
      moving.reach = {.low = extent.low, .high = extent.high};
    }
  };
  std::visit(take, tool.tool.shape);
  moving.shape.margin = tool.tool.margin;
  moving.shape.thickness += tool.tool.margin;
  moving.reach.low.array() -= tool.tool.margin;
  moving.reach.high.array() += tool.tool.margin;
  moving.law = {.friction = tool.tool.friction, .compliance = tool.tool.compliance};
  moving.seen_grasps = 0;
  place(moving, tool.pose);
  moving.seen_moves = tool.moves;
  moving.seen_places = tool.places;
  return moving;
}

void ToolSet::follow(const Scene& scene) {
  std::vector<Moving> now;
  for (const SceneTool& tool : scene.tools()) {
    const auto known = std::ranges::find(tools_, tool.id, &Moving::id);
    now.push_back(known != tools_.end() ? std::move(*known) : made(tool, scene));
  }
  tools_ = std::move(now);
  found_.reserve(tools_.empty() ? 0 : scene.model().rest.size());
}

void ToolSet::place(Moving& tool, const ToolPose& pose) {
  tool.report.pose = tool.next_pose = tool.to = pose;
  tool.steps = tool.done = 0;
  tool.law.placed = true;
}

void ToolSet::reset(const Scene& scene, const State& state) {
  for (std::size_t row = 0; row < tools_.size(); ++row) {
    Moving& tool = tools_[row];
    const SceneTool& wanted = scene.tools()[row];
    const auto known = std::ranges::find(state.tools, tool.name, &ToolState::name);
    const bool restored = known != state.tools.end();
    place(tool, restored ? known->pose : wanted.pose);
    tool.held = restored ? known->held : std::vector<Index>{};
    tool.held_at = restored ? known->held_at : VecList{};
    tool.report.shaft.clear();
    if (tool.needle) {
      tool.needle->restore(restored ? known->needle : NeedleState{});
      tool.report.shaft = tool.needle->state().shaft;
    }
    tool.law.placed = !restored;
    tool.grasps = tool.releases = false;
    tool.seen_moves = wanted.moves;
    tool.seen_places = wanted.places;
    // A tool that was told to hold before the solver was there, or before it began anew, holds from the first step on.
    tool.seen_grasps = wanted.grasping && !restored ? wanted.grasps - 1 : wanted.grasps;
    tool.report.force = {};
  }
}

const ToolReport& ToolSet::report(const SceneTool& wanted) const {
  const auto known = std::ranges::find(tools_, wanted.id, &Moving::id);
  if (known != tools_.end()) return known->report;
  unseen_ = {};
  unseen_.pose = wanted.pose;
  return unseen_;
}

void ToolSet::read(State& state) const {
  state.tools.resize(tools_.size());
  for (std::size_t row = 0; row < tools_.size(); ++row) {
    const Moving& tool = tools_[row];
    ToolState& to = state.tools[row];
    to.name = tool.name;
    to.pose = tool.report.pose;
    to.held = tool.held;
    to.held_at = tool.held_at;
    to.needle = tool.needle ? tool.needle->state() : NeedleState{};
  }
}

void ToolSet::begin_call(const Scene& scene, int steps, bool at_once) {
  if (steps == 0) return;
  for (std::size_t row = 0; row < tools_.size(); ++row) {
    Moving& tool = tools_[row];
    const SceneTool& wanted = scene.tools()[row];
    tool.sum_force.setZero();
    tool.sum_torque.setZero();
    tool.summed = 0;
    if (tool.seen_places != wanted.places) {
      tool.seen_places = wanted.places;
      tool.seen_moves = wanted.moves;
      place(tool, wanted.pose);
    } else if (tool.seen_moves != wanted.moves || tool.done < tool.steps) {
      tool.seen_moves = wanted.moves;
      tool.from = tool.report.pose;
      tool.to = wanted.pose;
      tool.steps = at_once ? 1 : steps;
      tool.done = 0;
    }
    if (tool.seen_grasps == wanted.grasps) continue;
    tool.seen_grasps = wanted.grasps;
    tool.grasps = wanted.grasping;
    tool.releases = !wanted.grasping;
    tool.grasp_distance = wanted.grasp_distance;
  }
}

void ToolSet::advance(Moving& tool, double dt) {
  tool.next_force = {};
  if (tool.done < tool.steps) {
    const int next = tool.done + 1;
    tool.next_pose = next == tool.steps ? tool.to : between(tool.from, tool.to, static_cast<double>(next) / tool.steps);
    return;
  }
  tool.next_pose = tool.report.pose;
  tool.next_pose.position += dt * tool.report.pose.velocity;
  const double angle = dt * tool.report.pose.spin.norm();
  if (!(angle > 0.0)) return;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, tool.report.pose.spin.normalized()));
  tool.next_pose.orientation = Quaternion(turn * Eigen::Quaterniond(tool.report.pose.orientation)).normalized();
}

bool ToolSet::held_by_any(Index particle) const {
  return std::ranges::any_of(tools_, [&](const Moving& tool) { return std::ranges::count(tool.held, particle) > 0; });
}

void ToolSet::take_hold(Moving& tool, TouchedParticles& touched) {
  const ToolFrame start(tool.report.pose);
  found_.clear();
  touched.step().find(reach_between(tool.shape, tool.reach, start, start, tool.grasp_distance), found_);
  std::ranges::sort(found_);
  for (const Index i : found_) {
    const TouchedParticles::Touched& particle = touched[touched.slot(i)];
    const Vec3 q = start.inside(particle.position);
    if (particle.fixed == 7 || distance_to(tool.shape, unpacked(q)).phi > tool.grasp_distance) continue;
    if (held_by_any(i)) continue;
    tool.held.push_back(i);
    tool.held_at.push_back(q);
  }
}

/// The impulse that takes each held particle to its place in the frame of the step's end.
void ToolSet::hold(Moving& tool, TouchedParticles& touched) {
  const ToolFrame end(tool.next_pose);
  const double dt = touched.dt();
  for (std::size_t k = 0; k < tool.held.size(); ++k) {
    TouchedParticles::Touched& particle = touched[touched.slot(tool.held[k])];
    const Vec3 velocity = (end.outside(tool.held_at[k]) - particle.position) / dt;
    const Vec3 given = TouchedParticles::push(particle, (velocity - particle.velocity) / particle.inverse_mass);
    particle.held = true;
    react(tool.next_force, end, particle.position, given, dt);
  }
}

void ToolSet::press(Moving& tool, TouchedParticles& touched) {
  const ToolFrame start(tool.report.pose), end(tool.next_pose);
  const double dt = touched.dt();
  found_.clear();
  touched.step().find(reach_between(tool.shape, tool.reach, start, end, 0.0), found_);
  for (const Index i : found_) {
    TouchedParticles::Touched& particle = touched[touched.slot(i)];
    if (particle.held || particle.fixed == 7) continue;
    const Vec3 q0 = start.inside(particle.position), q1 = end.inside(particle.end(dt));
    const Touch<double> touch =
        touch_in_step(tool.shape, tool.law, unpacked(q0), unpacked(q1), particle.inverse_mass, dt);
    if (!touch.touches) continue;
    const Vec3 given = TouchedParticles::push(particle, end.turn * packed(touch.impulse));
    const Vec3 shift = end.turn * packed(touch.shift);
    for (int a = 0; a < 3; ++a) particle.shift[a] += (particle.fixed >> a & 1) != 0 ? 0.0 : shift[a];
    react(tool.next_force, end, particle.position, given, dt);
  }
}

void ToolSet::act(TouchedParticles& touched) {
  for (Moving& tool : tools_) {
    advance(tool, touched.dt());
    if (tool.releases) {
      tool.held.clear();
      tool.held_at.clear();
      tool.releases = false;
    }
  }
  for (Moving& tool : tools_) {
    if (tool.grasps) take_hold(tool, touched);
    tool.grasps = false;
    hold(tool, touched);
  }
  for (Moving& tool : tools_) {
    if (tool.needle) tool.needle->act(touched, tool.report.pose, tool.next_pose, tool.next_force);
  }
  for (Moving& tool : tools_) {
    if (!tool.needle) press(tool, touched);
  }
}

void ToolSet::accept() {
  for (Moving& tool : tools_) {
    if (tool.needle) {
      tool.needle->accept();
      tool.report.shaft = tool.needle->state().shaft;
    }
    tool.report.pose = tool.next_pose;
    tool.law.placed = false;
    if (tool.done < tool.steps && ++tool.done == tool.steps) tool.steps = tool.done = 0;
    tool.report.force.force = tool.next_force.force;
    tool.report.force.torque = tool.next_force.torque;
    tool.report.force.particles = tool.next_force.particles;
    tool.sum_force += tool.next_force.force;
    tool.sum_torque += tool.next_force.torque;
    ++tool.summed;
    tool.report.force.mean_force = tool.sum_force / tool.summed;
    tool.report.force.mean_torque = tool.sum_torque / tool.summed;
  }
}

}  // namespace phymul::cpu
