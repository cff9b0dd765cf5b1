// SPDX-License-Identifier: MIT
//
// Friction of contacts that press for some rounds of a step and then no more.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "support/run_scenes.h"

namespace phymul {
namespace {

using namespace test;

Model slab(const Vec3& size, const Vec3& at, double density) {
  Model model = with_material(make_block(size, 1, 1, 1), {5e3, 0.3, density});
  return moved(std::move(model), at);
}

/// A small block in the corner between a floor and a wall, both heavy, that comes to both in one step. The wall goes up
/// and lifts it, so that the floor, which came first, has nothing more to press against: and then does not rub either.
TEST(ContactFriction, OfAReleasedContactIsTakenBack) {
  constexpr double skin = 1e-4, mu = 0.5, heavy = 1e9;
  const Model floor = slab({0.10, 0.10, 0.01}, {-0.05, -0.05, -0.01}, heavy),
              wall = slab({0.01, 0.12, 0.10}, {-0.01, -0.06, -0.05}, heavy),
              block = slab({0.005, 0.005, 0.005}, {2.0001 * skin, 0.002, 2.0001 * skin}, 1000.0);
  const std::array<NamedBody, 3> bodies{NamedBody{"floor", &floor}, {"wall", &wall}, {"block", &block}};
  const Model model = merge_models(bodies);
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene = Scene(model).contacts({.friction = mu, .margin = skin});
    const auto solver = make_solver(backend, model, scene, {}, {.on_unstable = UnstableStep::allow});
    State start = rest_state(model);
    const Vec3 thrown(-0.2, 2.0, -0.02);  // m/s
    for (const Index i : model.group("wall")) start.velocity[i] = {0, 0, 2.0};
    for (const Index i : model.group("block")) start.velocity[i] = thrown;
    solver->reset(start);
    ASSERT_TRUE(is_ok(solver->step(1, 1e-5)));
    const State end = solver->read();
    const double rounding = backend[0] == 'r' ? 1e-9 : 1e-5;
    int met_both = 0;
    for (const Index i : model.group("block")) {
      const Vec3 gained = end.velocity[i] - thrown;
      if (model.rest[i].x() > 0.002 || model.rest[i].z() > 0.002) continue;
      ++met_both;
      EXPECT_NEAR(gained.x(), 0.2, 0.002) << backend;
      EXPECT_GT(end.velocity[i].z(), 0.0) << backend;  // lifted: off the floor
      EXPECT_NEAR(std::hypot(gained.y(), gained.z()), mu * gained.x(), rounding) << backend;
    }
    EXPECT_EQ(met_both, 2);
  }
}

}  // namespace
}  // namespace phymul
