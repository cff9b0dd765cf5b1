// SPDX-License-Identifier: MIT
#include "joint_set.h"

#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace phymul {
JointSet::End JointSet::end_of(const Anchor& anchor, const std::vector<SceneTool>& tools) const {
  End end;
  end.place = anchor.point;
  end.weights = anchor.weights;
  for (const Index i : anchor.particles) {
    const auto row = std::ranges::lower_bound(points_, i, {}, &Point::particle);
    end.points.push_back(static_cast<Index>(row - points_.begin()));
  }
  if (anchor.tool.empty()) return end;
  end.tool = static_cast<Index>(std::ranges::find(tools, anchor.tool, &SceneTool::name) - tools.begin());
  return end;
}

void JointSet::break_removed(Followed& followed, const Joint& joint) const {
  for (std::size_t row = 0; row < followed.springs.size(); ++row) {
    bool& broken = followed.report.springs[row].broken;
    if (broken || !ends_at_removed(joint.springs[row], scene_->model().mass)) continue;
    broken = true;
    ++followed.report.broken;
  }
}

void JointSet::follow(const Scene& scene) {
  scene_ = &scene;
  std::vector<Index> particles;
  for (const SceneJoint& joint : scene.joints()) {
    for (const JointSpring& spring : joint.joint.springs) {
      particles.insert(particles.end(), spring.a.particles.begin(), spring.a.particles.end());
      particles.insert(particles.end(), spring.b.particles.begin(), spring.b.particles.end());
    }
  }
  std::ranges::sort(particles);
  particles.erase(std::ranges::unique(particles).begin(), particles.end());
  points_.assign(particles.size(), {});
  for (std::size_t row = 0; row < particles.size(); ++row) points_[row].particle = particles[row];
  pulls_.assign(scene.tools().size(), {});

  std::vector<Followed> now;
  for (const SceneJoint& joint : scene.joints()) {
    Followed followed{.id = joint.id,
                      .name = joint.name,
                      .springs = {},
                      .next = {},
                      .reach = {},
                      .arm = {},
                      .loose = {},
                      .report = {}};
    for (const JointSpring& spring : joint.joint.springs) {
      followed.springs.push_back({end_of(spring.a, scene.tools()), end_of(spring.b, scene.tools())});
    }
    const auto known = std::ranges::find(joints_, joint.id, &Followed::id);
    if (known != joints_.end()) followed.report = known->report;  // a copy: what follows may need memory and fail
    followed.report.springs.resize(followed.springs.size());
    break_removed(followed, joint.joint);
    followed.next = followed.report.springs;
    followed.reach.resize(followed.springs.size());
    followed.arm.assign(followed.springs.size(), Vec3::Zero());
    followed.loose.assign(followed.springs.size(), 0);
    now.push_back(std::move(followed));
  }
  joints_ = std::move(now);
  if (solved_) left_out_ = solved_(scene);
}

void JointSet::reset(const State& state) {
  for (Followed& followed : joints_) {
    followed.report.springs.assign(followed.springs.size(), {});
    followed.report = {.springs = std::move(followed.report.springs)};
    const auto known = std::ranges::find(state.joints, followed.name, &JointState::name);
    if (known != state.joints.end()) {
      for (const Index row : known->broken) {
        if (row < 0 || row >= static_cast<Index>(followed.springs.size())) continue;
        followed.report.springs[row].broken = true;
        ++followed.report.broken;
      }
    }
    const auto own = std::ranges::find(scene_->joints(), followed.id, &SceneJoint::id);
    if (own != scene_->joints().end()) break_removed(followed, own->joint);
  }
}

void JointSet::read(State& state) const {
  state.joints.clear();
  for (const Followed& followed : joints_) {
    // The scene may have another joint of that name by now.
    if (followed.report.broken == 0 || !std::ranges::count(scene_->joints(), followed.id, &SceneJoint::id)) continue;
    JointState& own = state.joints.emplace_back();
    own.name = followed.name;
    for (std::size_t row = 0; row < followed.springs.size(); ++row) {
      if (followed.report.springs[row].broken) own.broken.push_back(static_cast<Index>(row));
    }
  }
}

JointSet::Motion JointSet::motion_of(const End& end, std::span<const ToolWay> tools, double dt) const {
  if (end.tool >= 0) {
    const ToolWay& way = tools[end.tool];
    const Vec3 from = way.pose.position + way.pose.orientation * end.place;
    const Vec3 to = way.next_pose.position + way.next_pose.orientation * end.place;
    return {from, (to - from) / dt};
  }
  if (end.points.empty()) return {end.place, Vec3::Zero()};
  Motion motion{Vec3::Zero(), Vec3::Zero()};
  for (std::size_t k = 0; k < end.points.size(); ++k) {
    motion.position += end.weights[k] * points_[end.points[k]].position;
    motion.velocity += end.weights[k] * points_[end.points[k]].velocity;
  }
  return motion;
}

void JointSet::give(const End& end, const Vec3& force) {
  for (std::size_t k = 0; k < end.points.size(); ++k) points_[end.points[k]].force += end.weights[k] * force;
}

