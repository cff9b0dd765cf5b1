// SPDX-License-Identifier: MIT
//
// The joints of a scene as one solver knows them: their forces step by step, and which springs are broken. act() works
// in double precision whatever the backend's own is, and sums in the order of the springs, so that no number of threads
// changes a bit. A device finds the forces itself: take().
#pragma once

#include <phymul/joint.h>
#include <phymul/scene.h>
#include <phymul/state.h>

#include <algorithm>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace phymul {

/// A tool during one step; of a state alone both are the same.
struct ToolWay {
  ToolPose pose, next_pose;
  bool is_free = false;  // a needle that was let go: nothing pulls it
};

/// Upper bounds of what the joints of a scene add to a body: of the largest eigenvalue of M^-1 K, 1/s^2, and of M^-1 C,
/// 1/s. Entry (i, j) of a spring between weighted means is +-k w_i w_j / m_i. The largest eigenvalue of A is at most
/// max (|A| x)_i / x_i for any positive x (L. Collatz, Einschliessungssatz fuer die charakteristischen Zahlen von
/// Matrizen, Math. Z. 48, 1942); x = 1 gives Gershgorin's circles, and a few multiplications of x by |A| better ones.
struct JointBounds {
  double stiffness = 0.0, damping = 0.0;
  double left_stiffness = 0.0, left_damping = 0.0;  ///< of joints that are not solved implicitly
};

class JointSet {
 public:
  /// A particle that joints pull.
  struct Point {
    Index particle = -1;
    Vec3 position{0, 0, 0};  // m, at the step's start; the backend writes it
    Vec3 velocity{0, 0, 0};  // m/s, of the half step before; likewise
    Vec3 force{0, 0, 0};     // N, result of act()
  };
  /// What joints do to a tool, about its position at the step's end (as react() in tool_frame.h).
  struct Pull {
    Vec3 force{0, 0, 0}, torque{0, 0, 0};  // N, N m
  };

  /// Takes over the scene's joints after a change; joints that stay keep their broken springs. Allocates. The scene
  /// must stay where it is.
  void follow(const Scene& scene);
  bool empty() const { return joints_.empty(); }

  void reset(const State& state);
  void read(State& state) const;

  std::span<Point> points() { return points_; }  // by particle, each once
  /// Forces of one step, from positions and velocities of points(). `tools`: by Scene::tools(). Does not allocate.
  void act(std::span<const ToolWay> tools, double dt);
  std::span<const Pull> pulls() const { return pulls_; }  // of the last act(), by Scene::tools()
  /// What a device tells of a spring: of the last one of some steps, and about the tool it ends at, if any, summed over
  /// them. Torques are on that tool, about its position at the end of each step.
  struct Told {
    SpringReport spring;
    Vec3 torque{0, 0, 0}, sum_force{0, 0, 0}, sum_torque{0, 0, 0};  // N m; N, N m
  };
  /// In place of act(): `told` by springs, joint by joint. Adds the sums to `sums`, by Scene::tools().
  void take(std::span<const Told> told, std::span<Pull> sums);
  void accept();  ///< the step counts: springs whose force was too large break, and report() has its forces

  int broken() const;  ///< springs, of all joints

  double energy() const { return energy_; }  ///< J, of the springs in the last act()

  /// Of a spring in the last act(), by Scene::joints().
  struct Now {
    const Vec3& reach;  ///< m, from anchor `a` to `b`
    const Vec3& force;  ///< N, on anchor `a`
    bool was_broken;    ///< or at a needle that was let go
    bool left_out;
  };
  Now now(std::size_t joint, std::size_t spring) const {
    const Followed& of = joints_[joint];
    return {of.reach[spring], of.next[spring].force, of.report.springs[spring].broken || of.loose[spring] != 0,
            is_left_out(joint)};
  }

  /// Of a spring that the last act() left out: the force on anchor `a`, N, that it has in this step. Once a step.
  void set_force(std::size_t joint, std::size_t spring, const Vec3& force);
  bool is_finite() const;  ///< what accept() would report

  /// Before follow(): act() gives nothing the forces of joints that `solved`(scene) names, by Scene::joints(), and
  /// breaks none of their springs; JointBounds::left_stiffness and left_damping are without them.
  void leave_out(std::function<std::vector<bool>(const Scene&)> solved) { solved_ = std::move(solved); }

  /// Of a scene as it is now, which follow() need not have seen. `mass`: [N] kg, always the same. Allocates only after
  /// a change of Scene::version().
  const JointBounds& bounds(const Scene& scene, std::span<const double> mass);

  /// Of a joint of the scene as it is now; where follow() has not seen it yet, zeros. Valid until the next call.
  const JointReport& report(const SceneJoint& wanted) const;

 private:
  void number_rows(const Scene& scene, std::size_t particles);
  template <class Constant>
  double largest_of(const Scene& scene, std::span<const double> mass, const Constant& constant);
  void add_row(const JointSpring& spring, double constant, std::span<const double> mass);

