// SPDX-License-Identifier: MIT
//
// The state of one body on another of the same shape.
#include <phymul/phymul.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "support/message_of.h"

namespace phymul::test {
namespace {

Model ball_fine_at(const Vec3& place) {
  return make_body(solid_ball({0, 0, 0}, 0.05), {.spacing = 0.016, .spacing_at = fine_near(place, 0.01, 0.004, 0.016)});
}

TEST(StateTransfer, KeepsRigidMotionAndUniformStrain) {
  const Model from = ball_fine_at({0.05, 0, 0}), to = ball_fine_at({-0.05, 0, 0});
  const Mat3 turn = Eigen::AngleAxisd(1.2, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Mat3 motion = turn * Vec3(1.2, 0.9, 0.95).asDiagonal();
  const Vec3 away(0.1, -0.2, 0.3), spin(3, -2, 1);
  const auto moved = [&](const Model& model) {
    State state{2.5, {}, {}};
    for (const Vec3& x : model.rest) {
      state.position.push_back(motion * x + away);
      state.velocity.push_back(spin.cross(x) + away);
    }
    return state;
  };
  State state = moved(from);
  state.tools.push_back({.name = "probe", .pose = {.position = {1, 2, 3}}, .placed = false});
  const State there = StateTransfer(from, to)(state), expected = moved(to);
  EXPECT_EQ(there.time, 2.5);
  ASSERT_EQ(there.position.size(), to.rest.size());
  ASSERT_EQ(there.velocity.size(), to.rest.size());
  for (std::size_t i = 0; i < to.rest.size(); ++i) {
    ASSERT_LT((there.position[i] - expected.position[i]).norm(), 1e-12);
    ASSERT_LT((there.velocity[i] - expected.velocity[i]).norm(), 1e-12);
  }
  ASSERT_EQ(there.tools.size(), 1u);
  EXPECT_EQ(there.tools[0].pose.position, Vec3(1, 2, 3));
  EXPECT_TRUE(there.tools[0].placed);
}

TEST(StateTransfer, RefusesWhatNamesParticles) {
  const Model body = make_body(solid_ball({0, 0, 0}, 0.05), {.spacing = 0.02});
  const State rest = rest_state(body);
  const StateTransfer transfer(body, body);
  const auto message = [&](const State& state) { return message_of([&] { transfer(state); }); };
  EXPECT_EQ(message(rest), "(no error)");
  State state = rest;
  state.velocity.pop_back();
  EXPECT_TRUE(says(message(state), "expected positions and velocities of "));
  state = rest;
  state.tools.push_back({.name = "hook", .held = {0}, .held_at = {Vec3::Zero()}});
  EXPECT_TRUE(says(message(state), "the tool \"hook\" holds particles, which"));
  state = rest;
  state.tools.push_back({.name = "needle"});
  state.tools[0].needle.hole.emplace_back();
  EXPECT_TRUE(says(message(state), "the needle \"needle\" is in the body"));
  state = rest;
  state.joints.push_back({"suture", {1}});
  EXPECT_TRUE(says(message(state), "the joint \"suture\" has broken springs"));
  Model far = body;
  for (Vec3& x : far.rest) x.x() += 1.0;
  EXPECT_TRUE(refuses([&] { StateTransfer(body, far); }, "not within 1 cells of the body"));
}

}  // namespace
}  // namespace phymul::test
