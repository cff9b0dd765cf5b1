// SPDX-License-Identifier: MIT
//
// Simulation: back to earlier states, from memory, files, the history and recordings. Bit for bit.
#include <gtest/gtest.h>

#include <filesystem>

#include "support/bodies.h"

namespace phymul::test {
namespace {

class SimulationSnapshot : public ::testing::TestWithParam<const char*> {
 protected:
  Simulation hanging() const {
    Simulation sim(cylinder_275(),
                   {.material = {.young = 5e3, .poisson = 0.45, .density = 1000}, .backend = GetParam()});
    sim.scene().fix("bottom").gravity({9.81, 0, 0});
    return sim;
  }
};

TEST_P(SimulationSnapshot, RestoreSaveAndLoad) {
  Simulation sim = hanging();
  ASSERT_TRUE(sim.advance(0.02).ok());
  const Snapshot early = sim.snapshot();
  const std::string path =
      (std::filesystem::temp_directory_path() / (std::string("phymul_simulation_") + GetParam())).string();
  sim.save(path);
  ASSERT_TRUE(sim.advance(0.02).ok());
  const Snapshot late = sim.snapshot();
  sim.restore(early);
  EXPECT_EQ(sim.snapshot(), early);
  ASSERT_TRUE(sim.advance(0.02).ok());
  EXPECT_EQ(sim.snapshot(), late);

  Simulation other = hanging();
  other.load(path);
  std::filesystem::remove(path);
  EXPECT_EQ(other.snapshot(), early);
  ASSERT_TRUE(other.advance(0.02).ok());
  EXPECT_EQ(other.snapshot(), late);
  EXPECT_THROW(other.load(path), Error);
  EXPECT_EQ(other.snapshot(), late);
}

TEST_P(SimulationSnapshot, Rewind) {
  Simulation sim = hanging();
  sim.keep_history(10);
  ASSERT_TRUE(sim.advance(0.02).ok());
  const Snapshot early = sim.snapshot();
  sim.keep_history(10);
  ASSERT_TRUE(sim.advance(0.02).ok());
  ASSERT_TRUE(sim.advance(0.02).ok());
  ASSERT_TRUE(sim.rewind(early.state.time));
  EXPECT_EQ(sim.snapshot(), early);
  EXPECT_FALSE(sim.rewind(0.01));
}

TEST_P(SimulationSnapshot, ReplaysWhatWasDone) {
  Simulation sim = hanging();
  sim.record();
  ASSERT_TRUE(sim.advance(0.02).ok());
  const State state = sim.state();
  sim.scene().gravity({0, 9.81, 0});
  const ToolHandle ball = sim.scene().add_tool({.shape = Sphere{0.005}, .pose = {.position = {0, 0, 0.05}}});
  ASSERT_TRUE(sim.advance(0.02).ok());
  ball.move_to({.position = {0, 0, 0.043}});
  ASSERT_TRUE(sim.advance(0.02).ok());
  sim.scene().remove_tool(sim.scene().tools().front().name);
  sim.set_state(state);
  sim.keep_history(5);
  ASSERT_TRUE(sim.advance(0.03).ok());
  ASSERT_TRUE(sim.rewind(state.time + 0.01));
  sim.run_to_rest(500);
  const Snapshot end = sim.snapshot();
  const Recording recording = sim.recording();

  Simulation again = hanging();
  again.replay(recording);
  EXPECT_EQ(again.snapshot(), end);
  sim.replay(recording);
  EXPECT_EQ(sim.snapshot(), end);
  EXPECT_THROW(sim.recording(), Error);
}

INSTANTIATE_TEST_SUITE_P(Backends, SimulationSnapshot, ::testing::Values("reference", "cpu"));

}  // namespace
}  // namespace phymul::test
