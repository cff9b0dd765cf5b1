// SPDX-License-Identifier: MIT
//
// Contacts on the GL backends (on "gl" by the host) in what batches, devices and scenes do: the same bits at every
// run, nothing paid by a scene without them.

#include <array>

#include "support/gl_block.h"
#include "support/gl_touching_bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

class GlContactRuns : public OnBothDevices {};

PHYMUL_ON_BOTH_DEVICES(GlContactRuns);

using GlComputeContacts = OnCompute;

/// Atomic counts come in any order, results do not.
TEST_P(GlContactRuns, RunsGiveTheSameBits) {
  const Model model = stacked(0.0005);
  std::vector<State> ends;
  for (const int calls : {1, 1, 6}) {
    Scene scene = Scene(model).gravity({1, 0, -9.81}).fix("low/z0").contacts({});
    const BesideReference pair(model, scene, damped(5.0), GetParam());
    for (int k = 0; k < calls; ++k) ASSERT_TRUE(pair.device->step(60 / calls, pair.dt).ok());
    ends.push_back(pair.device->read());
    ends.back().time = 0.0;
  }
  EXPECT_EQ(difference(ends[0], ends[1]), "");
  EXPECT_EQ(difference(ends[0], ends[2]), "");
}

/// A batch that ends before its last step is done again up to there.
TEST_P(GlContactRuns, BatchesDoneAgainComeToTheSame) {
  const Model model = stacked(0.0003);
  Scene scene = Scene(model).gravity({0, 0, -1}).fix("low/z0").contacts({.friction = 0.5});
  SolverOptions options = damped(100.0);
  options.rest_tolerance = 1e-3;
  const BesideReference pair(model, scene, options, GetParam());
  const RestResult rest = pair.device->run_to_rest(2000, pair.dt);
  ASSERT_TRUE(rest.converged()) << rest.message();
  const State rested = pair.device->read();
  pair.device->reset();
  ASSERT_TRUE(pair.device->step(rest.report.steps, pair.dt).ok());
  EXPECT_EQ(difference(pair.device->read(), rested), "");
  EXPECT_GT(lowest(rested, model.group("high")), 0.0095);

  Scene failing = Scene(model).gravity({0, 0, -10}).fix("low/z0").contacts({});
  SolverOptions beyond = damped(0.0);
  beyond.on_unstable = UnstableStep::allow;
  const BesideReference undamped(model, failing, beyond, GetParam());
  const StepReport failed = undamped.device->step(250, 8.0 * undamped.dt);
  ASSERT_EQ(failed.status, StepStatus::not_finite);
  ASSERT_GT(failed.steps, 3);
  const State kept = undamped.device->read();
  undamped.device->reset();
  ASSERT_TRUE(undamped.device->step(failed.steps, 8.0 * undamped.dt).ok());
  EXPECT_EQ(difference(undamped.device->read(), kept), "");
}

/// A body alone, bodies far from each other, one without a surface: as without contacts, to the last bit.
TEST_P(GlContactRuns, WhatTouchesNothingMovesAsItWould) {
  const Model particles = without_cells(make_block({0.02, 0.02, 0.02}, 4, 4, 4));
  for (const Model& model : {tissue({0, 0, 0}, {3, 2, 2}), stacked(4.0), particles}) {
    State end[2];
    for (const bool touching : {false, true}) {
      Scene scene = Scene(model).gravity({0.5, 0, 0});
      if (touching) scene.contacts({});
      const BesideReference pair(model, scene, damped(5.0), GetParam());
      pair.device->reset(random_state(model, 0.02, 0.01, 3));
      ASSERT_TRUE(pair.device->step(20, pair.dt).ok());
      end[touching] = pair.device->read();
    }
    EXPECT_EQ(difference(end[1], end[0]), "");
  }
}

TEST_P(GlContactRuns, ASceneWithoutContactsPaysNothing) {
  const Model model = stacked(0.001);
  Scene without = Scene(model).fix("low/z0"), with = without.copy().contacts({});
  SolverOptions options = damped(5.0);
  options.profile = true;
  const BesideReference plain(model, without, options, GetParam()), touching(model, with, options, GetParam());
  ASSERT_TRUE(all_step(8, plain.dt, plain.device, touching.device));
  const auto runs = runs_of(*plain.device), more = runs_of(*touching.device);
  for (const auto& [name, count] : runs) {
    EXPECT_EQ(name.find("contact"), std::string::npos) << name;
    EXPECT_EQ(name.find("free_"), std::string::npos) << name;
  }
  const bool draws = GetParam() == GlBackend::fragment;
  for (const char* pass : draws ? std::array{"free_pass", "gather_pass", "step_pass"}
                                : std::array{"free_kernel", "contact_search_kernel", "contact_part_kernel"}) {
    const auto found = std::ranges::find(more, pass, &std::pair<std::string, std::int64_t>::first);
    ASSERT_NE(found, more.end()) << pass;
    EXPECT_GE(found->second, 8) << pass;
    EXPECT_LE(found->second, draws ? 10 : 8) << pass;
  }
  // The one whose contacts went does what the other does, and gives its bits.
  with.no_contacts();
  expect_alike(*touching.device, *plain.device, plain.dt);
}

/// Bodies a kilometre apart are beyond the cells that floats tell apart.
TEST_F(GlComputeContacts, RefuseBodiesTooFarApart) {
  const Model model = stacked(1000.0);
  Scene scene = Scene(model).contacts({});
  EXPECT_TRUE(refuses([&] { make_solver("gl-compute", model, scene); }, "bring the bodies nearer to each other"));
}

}  // namespace
}  // namespace phymul::test
