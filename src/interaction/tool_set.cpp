// SPDX-License-Identifier: MIT
#include "tool_set.h"

#include <algorithm>
#include <cmath>

#include "tool_shape.h"

namespace phymul {
namespace {

/// The world's box around one in the tool's frame.
void grow(Region& region, const ToolFrame& frame, const Region& own) {
  const Vec3 centre = frame.outside(0.5 * (own.low + own.high));
  const Vec3 half = frame.turn.cwiseAbs() * (0.5 * (own.high - own.low));
  region.low = region.low.cwiseMin(centre - half);
  region.high = region.high.cwiseMax(centre + half);
}

/// Where a shape may meet a particle on the way between two poses. Corners go along arcs: a turn by an angle takes them
/// off their chords by at most their distance times 1 - cos of half of it.
Region swept_bounds(const ShapeIn<double>& shape, const Region& own, const ToolFrame& start, const ToolFrame& end,
                    double more) {
  Region region;
  if (shape.kind == ShapeKind::half_space) {
    region.low = Vec3::Constant(-HUGE_VAL);
    region.high = Vec3::Constant(HUGE_VAL);
    region.normal = end.turn.col(2);
    region.offset = region.normal.dot(end.position) + shape.margin + more;
    return region;
  }
  region.low = Vec3::Constant(HUGE_VAL);
  region.high = Vec3::Constant(-HUGE_VAL);
  grow(region, start, own);
  grow(region, end, own);
  const double cosine = 0.5 * ((start.turn.transpose() * end.turn).trace() - 1.0);
  const double off = 1.0 - std::sqrt(std::clamp(0.5 * (1.0 + cosine), 0.0, 1.0));
  const double around = more + off * own.low.cwiseAbs().cwiseMax(own.high.cwiseAbs()).norm();
  region.low.array() -= around;
  region.high.array() += around;
  return region;
}

/// Tool::suction. `found`: room.
void suck(const Tool& tool, const ShapeIn<double>& shape, const Region& bounds, const ToolFrame& frame,
          TouchedParticles& touched, std::vector<Index>& found, ToolForce& force) {
  found.clear();
  touched.step().find(swept_bounds(shape, bounds, frame, frame, tool.suction_reach), found);
  std::ranges::sort(found);
  const auto mass_within = [&](const Distance<double>& at, Index i) {
    return at.phi < tool.suction_reach ? touched.mass()[i] : 0.0;
  };
  const auto distance = [&](Index i) {
    return distance_to(shape, unpacked(frame.inside(touched[touched.slot(i)].position)));
  };
  double mass = 0.0;  // kg
  for (const Index i : found) mass += mass_within(distance(i), i);
  const int pressed = force.particles;
  for (const Index i : found) {
    const Distance<double> at = distance(i);
    const double own = mass_within(at, i) * (1.0 - std::max(at.phi, 0.0) / tool.suction_reach);
    TouchedParticles::Touched& particle = touched[touched.slot(i)];
    if (!(own > 0.0) || particle.held) continue;
    const Vec3 impulse = -touched.dt() * tool.suction * own / mass * (frame.turn * packed(at.normal));
    react(force, frame, particle.position, TouchedParticles::push(particle, impulse), touched.dt());
  }
  force.particles = pressed;
}

}  // namespace

ToolSet::Moving ToolSet::made(const SceneTool& tool, const Scene& scene) {
  const ToolExtent extent = extent_of(tool.tool);
  Moving moving{.moved = MovedTool(tool),
                .shape = shape_of(tool.tool),
                .tool = tool.tool,
                .law = {.friction = tool.tool.friction, .compliance = tool.tool.compliance},
                .bounds = {.low = extent.low, .high = extent.high}};
  const auto* needle = std::get_if<Needle>(&tool.tool.shape);
  if (needle) moving.needle.emplace(*needle, tool.tool.friction, scene.model());
  const auto* blade = std::get_if<Blade>(&tool.tool.shape);
  if (blade) moving.blade.emplace(*blade, scene.model());
  if (tool.tool.contact == ToolContact::surface) moving.surface.emplace(*surface_.of(scene), scene.model(), tool.tool);
  return moving;
}

void ToolSet::follow(const Scene& scene) {
  const auto known = [&](const SceneTool& tool) {
    return std::ranges::find(tools_, tool.id, [](const Moving& moving) { return moving.moved.id; });
  };
  // First all that needs memory: where there is none, the tools that are known stay what they are.
  found_.reserve(scene.tools().empty() ? 0 : scene.model().rest.size());
  std::vector<Moving> now, added;
  now.reserve(scene.tools().size());
  for (const SceneTool& tool : scene.tools()) {
    if (known(tool) == tools_.end()) added.push_back(made(tool, scene));
  }
  auto next = added.begin();
  for (const SceneTool& tool : scene.tools()) {
    const auto own = known(tool);
    now.push_back(std::move(own != tools_.end() ? *own : *next++));
  }
  tools_ = std::move(now);
  for (Moving& tool : tools_) tool.pull = {};
  threads_.follow(scene, surface_);
  if (body_version_ != scene.body_version()) follow_body(scene);
}

void ToolSet::follow_body(const Scene& scene) {
  for (Moving& tool : tools_) {
    tool.moved.let_go_of_removed(scene.model().mass);
    if (tool.needle) tool.needle->follow_body(scene.model());
    if (tool.blade) tool.blade->follow_body();
    const auto own = std::ranges::find(scene.tools(), tool.moved.id, &SceneTool::id);
    if (tool.surface) tool.surface.emplace(*surface_.of(scene), scene.model(), own->tool);
  }
  body_version_ = scene.body_version();
}

void ToolSet::reset(const Scene& scene, const State& state) {
  for (std::size_t row = 0; row < tools_.size(); ++row) {
    Moving& tool = tools_[row];
    const ToolState* const known = tool.moved.reset(scene.tools()[row], state, scene.model().mass, !was_reset_);
    tool.is_taken = false;
    if (tool.surface) tool.surface->forget();
    if (tool.blade) tool.blade->restore(known ? known->blade : std::vector<BladePoint>{});
    if (tool.needle) {
      tool.needle->restore(known ? known->needle : NeedleState{});
      tool.moved.report.shaft = tool.needle->state().shaft;
    }
  }
  threads_.reset(scene, state);
  was_reset_ = true;
}

const MovedTool* ToolSet::find(std::uint64_t id) const {
  const auto known = std::ranges::find(tools_, id, [](const Moving& moving) { return moving.moved.id; });
  return known == tools_.end() ? nullptr : &known->moved;
}

const ToolReport& ToolSet::report(const SceneTool& wanted) const {
  if (const MovedTool* const known = find(wanted.id)) return known->report;
  unseen_ = {};
  unseen_.pose = unseen_.last_pose = first_pose(wanted);
  return unseen_;
}

void ToolSet::read(const Scene& scene, State& state) const {
  state.tools.resize(tools_.size());
  std::size_t count = 0;
  for (const Moving& tool : tools_) {
    if (!tool.moved.is_in(scene)) continue;
    ToolState& own = state.tools[count++];
    tool.moved.read(own);
    if (tool.needle) own.needle = tool.needle->state();
    if (tool.blade) own.blade = tool.blade->state();
  }
  state.tools.resize(count);
  threads_.read(scene, state);
}

void ToolSet::begin_call(const Scene& scene, int steps, bool at_once) {
  if (steps == 0) return;
  at_once_ = at_once;
  for (std::size_t row = 0; row < tools_.size(); ++row) {
    const bool moves = tools_[row].moved.begin_call(scene.tools()[row], steps, at_once);
    tools_[row].is_taken = tools_[row].is_taken || moves;
    if (tools_[row].blade) tools_[row].blade->begin_call();
    if (tools_[row].needle) tools_[row].needle->follow_stiffness(scene.model(), scene.stiffness_factors());
  }
  threads_.begin_call(scene, steps, at_once);
}

bool ToolSet::held_by_any(Index particle) const {
  return std::ranges::any_of(tools_, [&](const Moving& tool) {
    return !tool.moved.releases && std::ranges::count(tool.moved.held, particle) > 0;
  });
}

void ToolSet::take_hold(Moving& tool, TouchedParticles& touched) {
  const ToolFrame start(tool.moved.motion.pose);
  found_.clear();
  touched.step().find(swept_bounds(tool.shape, tool.bounds, start, start, tool.moved.grasp_distance), found_);
  std::ranges::sort(found_);
  for (const Index i : found_) {
    const TouchedParticles::Touched& particle = touched[touched.slot(i)];
    const Vec3 q = start.inside(particle.position);
    if (particle.fixed == 7 || distance_to(tool.shape, unpacked(q)).phi > tool.moved.grasp_distance) continue;
    if (held_by_any(i)) continue;
    tool.moved.take_hold(i, q);
  }
  tool.moved.weigh_held(touched.mass());
}

/// The impulse that takes each held particle to its place in the frame of the step's end. In a remainder from its place
/// at the start.
void ToolSet::hold(Moving& tool, TouchedParticles& touched) {
  const ToolFrame start(tool.moved.motion.pose), end(tool.moved.motion.next_pose);
  const double dt = touched.dt();
  for (std::size_t k = 0; k < tool.moved.held.size(); ++k) {
    TouchedParticles::Touched& particle = touched[touched.slot(tool.moved.held[k])];
    const Vec3 from = touched.is_remainder() ? start.outside(tool.moved.held_at[k]) : particle.position;
    particle.shift += particle.free_part(from - particle.position);
    const Vec3 velocity = (end.outside(tool.moved.held_at[k]) - from) / dt;
    const Vec3 given = TouchedParticles::push(particle, (velocity - particle.velocity) / particle.inverse_mass);
    particle.held = true;
    react(tool.next_force, end, particle.position, given - dt * particle.free_part(particle.withheld), dt);
    particle.withheld = Vec3::Zero();
  }
}

void ToolSet::press(Moving& tool, TouchedParticles& touched) {
  const ToolFrame start(tool.moved.motion.pose), end(tool.moved.motion.next_pose);
  const double dt = touched.dt();
  if (tool.surface) tool.surface->act(tool.shape, tool.law, start, end, touched, tool.next_force);
  found_.clear();
  const Region swept = swept_bounds(tool.shape, tool.bounds, start, end, 0.0);
  touched.step().find(swept, found_);
  // And what the impulses so far drive there, which would not go there by itself.
  for (std::size_t slot = 0; slot < touched.count(); ++slot) {
    const TouchedParticles::Touched& driven = touched[slot];
    const Vec3 alone = driven.velocity - driven.inverse_mass * driven.impulse;
    if (swept.meets(driven.position, driven.position + dt * alone)) continue;
    if (!swept.meets(driven.position, driven.end(dt)) || std::ranges::count(found_, driven.particle) > 0) continue;
    found_.push_back(driven.particle);
  }
  for (const Index i : found_) {
    if (tool.surface && tool.surface->has(i)) continue;
    TouchedParticles::Touched& particle = touched[touched.slot(i)];
    if (particle.held || particle.fixed == 7) continue;
    const Vec3 q0 = start.inside(particle.position), q1 = end.inside(particle.end(dt));
    if (tool.surface && is_deep_in(tool.shape, unpacked(q0))) continue;
    const Touch<double> touch =
        touch_in_step(tool.shape, tool.law, unpacked(q0), unpacked(q1), unpacked(q1 - q0), particle.inverse_mass, dt);
    if (!touch.touches) continue;
    const Vec3 given = TouchedParticles::push(particle, end.turn * packed(touch.impulse));
    particle.shift += particle.free_part(end.turn * packed(touch.shift));
    react(tool.next_force, end, particle.position, given + dt * TouchedParticles::borne(particle, given), dt);
  }
}

void ToolSet::ways(double dt, std::vector<ToolWay>& ways) const {
  ways.clear();
  for (const Moving& tool : tools_) {
    ToolMotion motion = tool.moved.motion;
    motion.advance(dt);
    // A tool that is where it has to be in one step passed nothing on its way, and dampers feel no speed.
    ways.push_back({at_once_ ? motion.next_pose : motion.pose, motion.next_pose, tool.is_let_go()});
  }
}

bool ToolSet::may_touch(int steps, double dt, double wide, const std::function<bool(const Region&)>& any_in) const {
  if (!threads_.empty()) return true;
  for (const Moving& tool : tools_) {
    const MovedTool& moved = tool.moved;
    if (!moved.held.empty() || moved.grasps || moved.releases) return true;
    if (tool.needle && !tool.needle->state().hole.empty()) return true;
    if (tool.blade && tool.blade->holds()) return true;
    if (tool.shape.kind == ShapeKind::half_space) return true;  // a floor is always under something
    Region all{.low = Vec3::Constant(HUGE_VAL), .high = Vec3::Constant(-HUGE_VAL)};
    ToolMotion motion = moved.motion;
    for (int step = 0; step < steps; ++step) {
      motion.advance(dt);
      if (!is_finite(motion.next_pose)) return true;  // such a step is looked at by itself
      const Region region = swept_bounds(tool.shape, tool.bounds, ToolFrame(motion.pose), ToolFrame(motion.next_pose),
                                         tool.blade                    ? tool.blade->reach()
                                         : tool.needle || tool.surface ? std::max(wide, tool.tool.suction_reach)
                                                                       : tool.tool.suction_reach);
      all.low = all.low.cwiseMin(region.low);
      all.high = all.high.cwiseMax(region.high);
      motion.accept();
    }
    if (any_in(all)) return true;
  }
  return false;
}

void ToolSet::pass(int steps, double dt, std::span<const JointSet::Pull> pulls, std::span<const JointSet::Pull> sums) {
  for (std::size_t row = 0; row < tools_.size(); ++row) {
    MovedTool& moved = tools_[row].moved;
    if (steps > 0 && std::exchange(tools_[row].is_taken, false)) tools_[row].needle->set_free(false);
    for (int step = 0; step < steps; ++step) {
      moved.motion.advance(dt);
      moved.accept_pose();
    }
    const auto of = [row](std::span<const JointSet::Pull> all) { return all.empty() ? JointSet::Pull{} : all[row]; };
    moved.tell({.force = of(pulls).force, .torque = of(pulls).torque}, of(sums).force, of(sums).torque, steps);
  }
}

void ToolSet::pull(std::span<const JointSet::Pull> pulls) {
  for (std::size_t row = 0; row < tools_.size(); ++row) tools_[row].pull = pulls[row];
}

void ToolSet::act(TouchedParticles& touched) {
  for (Moving& tool : tools_) {
    tool.next_force = {};
    tool.moved.motion.advance(touched.dt());
    tool.law.placed = tool.moved.motion.placed || touched.is_remainder() ||
                      (tool.surface && tool.law.compliance == 0.0 && lets_surface_out(touched.dt(), touched.last_dt()));
    if (tool.moved.grasps || tool.moved.releases) tool.before = tool.moved;
    if (tool.needle) tool.needle->remember();
    if (tool.needle && tool.is_taken) tool.needle->set_free(false);
    if (tool.needle && tool.moved.releases) tool.needle->set_free(true);
    if (tool.moved.releases) tool.moved.release();
  }
  for (Moving& tool : tools_) {
    if (tool.moved.grasps) take_hold(tool, touched);
    tool.moved.grasps = false;
    hold(tool, touched);
  }
  for (Moving& tool : tools_) {
    ToolMotion& motion = tool.moved.motion;
    if (tool.needle) {
      tool.needle->act(touched, motion.pose, motion.placed, motion.next_pose, tool.next_force);
      if (!threads_.empty()) threads_.follow_needle(tool.moved.name, tool.needle->passed(), motion.pose);
    }
    if (tool.blade) tool.blade->act(touched, motion.pose, motion.next_pose, tool.next_force);
  }
  for (Moving& tool : tools_) {
    if (tool.tool.suction == 0.0) continue;
    const ToolFrame end(tool.moved.motion.next_pose);
    suck(tool.tool, tool.shape, tool.bounds, end, touched, found_, tool.next_force);
  }
  for (Moving& tool : tools_) {
    if (!tool.needle && !tool.blade) press(tool, touched);
  }
  if (!threads_.empty()) act_by_threads(touched);
}

void ToolSet::act_by_threads(TouchedParticles& touched) {
  std::vector<ThreadSupport> supports;
  for (Moving& tool : tools_) {
    if (tool.needle || tool.blade || !threads_.any_touches()) continue;
    const ToolMotion& motion = tool.moved.motion;
    supports.push_back(
        {tool.moved.name, &tool.shape, ToolFrame(motion.pose), ToolFrame(motion.next_pose), &tool.next_force});
  }
  const auto find_tool = [this](std::string_view name) {
    Moving& tool =
        *std::ranges::find(tools_, name, [](const Moving& moving) { return std::string_view(moving.moved.name); });
    return ThreadSet::AtTool{&tool.moved.motion.pose, &tool.moved.motion.next_pose, &tool.next_force,
                             tool.needle && tool.needle->state().free};
  };
  threads_.act(touched, find_tool, supports);
}

void ToolSet::feel(TouchedParticles& touched) {
  for (Moving& tool : tools_) {
    const ToolFrame end(tool.moved.motion.next_pose);
    const int particles = tool.next_force.particles;
    for (const Index i : tool.moved.held) {
      const TouchedParticles::Touched& particle = touched[touched.slot(i)];
      react(tool.next_force, end, particle.position, -particle.handed_on, touched.dt());
    }
    tool.next_force.particles = particles;
  }
}

const char* ToolSet::first_not_finite() const {
  const auto is_fine = [](const Moving& tool) {
    return is_finite(tool.moved.motion.next_pose) && (tool.next_force.force + tool.pull.force).allFinite() &&
           (tool.next_force.torque + tool.pull.torque).allFinite();
  };
  if (!std::ranges::all_of(tools_, is_fine)) return pose_not_finite;
  return threads_.is_finite() ? "" : "a thread would not be finite: what pulls or moves it is extreme";
}

void ToolSet::drop() {
  threads_.drop();
  for (Moving& tool : tools_) {
    if (tool.needle) tool.needle->drop();
    if (tool.before) tool.moved = *tool.before;
    tool.before.reset();
  }
}

void ToolSet::accept() {
  threads_.accept();
  for (Moving& tool : tools_) {
    tool.before.reset();
    tool.is_taken = false;
    if (tool.needle) {
      tool.needle->accept();
      tool.moved.report.shaft = tool.needle->state().shaft;
      tool.moved.report.tissue_gave_way = tool.needle->gave_way();
    }
    if (tool.blade) tool.blade->accept();
    tool.moved.accept_pose();
    tool.next_force.force += tool.pull.force;
    tool.next_force.torque += tool.pull.torque;
    tool.moved.tell(tool.next_force, tool.next_force.force, tool.next_force.torque, 1);
  }
}

}  // namespace phymul
