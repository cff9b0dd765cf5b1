// SPDX-License-Identifier: MIT
//
// The fixture of tests that every backend runs that takes tools, and what they share.
#pragma once

#include "bodies.h"
#include "every_backend.h"

namespace phymul::test {

/// "gl" takes none.
inline std::vector<std::string> needle_backends() {
  std::vector<std::string> all = backend_names();
  std::erase(all, "gl");
  return all;
}

class WithTools : public OnEveryBackend {
 protected:
  static std::unique_ptr<Solver> make(const Model& model, const Scene& scene, const SolverOptions& options = {}) {
    return make_solver(GetParam(), model, scene, {}, options);
  }
  static double roundoff() { return GetParam() == "reference" ? 0x1p-53 : 0x1p-24; }
};

inline Model soft_block(const Vec3& size, int nx, int ny, int nz) {
  Model model = make_block(size, nx, ny, nz);
  set_material(model, soft_tissue());
  return model;
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

}  // namespace phymul::test

#define PHYMUL_WITH_NEEDLES(suite) PHYMUL_ON_BACKENDS(suite, ::phymul::test::needle_backends())
