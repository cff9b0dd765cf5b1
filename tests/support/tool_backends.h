// SPDX-License-Identifier: MIT
//
// The fixture of tests that every backend runs that takes tools, and what they share.
#pragma once

#include "bodies.h"
#include "every_backend.h"

namespace phymul::test {

inline Model soft_block(const Vec3& size, int nx, int ny, int nz) {
  return with_material(make_block(size, nx, ny, nz));
}

/// What is missing between what a tool's force took from a body in one step and what the body's momentum lost, about
/// the tool: N and N m, over `dt`.
struct Imbalance {
  Vec3 force{0, 0, 0}, torque{0, 0, 0};
};
inline Imbalance imbalance(const Momentum& before, const Momentum& after, const Solver& solver,
                           const std::vector<std::string>& tools, double dt) {
  Imbalance left{(after.linear - before.linear) / dt, (after.angular - before.angular) / dt};
  for (const std::string& name : tools) {
    const ToolForce& on_tool = solver.tool_force(name);
    left.force += on_tool.force;
    left.torque += on_tool.torque + solver.tool_pose(name).position.cross(on_tool.force);
  }
  return left;
}

class WithTools : public OnEveryBackend {
 protected:
  static std::unique_ptr<Solver> make(const Model& model, const Scene& scene, const SolverOptions& options = {}) {
    return make_solver(GetParam(), model, scene, {}, options);
  }
  static double roundoff() { return GetParam() == "reference" ? 0x1p-53 : 0x1p-24; }

  /// One step, in which the body loses what these tools feel. The sum of their forces, N.
  static double balanced_step(Solver& solver, const std::vector<std::string>& tools, double dt) {
    const Momentum before = solver.momentum();
    EXPECT_TRUE(solver.step(1, dt).ok());
    double force = 0.0;
    for (const std::string& name : tools) force += solver.tool_force(name).force.norm();
    const Imbalance left = imbalance(before, solver.momentum(), solver, tools, dt);
    // Sums of some hundred forces of this size, over momenta of total_mass * 1 m/s.
    const double noise = 1e3 * roundoff() * (force + total_mass(solver.model()) * 1.0 / dt);
    EXPECT_LE(left.force.norm(), noise) << solver.time();
    EXPECT_LE(left.torque.norm(), 0.05 * noise) << solver.time();
    return force;
  }
};

}  // namespace phymul::test