  struct End {
    std::vector<Index> points;  // rows of points_; empty: `place` of the world, or of a tool
    std::vector<double> weights;
    Index tool = -1;
    Vec3 place{0, 0, 0};
  };
  struct Ends {
    End a, b;
  };
  struct Followed {
    std::uint64_t id = 0;
    std::string name;
    std::vector<Ends> springs;
    std::vector<SpringReport> next;  // of the step in question
    VecList reach;                   // [springs] m, likewise
    VecList arm;                     // [springs] m, likewise: from a tool, at the step's end, to the end that it has
    std::vector<char> loose;         // [springs] likewise: it is at a needle that was let go
    JointReport report;
  };
  struct Motion {
    Vec3 position, velocity;
  };

  void break_removed(Followed& followed, const Joint& joint) const;
  bool is_left_out(std::size_t row) const { return row < left_out_.size() && left_out_[row]; }
  End end_of(const Anchor& anchor, const std::vector<SceneTool>& tools) const;
  Motion motion_of(const End& end, std::span<const ToolWay> tools, double dt) const;
  void give(const End& end, const Vec3& force);
  void give_tool(const Ends& ends, const Vec3& force, const Vec3& arm);
  void act(std::size_t row, std::span<const ToolWay> tools, double dt);

  const Scene* scene_ = nullptr;
  std::vector<Followed> joints_;  // by Scene::joints()
  std::vector<Point> points_;
  std::vector<Pull> pulls_;
  double energy_ = 0.0;
  mutable JointReport unseen_;
  JointBounds bounds_;
  std::uint64_t bounds_version_ = 0, bounds_values_version_ = 0;
  std::function<std::vector<bool>(const Scene&)> solved_;
  std::vector<bool> left_out_;  // by Scene::joints(); empty: none
  // Of bounds(), empty before it is called with joints:
  std::vector<Index> row_of_;        // [N], -1: no spring
  std::vector<double> row_, trial_;  // [rows]
};

/// Throws Error where a joint's part of a state names springs that the scene's joint of that name does not have.
void require_joint_states(const State& state, const std::vector<SceneJoint>& joints);

/// The joints of a scene that have acted on a whole state, with tools at rest. Allocates.
JointSet joints_of(const Scene& scene, const State& state);

/// Adds the forces of the scene's joints in a whole state to `force`, [N] N, and returns their energy, J. Nothing
/// without joints; allocates.
double add_joint_forces(const Scene& scene, const State& state, std::span<Vec3> force);

// The law of a joint's spring (include/phymul/joint.h).

/// Whether it ends at a particle all of whose tissue is removed: such a spring is broken. `mass`: of all particles.
inline bool ends_at_removed(const JointSpring& spring, std::span<const double> mass) {
  const auto removed = [&](Index i) { return mass[i] == 0.0; };
  return std::ranges::any_of(spring.a.particles, removed) || std::ranges::any_of(spring.b.particles, removed);
}

/// N, on anchor `a`, where `r` leads to `b`, m, and `v` is how it changes, m/s.
inline Vec3 spring_force(const Joint& joint, const JointSpring& spring, const Vec3& r, const Vec3& v) {
  const double k = spring.share * joint.stiffness, c = spring.share * joint.damping;
  if (spring.rest_length == 0.0) {
    const Vec3 force = k * r + c * v;
    return joint.slack && force.dot(r) < 0.0 ? Vec3(Vec3::Zero()) : force;
  }
  const double length = r.norm();
  // In one point the spring has no direction.
  if (length == 0.0 || (joint.slack && length <= spring.rest_length)) return Vec3::Zero();
  const Vec3 direction = r / length;
  const double pull = k * (length - spring.rest_length) + c * v.dot(direction);
  return joint.slack && pull < 0.0 ? Vec3(Vec3::Zero()) : Vec3(pull * direction);
}

/// J.
inline double spring_energy(const Joint& joint, const JointSpring& spring, double length) {
  const double stretch = length - spring.rest_length;
  if (joint.slack && stretch < 0.0) return 0.0;
  return 0.5 * spring.share * joint.stiffness * stretch * stretch;
}

/// N/m: how the force on anchor `a` grows with r, without what a compressed spring takes from the stiffness sideways,
/// so that no eigenvalue is below 0.
inline Mat3 spring_tangent(const Joint& joint, const JointSpring& spring, const Vec3& r) {
  const double k = spring.share * joint.stiffness, length = r.norm();
  if (spring.rest_length == 0.0) return k * Mat3::Identity();
  if (length == 0.0 || (joint.slack && length <= spring.rest_length)) return Mat3::Zero();
  const Mat3 along = r * r.transpose() / (length * length);
  const double tension = length > spring.rest_length ? 1.0 - spring.rest_length / length : 0.0;
  return k * (along + tension * (Mat3::Identity() - along));
}

}  // namespace phymul
