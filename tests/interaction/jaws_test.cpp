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

constexpr double jaws_tick = 2e-3;  // s

/// An ellipsoid whose tip at +x is between jaws that come from there and open along z.
struct Grasp {
  Vec3 at{0.068, 0, 0};  // m, of the hinge
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
    return {.position = at, .orientation = Quaternion(turn)};
  }
  /// Ticks in which the hinge goes to a place.
  void go(const Vec3& to, double seconds) {
    const int ticks = static_cast<int>(std::lround(seconds / jaws_tick));
    const Vec3 from = at;
    for (int k = 1; k <= ticks; ++k) {
      at = from + (to - from) * k / ticks;
      jaws.follow(hinge(), sim.force_on(jaws.first()), sim.force_on(jaws.second()), jaws_tick);
      ASSERT_TRUE(is_ok(sim.advance(jaws_tick)));
    }
  }
  Vec3 tip() const {
    const VecList& rest = sim.model().rest;
    const auto first = std::ranges::max_element(rest, {}, [](const Vec3& x) { return x.x(); });
    return sim.state().position[static_cast<std::size_t>(first - rest.begin())];
  }
};

JawsOptions wide(double grip) {
  return {.length = 0.024, .width = 0.02, .friction = 0.8, .grip = grip, .opening = 1.2, .speed = 1.0};
}

class JawsOn : public WithTools {};
PHYMUL_ON_EVERY_BACKEND(JawsOn);

TEST(Jaws, CloseWithTheirForceAndLiftByFrictionAlone) {
  for (const ToolContact contact : {ToolContact::surface, ToolContact::particles}) {
    SCOPED_TRACE(contact == ToolContact::surface);
    JawsOptions options = wide(1.0);
    options.contact = contact;
    Grasp grasp("cpu", options);
    EXPECT_NEAR(grasp.jaws.angle(), 1.2, 1e-9);
    grasp.jaws.close();
    grasp.go(grasp.at, 1.5);
    EXPECT_NEAR(grasp.jaws.grip(), 1.0, contact == ToolContact::surface ? 0.05 : 0.15);
    EXPECT_GT(grasp.jaws.angle(), 0.05);
    EXPECT_LT(grasp.jaws.angle(), 1.1);
    const Vec3 before = grasp.tip();
    grasp.go(grasp.at + Vec3(0, 0, 0.03), 1.0);
    grasp.go(grasp.at, 0.3);
    EXPECT_NEAR(grasp.jaws.grip(), 1.0, 0.15);
    EXPECT_NEAR((grasp.tip() - before).z(), 0.03, 1e-3);
    EXPECT_LT(grasp.jaws.force().z(), -0.08);  // N: the body is bent
    grasp.jaws.open();
    grasp.go(grasp.at, 1.5);
    EXPECT_NEAR(grasp.jaws.angle(), 1.2, 1e-9);
  }
}

TEST(Jaws, SlipWhenPulledTooHard) {
  Grasp grasp("cpu", wide(0.1));
  grasp.jaws.close();
  grasp.go(grasp.at, 1.0);
  EXPECT_NEAR(grasp.jaws.grip(), 0.1, 0.02);
  grasp.go(grasp.at + Vec3(0.04, 0, 0), 1.5);
  grasp.go(grasp.at, 0.5);
  EXPECT_LT(grasp.jaws.force().norm(), 1e-3);
  EXPECT_NEAR(grasp.jaws.angle(), 0.0, 1e-9) << "nothing is between them";
}

TEST_P(JawsOn, ContinueBitForBitFromASnapshot) {
  Grasp grasp(GetParam(), wide(0.5));
  grasp.jaws.close();
  grasp.go(grasp.at, 0.3);
  const Snapshot then = grasp.sim.snapshot();
  const Vec3 from = grasp.at, to = from + Vec3(0.002, 0, 0);
  grasp.go(to, 0.1);
  const State first = grasp.sim.state();
  grasp.sim.restore(then);
  grasp.at = from;
  grasp.go(to, 0.1);
  EXPECT_EQ(grasp.sim.state().position, first.position);
  EXPECT_EQ(grasp.sim.state().tools, first.tools);
}

TEST(Jaws, AreInRecordings) {
  Grasp grasp("cpu", wide(0.5));
  grasp.sim.record();
  grasp.jaws.close();
  grasp.go(grasp.at, 0.4);
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
  EXPECT_TRUE(refuses_with({.toughness = -1.0}, "expected a toughness (J/m^2) of 0 or more, got -1"));
  EXPECT_TRUE(refuses([&] { Jaws(scene, "", {}, {}); }, "Jaws: expected a name, got an empty one"));
  EXPECT_TRUE(scene.tools().empty());
  scene.add_tool("k 2", {.shape = Sphere{0.001}});
  EXPECT_TRUE(refuses([&] { Jaws(scene, "k", {}, {}); }, "k 2"));
  EXPECT_EQ(scene.tools().size(), 1u);
  scene.remove_tool("k 2");
  Jaws jaws(scene, "j", {}, {});
  EXPECT_EQ(scene.tools().size(), 2u);
  EXPECT_TRUE(refuses([&] { jaws.follow({}, {}, {}, -1.0); }, "expected a tick (s) of 0 or more, got -1"));
}

}  // namespace
}  // namespace phymul::test
