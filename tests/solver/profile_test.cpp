// SPDX-License-Identifier: MIT
//
// Solver::profile: counts are exact, times are those of the steps, and nothing is there unless asked for.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <type_traits>

#include "support/bodies.h"
#include "support/every_backend.h"

namespace phymul::test {
namespace {

static_assert(std::is_copy_constructible_v<SolverOptions> && std::is_copy_assignable_v<SolverOptions>);

using ProfileTest = OnEveryBackend;

const PassProfile* find(const std::vector<PassProfile>& passes, std::string_view name) {
  const auto found = std::ranges::find(passes, name, &PassProfile::name);
  return found == passes.end() ? nullptr : &*found;
}

/// Of the backends, the pass that ends every step, and one that only bodies with volumes have.
struct Names {
  const char *step, *volumes;
};
Names names_of(const std::string& backend) {
  if (backend == "reference") return {"move", "forces"};
  if (backend == "cpu") return {"move", "volumes"};
  if (backend == "gl-compute") return {"step_kernel", "terms_kernel"};
  return {"step_pass", "volumes_pass"};
}

double total_seconds(const std::vector<PassProfile>& passes) {
  double sum = 0.0;
  for (const PassProfile& pass : passes) sum += std::isnan(pass.device_seconds) ? pass.seconds : pass.device_seconds;
  return sum;
}

TEST_P(ProfileTest, IsEmptyUnlessAskedFor) {
  const Model model = cylinder_275();
  const Scene scene(model);
  const auto solver = make_solver(GetParam(), model, scene);
  solver->step(3, 0.5 * solver->stable_step());
  EXPECT_TRUE(solver->profile().empty());
  solver->clear_profile();
}

TEST(CpuProfile, ToolsHaveARowWhereThereAreAny) {
  const Model model = cylinder_275();
  Scene scene = Scene(model).fix("bottom");
  const auto solver = make_solver("cpu", model, scene, {}, {.profile = true});
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(5, dt).ok());
  EXPECT_EQ(find(solver->profile(), "tools"), nullptr);
  scene.add_tool("floor", {.shape = HalfSpace{}, .pose = {.position = {0, 0, -1}}});
  ASSERT_TRUE(solver->step(7, dt).ok());
  const std::vector<PassProfile> passes = solver->profile();
  const PassProfile* tools = find(passes, "tools");
  ASSERT_NE(tools, nullptr);
  EXPECT_EQ(tools->runs, 7);
  EXPECT_GT(tools->seconds, 0.0);
  EXPECT_EQ(find(passes, "contacts"), nullptr);
  scene.remove_tool("floor").constrain_volume();
  ASSERT_TRUE(solver->step(3, dt).ok());
  ASSERT_NE(find(solver->profile(), "contacts"), nullptr);
  EXPECT_EQ(find(solver->profile(), "contacts")->runs, 3);
  EXPECT_GT(find(solver->profile(), "contacts")->seconds, 0.0);
  EXPECT_EQ(find(solver->profile(), "tools")->runs, 7);
}

TEST(CpuProfile, ThreadsWaitWhereABodyHasSeveralClusters) {
  const Model model = make_block({0.06, 0.06, 0.06}, 12, 12, 12, 6);
  const Scene scene(model);
  const SolverOptions options{.threads = 2, .profile = true};
  const auto solver = make_solver("cpu", model, scene, {.law = Law::springs}, options);
  ASSERT_TRUE(solver->step(3, 0.1 * solver->stable_step()).ok());
  const std::vector<PassProfile> passes = solver->profile();
  const PassProfile* waiting = find(passes, "waiting");
  ASSERT_NE(waiting, nullptr);
  EXPECT_EQ(waiting->runs, 3);
  EXPECT_GT(waiting->seconds, 0.0);
}

TEST_P(ProfileTest, CountsEveryStepOnce) {
  const Model model = cylinder_275();
  Scene scene = Scene(model).fix("bottom");
  const SolverOptions options{.profile = true};
  const auto solver = make_solver(GetParam(), model, scene, {.law = Law::springs, .volume_stiffness = 50.0}, options);
  EXPECT_TRUE(solver->profile().empty()) << "making a solver is no step";
  const double dt = 0.5 * solver->stable_step();
  int steps = 0;
  for (const int count : {1, 10, 300}) {
    ASSERT_EQ(solver->step(count, dt).steps, count);
    steps += count;
    const auto passes = solver->profile();
    for (const char* name : {names_of(GetParam()).step, names_of(GetParam()).volumes}) {
      const PassProfile* pass = find(passes, name);
      ASSERT_NE(pass, nullptr) << name;
      EXPECT_EQ(pass->runs, steps) << name;
      EXPECT_GT(pass->seconds, 0.0) << name;
    }
    EXPECT_EQ(find(passes, "bases"), nullptr) << "springs have none";
    EXPECT_EQ(find(passes, "bases_pass"), nullptr) << "springs have none";
  }
  solver->clear_profile();
  EXPECT_TRUE(solver->profile().empty());
  solver->step(7, dt);
  const auto passes = solver->profile();
  ASSERT_NE(find(passes, names_of(GetParam()).step), nullptr);
  EXPECT_EQ(find(passes, names_of(GetParam()).step)->runs, 7);
}

/// Enough work that what lies between passes is little of it. A machine may be busy: it takes from the sum too. A GPU
/// is done with a pass before the next is timed; its sum is that of the same steps without a profile.
TEST_P(ProfileTest, TimesAddUpToTheTimeOfTheCall) {
  const Model model = with_material(make_block({0.05, 0.05, 0.05}, 10, 10, 10));
  const Scene scene(model);
  const int steps = GetParam() == "cpu" ? 500 : 20;
  std::vector<PassProfile> passes;
  const auto wall = [&](bool profile) {
    const auto solver = make_solver(GetParam(), model, scene, {}, {.threads = 1, .profile = profile});
    solver->reset(displaced(model, 0.05, 3));
    const double dt = 0.1 * solver->stable_step();
    solver->step(5, dt);
    solver->clear_profile();
    const auto begin = std::chrono::steady_clock::now();
    solver->step(steps, dt);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    passes = solver->profile();
    return seconds;
  };
  const double plain = wall(false), profiled = wall(true);
  const double sum = total_seconds(passes);
  std::printf("[ PROFILE  ] sum %.3g s, wall %.3g s, without a profile %.3g s\n", sum, profiled, plain);
  EXPECT_LE(sum, 1.05 * profiled);
  EXPECT_GE(sum, 0.5 * std::min(plain, profiled));
}

TEST_P(ProfileTest, ChangesNoBit) {
  const Model model = cylinder_275();
  Scene scene = Scene(model).fix("bottom").gravity({0, 0, 9.81});
  const auto plain = make_solver(GetParam(), model, scene);
  const auto profiled = make_solver(GetParam(), model, scene, {}, {.profile = true});
  const double dt = 0.5 * plain->stable_step();
  plain->step(50, dt);
  profiled->step(50, dt);
  EXPECT_EQ(profiled->read(), plain->read());
}

PHYMUL_ON_EVERY_BACKEND(ProfileTest);

TEST(Profile, EveryKernelOfTheVectorBackendHasItsRow) {
  const Model lattice = make_block({0.06, 0.06, 0.06}, 6, 6, 6, 6);
  const Model solid = with_material(lattice);
  struct Case {
    const Model& model;
    TopologyOptions options;
    const char* row;
  };
  const Case cases[] = {
      {lattice, {.reaction = Reaction::shared, .bases = BaseSelection::all}, "enumerated bases"},
      {lattice, {.on_sparse = SparseParticle::free}, "bases"},
      {lattice, {.law = Law::springs}, "springs"},
      {solid, {}, "averaged stresses"},
  };
  for (const Case& of : cases) {
    SCOPED_TRACE(of.row);
    const Scene scene(of.model);
    const SolverOptions options{.on_unstable = UnstableStep::allow, .threads = 2, .profile = true};
    const auto solver = make_solver("cpu", of.model, scene, of.options, options);
    solver->step(3, 0.1 * solver->stable_step());
    const auto passes = solver->profile();
    const PassProfile* pass = find(passes, of.row);
    ASSERT_NE(pass, nullptr);
    EXPECT_EQ(pass->runs, 3);
    EXPECT_TRUE(std::isnan(pass->device_seconds));
  }
}

}  // namespace
}  // namespace phymul::test
