// SPDX-License-Identifier: MIT
//
// Jaws: they close with their force, hold by friction alone, slip when pulled too hard, and go back with a snapshot.
#include <phymul/jaws.h>

#include <algorithm>
#include <cmath>

#include "support/message_of.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double tick = 2e-3;  // s

/// An ellipsoid whose tip at +x is between jaws that come from there and open along z.
struct Grasp {
  double x = 0.068;  // m, of the hinge
  Simulation sim;
  Jaws jaws;

  Grasp(const std::string& backend, const JawsOptions& options)
      : sim(body(), {.backend = backend, .damping = {.rate = 50.0}}), jaws(sim.scene(), "grasper", options, hinge()) {
    std::vector<Index> held;
    for (Index i = 0; i < sim.model().particle_count(); ++i) {
      if (sim.model().rest[i].x() < -0.03) held.push_back(i);
    }
    sim.scene().fix(held);
  }
  static Model body() {
    return with_material(make_body(solid_ellipsoid({0, 0, 0}, {0.06, 0.03, 0.02}), {.spacing = 0.009}),
                         {.young = 5e3, .poisson = 0.45, .density = 1000.0});
  }
  ToolPose hinge() const {
    Mat3 turn;
    turn << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    return {.position = {x, 0, 0}, .orientation = Quaternion(turn)};
  }
  /// Ticks in which the hinge goes to a place along x.
  void go(double to, double seconds) {
    const int ticks = static_cast<int>(std::lround(seconds / tick));
    const double from = x;
    for (int k = 1; k <= ticks; ++k) {
      x = from + (to - from) * k / ticks;
      jaws.follow(hinge(), sim.force_on(jaws.first()), sim.force_on(jaws.second()), tick);
      ASSERT_TRUE(is_ok(sim.advance(tick)));
    }
  }
};

JawsOptions wide(double grip) {
  return {.length = 0.024, .width = 0.02, .friction = 0.8, .grip = grip, .opening = 1.2, .speed = 1.0};
}

class JawsOn : public WithTools {};
PHYMUL_ON_EVERY_BACKEND(JawsOn);

TEST(Jaws, CloseWithTheirForceAndPullByFrictionAlone) {
  Grasp grasp("cpu", wide(1.0));
  EXPECT_NEAR(grasp.jaws.angle(), 1.2, 1e-9);
  grasp.jaws.close();
  grasp.go(grasp.x, 1.5);
  const double closed = grasp.jaws.angle();
  EXPECT_NEAR(grasp.jaws.grip(), 1.0, 0.05);
  EXPECT_GT(closed, 0.05);
  EXPECT_LT(closed, 1.1);
  const State before = grasp.sim.state();
  grasp.go(grasp.x + 0.01, 1.0);
  grasp.go(grasp.x, 0.3);
  EXPECT_NEAR(grasp.jaws.grip(), 1.0, 0.05);
  EXPECT_LT(grasp.jaws.force().x(), -0.2);
  EXPECT_LT(grasp.jaws.force().tail<2>().norm(), 0.1 * -grasp.jaws.force().x());
  // The tip goes along.
  const State after = grasp.sim.state();
  Index tip = 0;
  for (Index i = 0; i < grasp.sim.model().particle_count(); ++i) {
    if (grasp.sim.model().rest[i].x() > grasp.sim.model().rest[tip].x()) tip = i;
  }
  EXPECT_NEAR((after.position[tip] - before.position[tip]).x(), 0.01, 2e-3);
  grasp.jaws.open();
  grasp.go(grasp.x, 1.5);
  EXPECT_NEAR(grasp.jaws.angle(), 1.2, 1e-9);
  EXPECT_LT(grasp.jaws.force().norm(), 0.05);
}

TEST(Jaws, SlipWhenPulledTooHard) {
  Grasp grasp("cpu", wide(0.1));
  grasp.jaws.close();
  grasp.go(grasp.x, 1.0);
  EXPECT_NEAR(grasp.jaws.grip(), 0.1, 0.02);
  grasp.go(grasp.x + 0.04, 1.5);
  grasp.go(grasp.x, 0.5);
  EXPECT_LT(grasp.jaws.force().norm(), 1e-3);
  EXPECT_NEAR(grasp.jaws.angle(), 0.0, 1e-9) << "nothing is between them";
}

TEST_P(JawsOn, ContinueBitForBitFromASnapshot) {
  Grasp grasp(GetParam(), wide(0.5));
  grasp.jaws.close();
  grasp.go(grasp.x, 0.3);
  const Snapshot then = grasp.sim.snapshot();
  grasp.go(grasp.x + 0.002, 0.1);
  const State first = grasp.sim.state();
  grasp.sim.restore(then);
  grasp.x -= 0.002;
  grasp.go(grasp.x + 0.002, 0.1);
  EXPECT_EQ(grasp.sim.state().position, first.position);
  EXPECT_EQ(grasp.sim.state().tools, first.tools);
}

TEST(Jaws, AreInRecordings) {
  Grasp grasp("cpu", wide(0.5));
  grasp.sim.record();
  grasp.jaws.close();
  grasp.go(grasp.x, 0.4);
  Simulation again(Grasp::body(), {.backend = "cpu", .damping = {.rate = 50.0}});
  again.replay(grasp.sim.recording());
  EXPECT_EQ(again.snapshot().state, grasp.sim.snapshot().state);
}

TEST(Jaws, RefuseWhatMakesNoSense) {
  Model model = soft_block({0.02, 0.02, 0.02}, 2, 2, 2);
  Scene scene(model);
  const auto refuses_with = [&](const JawsOptions& options, std::string_view what) {
    return refuses([&] { Jaws(scene, "j", options, {}); }, what);
  };
  EXPECT_TRUE(refuses_with({.length = 0.0}, "expected a length (m) above 0, got 0"));
  EXPECT_TRUE(refuses_with({.grip = -1.0}, "expected a grip (N) above 0, got -1"));
  EXPECT_TRUE(refuses_with({.opening = 4.0}, "of at most 3 rad, got 4"));
  EXPECT_TRUE(refuses_with({.friction = -1.0}, "friction"));
  EXPECT_TRUE(scene.tools().empty());
  Jaws jaws(scene, "j", {}, {});
  EXPECT_EQ(scene.tools().size(), 2u);
  EXPECT_TRUE(refuses([&] { jaws.follow({}, {}, {}, -1.0); }, "expected a tick (s) of 0 or more, got -1"));
}

}  // namespace
}  // namespace phymul::test
