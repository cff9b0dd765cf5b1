// SPDX-License-Identifier: MIT
//
// Joints of few springs, solved implicitly so that they do not set the step (SolverOptions::max_substeps).
//
// A spring between weighted means has K = G k G^T and the damping G c G^T, where G has the weights of its particles. A
// step of dt that takes (M + G S G^T)^-1 f in place of f / M, with S = (dt^2 k + 2 dt c) / (2 (1 + d)), is stable as
// far as the body alone is: of any motion, what the spring adds to dt^2 K + 2 dt C is at most 2 (1 + d) times what it
// adds to the mass. Rest shapes are the same. By Woodbury's identity, with B the inverse masses,
//   a = B f - B G S^1/2 (1 + S^1/2 G^T B G S^1/2)^-1 S^1/2 G^T B f,
// which is a force between the anchors: linear momentum is conserved, and angular momentum where the force is along the
// line between them.
#pragma once

#include <phymul/scene.h>

#include <span>
#include <vector>

#include "elastic/local_steps.h"
#include "joint_set.h"

namespace phymul {

/// By Scene::joints(): joints that do not go slack, together of few springs, and of no particles that have substeps.
/// `steps`: of the body, or null.
std::vector<bool> solved_joints(const Scene& scene, const LocalSteps* steps);

class StiffJoints {
 public:
  struct Reached {
    Index particle = -1;
    Vec3 acceleration{0, 0, 0};  // m/s^2, by all forces and local steps, 0 for imposed coordinates; the backend's
    Vec3 force{0, 0, 0};         // N, result of act()
  };

  /// After a change of the scene. `fixed`: as LoadFrame::fixed. Allocates.
  void follow(const Scene& scene, const TopologyTextures& topology, std::span<const std::uint8_t> fixed,
              const LocalSteps* steps);
  bool empty() const { return springs_.empty(); }
  std::span<Reached> reached() { return reached_; }

  /// The forces to be added in a step of dt that multiplies velocities by d: those of the springs that `joints`, which
  /// must have acted, left out, and what the solution changes. The latter alone, which is linear in the accelerations,
  /// for accelerations that came later. Does not allocate.
  void act(const Scene& scene, const JointSet& joints, double dt, double d, bool later = false);
  /// After all of a step: the springs' forces in it, which are those of the law less what the solution takes.
  void tell(JointSet& joints) const;
  /// J: v (G S G^T) next / 2 in the last act(), what the solution adds to a kinetic energy. m/s, [N].
  double added_energy(std::span<const Vec3> v, std::span<const Vec3> next) const;

 private:
  struct End {
    std::size_t row;  // of reached_
    Vec3 value;
  };
  struct Spring {
    std::size_t joint, row;
    std::vector<End> weights, motion;            // of G; of B G, times the mass
    Vec3 force{0, 0, 0}, acceleration{0, 0, 0};  // N, on anchor `b`; m/s^2, of `b` against `a` before the solution
    Vec3 whole{0, 0, 0};                         // N, on `b`, of all calls of act() in the step
  };
  struct Row {
    std::size_t spring;
    Vec3 direction;  // times the root of S
  };

  std::size_t row_of(Index particle);
  void list_rows(const Scene& scene, const JointSet& joints, double dt, double d);
  void solve();

  int dimension_ = 3;
  std::vector<Spring> springs_;
  std::vector<Vec3> compliance_;  // [springs][springs] 1/kg: G^T B G, by axis
  std::vector<char> coupled_;     // whether it is not 0
  std::vector<Reached> reached_;
  std::vector<Row> rows_;
  std::vector<double> matrix_, value_;
  std::vector<std::size_t> begin_;  // of the rows of the matrix, whose entries before are 0
};

/// Of a whole state in a step of dt. Allocates.
struct StiffJointsNow {
  StiffJointsNow(const Scene& scene, const State& state, const TopologyTextures& topology,
                 std::span<const std::uint8_t> fixed, const LocalSteps* steps, double dt, double d,
                 std::span<const Vec3> acceleration);
  StiffJoints joints;  ///< have acted
};

}  // namespace phymul
