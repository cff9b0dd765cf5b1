// SPDX-License-Identifier: MIT
//
// Joints in snapshots, state files, recordings and warnings.
#include <gtest/gtest.h>

#include <filesystem>

#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

class JointSessionIn : public OnEveryBackend {
 protected:
  /// A block on a bed of springs that tear one after the other while gravity lifts it on one side.
  Simulation on_a_bed() const {
    Simulation sim(with_material(make_block({0.04, 0.02, 0.02}, 4, 2, 2)), {.backend = GetParam()});
    sim.scene().gravity({30, 0, 9.81});
    sim.scene().attach(sim.model().group("z0"), World{},
                       {.stiffness = 4e5, .damping = 10.0, .breaking_stress = 400.0, .name = "bed"});
    return sim;
  }
};
PHYMUL_ON_EVERY_BACKEND(JointSessionIn);

TEST_P(JointSessionIn, SnapshotsKnowWhatBroke) {
  Simulation sim = on_a_bed();
  int broken = 0;
  while (broken == 0 && sim.time() < 1.0) {
    ASSERT_TRUE(sim.advance(0.001).ok());
    broken = sim.solver().joint_report("bed").broken;
  }
  ASSERT_GT(broken, 0);
  ASSERT_LT(broken, 15) << "some hold still";
  const Snapshot middle = sim.snapshot();
  ASSERT_EQ(middle.state.joints.size(), 1u);
  EXPECT_EQ(static_cast<int>(middle.state.joints[0].broken.size()), broken);
  ASSERT_TRUE(sim.advance(0.02).ok());
  const Snapshot end = sim.snapshot();
  sim.restore(middle);
  EXPECT_EQ(sim.solver().joint_report("bed").broken, broken);
  ASSERT_TRUE(sim.advance(0.02).ok());
  EXPECT_EQ(sim.snapshot(), end);

  const std::string path = testing::TempDir() + "phymul_joints_" + GetParam() + ".state";
  save_state(middle, path);
  EXPECT_EQ(read_state(path), middle);
  Simulation other = on_a_bed();
  other.load(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(other.advance(0.02).ok());
  EXPECT_EQ(other.snapshot(), end);

  sim.unrecorded_solver().reset();
  EXPECT_EQ(sim.solver().joint_report("bed").broken, 0);
  EXPECT_TRUE(sim.solver().read().joints.empty());
  State wrong = middle.state;
  wrong.joints[0].broken = {15};
  EXPECT_TRUE(refuses([&] { sim.unrecorded_solver().reset(wrong); }, "joint \"bed\" has the broken spring 15"));
  wrong.joints[0].name = "gone";
  sim.unrecorded_solver().reset(wrong);
  EXPECT_EQ(sim.solver().joint_report("bed").broken, 0) << "of a joint that the scene does not have";
}

TEST_P(JointSessionIn, AReplayHasTheSameBits) {
  Simulation sim = on_a_bed();
  sim.record();
  ASSERT_TRUE(sim.advance(0.01).ok());
  const ToolHandle tool = sim.scene().add_tool({.shape = Sphere{0.001}, .pose = {.position = {0.02, 0.01, 0.05}}});
  const JointHandle rope =
      sim.scene().add_joint({at_mean(sim.model().group("z1")), at_tool("tool 1", {0, 0, 0.01})}, 5.0, 0.01);
  ASSERT_TRUE(sim.advance(0.01).ok());
  rope.set_rest_length(0.02);
  sim.scene().joint("bed").set_stiffness(3e5, 5.0);
  tool.move_to({.position = {0.02, 0.015, 0.06}});
  ASSERT_TRUE(sim.advance(0.01).ok());
  sim.scene().remove_joint("joint 2").remove_tool("tool 1");
  sim.scene().attach(sim.model().group("x0"), World{{-0.01, 0, 0}}, {.stiffness = 1e4, .slack = true});
  ASSERT_TRUE(sim.advance(0.01).ok());
  const Snapshot end = sim.snapshot();
  EXPECT_FALSE(end.state.joints.empty()) << "some springs broke, or this shows less";
  const Recording recording = sim.recording();

  Simulation again(sim.model(), {.backend = GetParam()});
  again.replay(recording);
  EXPECT_EQ(again.snapshot(), end);
  ASSERT_EQ(again.scene().joints().size(), 2u);
  for (std::size_t row = 0; row < 2; ++row) {
    EXPECT_EQ(again.scene().joints()[row].name, sim.scene().joints()[row].name);
    EXPECT_EQ(again.scene().joints()[row].joint, sim.scene().joints()[row].joint);
  }
}

/// Scene::bring_back() puts a tool and a joint before others that stayed.
TEST_P(JointSessionIn, AReplayHasWhatWasBroughtBackInItsOrder) {
  Simulation sim = on_a_bed();
  const auto add_tool = [&](const char* name, double x) {
    sim.scene().add_tool(name, {.shape = Sphere{0.002}, .pose = {.position = {x, 0.01, 0.021}}});
  };
  add_tool("bed", 0.005);
  add_tool("b", 0.015);
  sim.scene().attach(sim.model().group("x0"), World{{-0.01, 0, 0}}, {.stiffness = 1e4});
  sim.record();
  ASSERT_TRUE(sim.advance(0.002).ok());
  const SceneParts all = sim.scene().parts();
  sim.scene().remove_joint("bed").remove_tool("bed");
  ASSERT_TRUE(sim.advance(0.002).ok());
  sim.scene().bring_back(all);
  ASSERT_TRUE(sim.advance(0.002).ok());
  Simulation again(sim.model(), {.backend = GetParam()});
  again.replay(sim.recording());
  EXPECT_EQ(difference(again.scene().parts(), all), "");
  EXPECT_EQ(again.snapshot(), sim.snapshot());
}

TEST(JointsAtRest, PullNothingThatIsRemoved) {
  Simulation sim(with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2)), {.backend = "reference"});
  sim.scene().fix("z0");
  const std::vector<Index> top = sim.model().group("z1");
  sim.remove_cells(
      sim.model().cells_in([](const Vec3& place) { return (place.array() > Vec3(0.01, 0.01, 0.01).array()).all(); }));
  const auto gone = std::ranges::find_if(top, [&](Index i) { return sim.model().mass[i] == 0.0; });
  ASSERT_NE(gone, top.end());
  const JointHandle rope = sim.scene().add_joint({at_particle(top.front()), at_particle(*gone), 0.005}, 20.0);
  ASSERT_TRUE(sim.solve_static().converged());
  EXPECT_EQ(sim.report_of(rope).broken, 1);
  EXPECT_LT(sim.max_displacement(), 1e-9);
}

TEST(JointWarnings, ABodyOnJointsIsHeld) {
  const Model block = with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2)), other = moved(block, {0.1, 0, 0});
  const Model both = merged({{"a", &block}, {"b", &other}});
  const auto warnings = [&](bool bed, bool rope) {
    Simulation sim(both, {.backend = "reference"});
    sim.scene().gravity({0, 0, -9.81});
    if (bed) sim.scene().attach(both.group("a/z0"), World{}, {.stiffness = 1e5});
    if (rope) sim.scene().add_joint({at_mean(both.group("b/x0")), at_mean(both.group("a/x1"))}, 5.0);
    return sim.warnings();
  };
  EXPECT_TRUE(says(warnings(false, true).at(0), "nothing holds the body"));
  EXPECT_TRUE(says(warnings(true, false).at(0), "\"b\", 27 particles"));
  EXPECT_TRUE(warnings(true, true).empty());
  Simulation idle(block, {.backend = "reference"});
  idle.scene().fix("z0").attach(block.group("x1"), World{}, {});
  EXPECT_TRUE(says(idle.warnings().at(0), "joint \"joint 1\" has neither stiffness nor damping"));
}

}  // namespace
}  // namespace phymul::test