void JointSet::give_tool(const Ends& ends, const Vec3& force, const Vec3& arm) {
  const Index tool = std::max(ends.a.tool, ends.b.tool);  // one of them has particles
  if (tool < 0) return;
  const Vec3 own = ends.a.tool >= 0 ? force : Vec3(-force);
  pulls_[tool].force += own;
  pulls_[tool].torque += arm.cross(own);
}

void JointSet::act(std::size_t joint_row, std::span<const ToolWay> tools, double dt) {
  Followed& followed = joints_[joint_row];
  const Joint& joint = scene_->joints()[joint_row].joint;
  const bool left_out = is_left_out(joint_row);
  for (std::size_t row = 0; row < followed.springs.size(); ++row) {
    const Ends& ends = followed.springs[row];
    const auto& [a, b] = ends;
    SpringReport& next = followed.next[row];
    const Motion at_a = motion_of(a, tools, dt), at_b = motion_of(b, tools, dt);
    Vec3 r = at_b.position - at_a.position, v = at_b.velocity - at_a.velocity;
    if (scene_->model().dimension == 2) r.z() = v.z() = 0.0;  // tools move in space
    followed.reach[row] = r;
    if (a.tool >= 0) followed.arm[row] = at_a.position - tools[a.tool].next_pose.position;
    if (b.tool >= 0) followed.arm[row] = at_b.position - tools[b.tool].next_pose.position;
    next = {.length = r.norm(), .broken = followed.report.springs[row].broken};
    const auto is_free = [&](const End& end) { return end.tool >= 0 && tools[end.tool].is_free; };
    followed.loose[row] = is_free(a) || is_free(b) ? 1 : 0;
    if (next.broken || followed.loose[row] != 0) continue;
    const JointSpring& spring = joint.springs[row];
    next.force = spring_force(joint, spring, r, v);
    energy_ += spring_energy(joint, spring, next.length);
    if (left_out) continue;
    next.broken = next.force.norm() > spring.share * joint.breaking_force;
    give(a, next.force);
    give(b, -next.force);
    give_tool(ends, next.force, followed.arm[row]);
  }
}

void JointSet::set_force(std::size_t joint, std::size_t spring, const Vec3& force) {
  Followed& followed = joints_[joint];
  SpringReport& next = followed.next[spring];
  if (next.broken) return;
  const Joint& own = scene_->joints()[joint].joint;
  next.force = force;
  next.broken = force.norm() > own.springs[spring].share * own.breaking_force;
  give_tool(followed.springs[spring], force, followed.arm[spring]);
}

bool JointSet::is_finite() const {
  return std::ranges::all_of(joints_, [](const Followed& followed) {
    return std::ranges::all_of(followed.next, [](const SpringReport& spring) {
      return spring.force.allFinite() && std::isfinite(spring.length);
    });
  });
}

void JointSet::act(std::span<const ToolWay> tools, double dt) {
  for (Point& point : points_) point.force.setZero();
  for (Pull& pull : pulls_) pull = {};
  energy_ = 0.0;
  for (std::size_t row = 0; row < joints_.size(); ++row) act(row, tools, dt);
}

void JointSet::take(std::span<const Told> told, std::span<Pull> sums) {
  for (Pull& pull : pulls_) pull = {};
  auto row = told.begin();
  for (Followed& followed : joints_) {
    for (std::size_t k = 0; k < followed.springs.size(); ++k, ++row) {
      followed.next[k] = row->spring;
      const auto& [a, b] = followed.springs[k];
      const Index tool = std::max(a.tool, b.tool);
      if (tool < 0) continue;
      const double side = a.tool >= 0 ? 1.0 : -1.0;
      pulls_[tool].force += side * row->spring.force;
      pulls_[tool].torque += row->torque;
      sums[tool].force += side * row->sum_force;
      sums[tool].torque += row->sum_torque;
    }
  }
}

void JointSet::accept() {
  for (Followed& followed : joints_) {
    JointReport& report = followed.report;
    report.springs = followed.next;  // of equal sizes: nothing is allocated
    report.force.setZero();
    report.largest = 0.0;
    report.broken = 0;
    for (const SpringReport& spring : report.springs) {
      report.force += spring.force;
      report.largest = std::max(report.largest, spring.force.norm());
      report.broken += spring.broken ? 1 : 0;
    }
  }
}

int JointSet::broken() const {
  int sum = 0;
  for (const Followed& followed : joints_) sum += followed.report.broken;
  return sum;
}

const JointReport& JointSet::report(const SceneJoint& wanted) const {
  const auto known = std::ranges::find(joints_, wanted.id, &Followed::id);
  if (known != joints_.end()) return known->report;
  unseen_ = {};
  unseen_.springs.resize(wanted.joint.springs.size());
  return unseen_;
}

void require_joint_states(const State& state, const std::vector<SceneJoint>& joints) {
  for (const JointState& own : state.joints) {
    const auto known = std::ranges::find(joints, own.name, &SceneJoint::name);
    if (known == joints.end()) continue;
    const auto count = static_cast<Index>(known->joint.springs.size());
    Index last = -1;
    for (const Index row : own.broken) {
      if (row > last && row < count) {
        last = row;
        continue;
      }
      throw Error("Solver::reset: the state of joint \"" + own.name + "\" has the broken spring " +
                  std::to_string(row) + "; expected increasing rows of the " + std::to_string(count) +
                  " springs of the scene's joint of that name. Give the scene the joint that the state was taken with");
    }
  }
}

