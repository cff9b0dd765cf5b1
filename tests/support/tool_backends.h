// SPDX-License-Identifier: MIT
//
// The fixture of tests that every backend runs that takes tools, and what they share.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>

#include "bodies.h"

namespace phymul::test {

/// Backends whose solvers take tools; "reference" and "cpu" are always among them.
inline std::vector<std::string> tool_backends() {
  const Model model = make_tetrahedron(0.01);
  const Scene scene(model);
  std::vector<std::string> all;
  for (const std::string& name : backend_names()) {
    if (why_unavailable(name).empty() && make_solver(name, model, scene)->takes_tools()) all.push_back(name);
  }
  return all;
}

/// Backends that take needles: all of these but "gl".
inline std::vector<std::string> needle_backends() {
  std::vector<std::string> all = tool_backends();
  std::erase(all, "gl");
  return all;
}

/// "gl-compute" as a test may be called: gl_compute.
inline std::string test_name_of(std::string backend) {
  std::ranges::replace(backend, '-', '_');
  return backend;
}

class WithTools : public testing::TestWithParam<std::string> {
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

inline double total_mass(const Model& model) {
  double total = 0.0;
  for (const double mass : model.mass) total += mass;
  return total;
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

#define PHYMUL_ON_BACKENDS(name, backends)                         \
  INSTANTIATE_TEST_SUITE_P(All, name, testing::ValuesIn(backends), \
                           [](const auto& backend) { return phymul::test::test_name_of(backend.param); })
#define PHYMUL_WITH_TOOLS(name) PHYMUL_ON_BACKENDS(name, phymul::test::tool_backends())
#define PHYMUL_WITH_NEEDLES(name) PHYMUL_ON_BACKENDS(name, phymul::test::needle_backends())
