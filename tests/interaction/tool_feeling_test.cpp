// SPDX-License-Identifier: MIT
//
// What a tool feels of particles that cannot give way along every axis: nothing along those that are imposed, as what
// imposes them takes it.
#include <algorithm>

#include "support/tool_backends.h"

namespace phymul::test {
namespace {

using ToolFeeling = WithTools;
PHYMUL_ON_EVERY_BACKEND(ToolFeeling);

/// A ball whose centre is out of the plane pushes a flat body askew, and feels it only in the plane.
TEST_P(ToolFeeling, NothingOutOfAFlatBodysPlane) {
  const Model model = make_strip(0.04, 0.02, 8, 4);
  Scene scene(model);
  scene.fix("y0").add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = {0.02, 0.0264, 0.004}}});
  const auto solver = make(model, scene);
  double most = 0.0;
  for (int k = 1; k <= 20; ++k) {
    scene.tool("ball").move_to({.position = {0.02, 0.0264 - 1e-4 * k, 0.004}});
    ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
    const Vec3& force = solver->tool_force("ball").force;
    EXPECT_EQ(force.z(), 0.0) << k;
    most = std::max(most, force.norm());
  }
  EXPECT_GT(most, 1e-6);
}

/// Likewise where loads impose one coordinate of what it pushes.
TEST_P(ToolFeeling, NothingAlongAnImposedAxis) {
  const Model model = soft_block({0.02, 0.02, 0.02}, 4, 4, 4);
  for (int axis = 0; axis < 2; ++axis) {
    Scene scene(model);
    scene.fix("z0");
    Load held;
    held.type = LoadType::translation;
    held.particles = model.group("z1");
    held.axes = {Axis::free, Axis::free, Axis::free};
    held.axes[static_cast<std::size_t>(axis)] = Axis::held;
    scene.add(held);
    // Between lattice points, so that it pushes aside whatever it meets.
    const Vec3 above(0.0085, 0.0085, 0.028);
    scene.add_tool("ball", {.shape = Sphere{0.008}, .pose = {.position = above}, .friction = 0.4});
    const auto solver = make(model, scene);
    double most = 0.0;
    for (int k = 1; k <= 10; ++k) {
      scene.tool("ball").move_to({.position = above - Vec3(0, 0, 2e-4 * k)});
      ASSERT_TRUE(solver->step(2, 0.3 * solver->stable_step()).ok());
      const Vec3& force = solver->tool_force("ball").force;
      EXPECT_EQ(force[axis], 0.0) << axis << ", " << k;
      most = std::max(most, std::abs(force[1 - axis]));
    }
    EXPECT_GT(most, 1e-3);
  }
}

}  // namespace
}  // namespace phymul::test