JointSet joints_of(const Scene& scene, const State& state) {
  JointSet joints;
  joints.follow(scene);
  joints.reset(state);
  std::vector<ToolWay> tools;
  for (const SceneTool& tool : scene.tools()) {
    const auto known = std::ranges::find(state.tools, tool.name, &ToolState::name);
    const ToolPose& pose = known != state.tools.end() ? known->pose : tool.pose;
    tools.push_back({pose, pose, known != state.tools.end() && known->needle.free});
  }
  for (JointSet::Point& point : joints.points()) {
    point.position = state.position[point.particle];
    point.velocity = state.velocity[point.particle];
  }
  joints.act(tools, 1.0);
  return joints;
}

double add_joint_forces(const Scene& scene, const State& state, std::span<Vec3> force) {
  if (scene.joints().empty()) return 0.0;
  JointSet joints = joints_of(scene, state);
  for (const JointSet::Point& point : joints.points()) force[point.particle] += point.force;
  return joints.energy();
}

/// Rows of the particles that springs have.
void JointSet::number_rows(const Scene& scene, std::size_t particles) {
  row_of_.assign(particles, -1);
  Index rows = 0;
  for (const SceneJoint& joint : scene.joints()) {
    for (const JointSpring& spring : joint.joint.springs) {
      for (const Anchor* end : {&spring.a, &spring.b}) {
        for (const Index i : end->particles) {
          if (row_of_[i] < 0) row_of_[i] = rows++;
        }
      }
    }
  }
  row_.resize(static_cast<std::size_t>(rows));
  trial_.resize(static_cast<std::size_t>(rows));
}

template <class Constant>
double JointSet::largest_of(const Scene& scene, std::span<const double> mass, const Constant& constant) {
  constexpr int turns = 6;
  const auto has = [&](const SceneJoint& it) { return constant(it) > 0.0; };
  if (std::ranges::none_of(scene.joints(), has)) return 0.0;
  double bound = std::numeric_limits<double>::infinity();
  std::ranges::fill(trial_, 1.0);
  for (int turn = 0; turn < turns; ++turn) {
    std::ranges::fill(row_, 0.0);
    for (const SceneJoint& it : scene.joints()) {
      for (const JointSpring& spring : it.joint.springs) add_row(spring, constant(it), mass);
    }
    double largest = 0.0;
    for (std::size_t i = 0; i < row_.size(); ++i) {
      if (row_[i] > 0.0) largest = std::max(largest, row_[i] / trial_[i]);
    }
    if (turn == 0 || largest > 0.0) bound = std::min(bound, largest);  // 0 later: underflow
    if (!(largest > 0.0 && std::isfinite(largest))) break;
    for (std::size_t i = 0; i < row_.size(); ++i) trial_[i] = row_[i] / bound;
  }
  return bound;
}

/// Adds |M^-1 K| trial of a spring to row_.
void JointSet::add_row(const JointSpring& spring, double constant, std::span<const double> mass) {
  if (ends_at_removed(spring, mass)) return;
  double sum = 0.0;
  for (const Anchor* end : {&spring.a, &spring.b}) {
    for (std::size_t k = 0; k < end->particles.size(); ++k) {
      sum += std::abs(end->weights[k]) * trial_[row_of_[end->particles[k]]];
    }
  }
  for (const Anchor* end : {&spring.a, &spring.b}) {
    for (std::size_t k = 0; k < end->particles.size(); ++k) {
      const Index i = end->particles[k];
      row_[row_of_[i]] += constant * spring.share * std::abs(end->weights[k]) * sum / mass[i];
    }
  }
}

const JointBounds& JointSet::bounds(const Scene& scene, std::span<const double> mass) {
  const bool same_springs = bounds_version_ == scene.version();
  if (same_springs && bounds_values_version_ == scene.values_version()) return bounds_;
  bounds_ = {};
  if (!scene.joints().empty()) {
    if (!same_springs || row_of_.empty()) {
      number_rows(scene, mass.size());
      if (solved_) left_out_ = solved_(scene);
    }
    const auto bound = [&](double Joint::*constant, bool of_left) {
      return largest_of(scene, mass, [&](const SceneJoint& it) {
        return of_left && left_out_[&it - scene.joints().data()] ? 0.0 : it.joint.*constant;
      });
    };
    bounds_.stiffness = bound(&Joint::stiffness, false);
    bounds_.damping = bound(&Joint::damping, false);
    bounds_.left_stiffness = solved_ ? bound(&Joint::stiffness, true) : bounds_.stiffness;
    bounds_.left_damping = solved_ ? bound(&Joint::damping, true) : bounds_.damping;
  }
  bounds_version_ = scene.version();
  bounds_values_version_ = scene.values_version();
  return bounds_;
}

}  // namespace phymul
