// SPDX-License-Identifier: MIT
//
// A ball pressed into a block by one millimetre after the other, and held after each: how deep the body comes to rest
// under it. Deeper, cells fold below the ball's pole, particles meet where the energy has a kink, and an explicit step
// moves them to and fro at a few metres a second: no state of rest, which reports must say.
#include <cmath>
#include <cstdio>

#include "stability_fixture.h"

namespace phymul::test {
namespace {

constexpr double ball = 0.010;  // m
constexpr int deepest = 15;     // mm

struct Depth {
  int rests = 0;      ///< mm, the last one at which the body came to rest
  bool said = false;  ///< that of the first one at which it did not, by a cut force
};

Depth pressed(double poisson, double friction) {
  const Model model =
      with_material(make_block({0.06, 0.06, 0.05}, 12, 12, 10), {.young = 25e3, .poisson = poisson, .density = 1000});
  Scene scene = Scene(model).fix("z0");
  const auto held_at = [](double depth) { return ToolPose{.position = {0.03, 0.03, 0.05 + ball - depth}}; };
  scene.add_tool("ball", {.shape = Sphere{ball}, .pose = held_at(0.0), .friction = friction});
  const auto solver = make_solver("cpu", model, scene, {}, damped(50.0));
  const double dt = 0.5 * solver->stable_step();
  const int tenth = static_cast<int>(std::ceil(1e-3 / dt));  // of a millimetre, at 0.1 m/s
  Depth depth;
  for (int mm = 1; mm <= deepest; ++mm) {
    for (int k = 1; k <= 10; ++k) {
      scene.tool("ball").move_to(held_at(1e-3 * (mm - 1) + 1e-4 * k));
      EXPECT_TRUE(solver->step(tenth, dt).ok());
    }
    // Some settle late.
    StepReport report;
    for (int tries = 0; tries < 5; ++tries) {
      report = solver->step(static_cast<int>(0.3 / dt), dt);
      EXPECT_TRUE(report.ok());
      if (report.max_speed <= 1e-3) break;
    }
    if (report.max_speed > 1e-3) {
      depth.said = report.force_clamped;
      return depth;
    }
    depth.rests = mm;
  }
  depth.said = true;
  return depth;
}

struct Pressed {
  double poisson;
  double friction;
  int at_least;  ///< mm

  friend void PrintTo(const Pressed& pressed, std::ostream* out) {
    *out << "nu " << pressed.poisson << ", friction " << pressed.friction;
  }
};

class StabilityPressed : public testing::TestWithParam<Pressed> {};

TEST_P(StabilityPressed, RestsDownToADepthAndSaysWhereNot) {
  const auto& [poisson, friction, at_least] = GetParam();
  const Depth depth = pressed(poisson, friction);
  std::printf("nu %.2f, friction %.1f: rests down to %d mm\n", poisson, friction, depth.rests);
  EXPECT_GE(depth.rests, at_least);
  EXPECT_TRUE(depth.said);
}

/// Bounds one to four millimetres below what was seen: where a cell folds, the last bit decides when.
INSTANTIATE_TEST_SUITE_P(All, StabilityPressed,
                         testing::Values(Pressed{0.3, 0.0, 3}, Pressed{0.3, 0.1, 8}, Pressed{0.45, 0.1, 8}));

}  // namespace
}  // namespace phymul::test
