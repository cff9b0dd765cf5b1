// SPDX-License-Identifier: MIT
//
// Simulation: ownership, steps of advance(), velocities of state(), tools, bodies.
#include <gtest/gtest.h>

#include <type_traits>
#include <utility>

#include "support/bodies.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

// Mistakes of lifetime that the compiler finds.
template <class SceneArgument>
concept MakesSolver = requires(const Model& model, SceneArgument&& scene) {
  make_solver("cpu", model, std::forward<SceneArgument>(scene));
};
template <class SceneArgument>
concept MakesSolverOverTables = requires(std::shared_ptr<const TopologyTextures> tables, SceneArgument&& scene) {
  make_solver("cpu", tables, std::forward<SceneArgument>(scene));
};
static_assert(std::is_constructible_v<Scene, const Model&>);
static_assert(!std::is_constructible_v<Scene, Model>, "the model is a temporary");
static_assert(!std::is_convertible_v<const Model&, Scene>);
static_assert(MakesSolver<const Scene&> && MakesSolverOverTables<const Scene&>);
static_assert(!MakesSolver<Scene> && !MakesSolverOverTables<Scene>, "the scene is a temporary");
static_assert(!std::is_copy_assignable_v<Scene> && !std::is_move_assignable_v<Scene>);
static_assert(!std::is_copy_constructible_v<Solver> && !std::is_move_constructible_v<Solver>);
static_assert(!std::is_copy_constructible_v<Simulation> && !std::is_copy_assignable_v<Simulation>);
static_assert(std::is_nothrow_move_constructible_v<Simulation> && std::is_nothrow_move_assignable_v<Simulation>);

constexpr Material soft{.young = 10e3, .poisson = 0.3, .density = 1000};

Simulation block_with_floor(const std::string& backend) {
  Simulation sim(make_block({0.04, 0.04, 0.04}, 4, 4, 4), {.material = soft, .backend = backend});
  sim.scene().gravity({0, 0, -9.81});
  return sim;
}

TEST(Simulation, HandlesAndReferencesOutliveAMove) {
  Simulation sim = block_with_floor("cpu");
  const Model& model = sim.model();
  Scene& scene = sim.scene();
  const ToolHandle floor = scene.add_tool(HalfSpace{});
  ASSERT_TRUE(sim.advance(0.01).ok());
  const Solver& solver = sim.solver();
  Simulation moved_to = std::move(sim);
  EXPECT_EQ(&moved_to.model(), &model);
  EXPECT_EQ(&moved_to.scene(), &scene);
  EXPECT_EQ(&moved_to.solver(), &solver);
  floor.move_to({.position = {0, 0, 0.001}});
  ASSERT_TRUE(moved_to.advance(0.01).ok());
  EXPECT_NEAR(moved_to.pose_of(floor).position.z(), 0.001, 1e-7);
  EXPECT_LT(moved_to.force_on(floor).mean_force.z(), 0.0);
  Simulation other = block_with_floor("cpu");
  other = std::move(moved_to);
  EXPECT_EQ(&other.solver(), &solver);
  EXPECT_TRUE(other.advance(0.01).ok());
}

TEST(Simulation, AdvanceTakesEqualStepsWithinTheLimit) {
  Simulation sim(make_block({0.04, 0.04, 0.04}, 4, 4, 4), {.material = soft, .backend = "cpu", .step = 0.4});
  const double limit = sim.step_limit();
  EXPECT_DOUBLE_EQ(limit, 0.4 * sim.solver().stable_step());
  const StepReport two_and_a_half = sim.advance(2.5 * limit);
  EXPECT_EQ(two_and_a_half.steps, 3);
  EXPECT_DOUBLE_EQ(two_and_a_half.dt, 2.5 * limit / 3.0);
  EXPECT_EQ(sim.advance(3.0 * limit).steps, 3);
  EXPECT_EQ(sim.advance(0.01 * limit).steps, 1);
  const double time = sim.time();
  EXPECT_EQ(sim.advance(0.0).steps, 0);
  EXPECT_EQ(sim.time(), time);
  for (const double seconds : {-1.0, std::nan(""), HUGE_VAL, 1e300}) {
    const StepReport refused = sim.advance(seconds);
    EXPECT_FALSE(refused.ok()) << seconds;
    EXPECT_EQ(refused.steps, 0);
    EXPECT_FALSE(refused.message().empty());
  }
  EXPECT_EQ(sim.time(), time);
}

/// Two equal masses on a spring: each swings about its rest place with w^2 = 2 k / m.
Model oscillator() {
  Model model;
  model.rest = {{0, 0, 0}, {0.01, 0, 0}};
  model.mass = {0.002, 0.002};
  model.stiffness = {5.0, 5.0};
  for (Index other : {1, 0}) model.neighbours.push_row(&other, &other + 1);
  return model;
}

/// Largest error of the velocity over a w, in two periods looked at forty times.
double velocity_error(double step) {
  Simulation sim(oscillator(), {.backend = "reference", .step = step, .topology = {.law = Law::springs}});
  const double omega = std::sqrt(2.0 * 5.0 / 0.002), stretch = 0.001;
  State start = rest_state(sim.model());
  // Both move, against each other, about a centre that stays.
  start.position[0].x() -= stretch;
  start.position[1].x() += stretch;
  start.velocity = {{-0.5 * stretch * omega, 0, 0}, {0.5 * stretch * omega, 0, 0}};
  sim.set_state(start);
  EXPECT_EQ(sim.state().velocity, start.velocity);
  double worst = 0.0;
  for (int k = 1; k <= 40; ++k) {
    EXPECT_TRUE(sim.advance(0.1 * 3.14159265358979 / omega).ok());
    const State now = sim.state();
    const double wt = omega * now.time;
    const double expected = stretch * omega * (0.5 * std::cos(wt) - std::sin(wt));
    worst = std::max(worst, std::abs(now.velocity[1].x() - expected) / (stretch * omega));
  }
  return worst;
}

TEST(Simulation, VelocitiesAreOfTheStatesTime) {
  const double coarse = velocity_error(0.2), middle = velocity_error(0.1), fine = velocity_error(0.05);
  EXPECT_LT(coarse, 0.1);
  EXPECT_NEAR(coarse / middle, 4.0, 0.8);  // second order
  EXPECT_NEAR(middle / fine, 4.0, 0.8);
}

TEST(Simulation, StateAndSetStateAreInverse) {
  SimulationOptions options{.material = soft, .backend = "reference", .damping = {.rate = 5}};
  Simulation sim(make_block({0.04, 0.03, 0.03}, 4, 3, 3), options);
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  ASSERT_TRUE(sim.advance(0.05).ok());
  const State there = sim.state();
  EXPECT_GT((there.velocity[12] - sim.solver().read().velocity[12]).norm(), 0.0);
  ASSERT_TRUE(sim.advance(0.05).ok());
  const State later = sim.state();
  sim.set_state(there);
  EXPECT_EQ(sim.state(), there);
  ASSERT_TRUE(sim.advance(0.05).ok());
  const State again = sim.state();
  EXPECT_DOUBLE_EQ(again.time, later.time);
  for (std::size_t i = 0; i < later.position.size(); ++i) {
    EXPECT_LE((again.position[i] - later.position[i]).norm(), 1e-12);
    EXPECT_LE((again.velocity[i] - later.velocity[i]).norm(), 1e-10);
  }
}

TEST(Simulation, StateAfterTheSolverWasSetDirectly) {
  Simulation sim(make_block({0.04, 0.03, 0.03}, 4, 3, 3), {.material = soft, .backend = "reference"});
  State other = rest_state(sim.model());
  other.velocity.assign(other.velocity.size(), Vec3(0.1, 0, 0));
  sim.unrecorded_solver().reset(other);
  EXPECT_EQ(sim.state().velocity, other.velocity);
  ASSERT_TRUE(sim.advance(0.01).ok());
  EXPECT_NEAR(sim.state().position[3].x() - sim.model().rest[3].x(), 0.001, 1e-9);
}

TEST(Simulation, ToolsToldBeforeTheFirstStepAreHeard) {
  Simulation sim(make_block({0.04, 0.04, 0.04}, 4, 4, 4), {.material = soft, .backend = "cpu"});
  sim.scene().fix("z0");
  const ToolHandle gripper = sim.scene().add_tool({.shape = Sphere{0.01}, .pose = {.position = {0.02, 0.02, 0.05}}});
  gripper.grasp(0.002);
  ASSERT_TRUE(sim.advance(0.001).ok());
  EXPECT_GT(sim.solver().held(gripper), 0);
}

TEST(Simulation, MaterialsOfGroups) {
  Model model = make_block({0.04, 0.04, 0.04}, 4, 4, 4);
  model.add_group("half", model.particles_in([](const Vec3& X) { return X.x() < 0.021; }));
  const Material stiff{.young = 50e3, .poisson = 0.4, .density = 1200};
  const Simulation sim(model, {.material = soft, .materials = {{"half", stiff}}});
  set_material(model, soft);
  set_material(model, stiff, "half");
  EXPECT_EQ(sim.model(), model);
  EXPECT_EQ(Simulation(model).model(), model);
}

TEST(Simulation, TwoBodiesTouch) {
  const Model organ = make_block({0.03, 0.03, 0.02}, 3, 3, 2);
  const Material stiff{.young = 50e3, .poisson = 0.4, .density = 1200};
  Simulation sim({{"low", organ, stiff}, {"high", moved(organ, {0, 0, 0.022}), {}}}, {.material = soft});
  EXPECT_EQ(sim.model().materials.size(), 2U);
  sim.scene().fix("low/z0").gravity({0, 0, -9.81}).contacts({.friction = 0.4, .self = false});
  const RestResult rest = sim.run_to_rest();
  EXPECT_TRUE(rest.converged()) << rest.message();
  EXPECT_LT(sim.max_displacement(), 0.005);
  const State state = sim.state();
  for (const Index i : sim.model().group("high")) EXPECT_GT(state.position[i].z(), 0.019);
}

TEST(Simulation, RefusesWhatMakesNoSense) {
  const Model model = make_block({0.04, 0.04, 0.04}, 4, 4, 4);
  for (const double step : {0.0, -0.5, HUGE_VAL, std::nan("")}) {
    EXPECT_THROW(Simulation(model, {.material = soft, .step = step}), Error) << step;
  }
  for (const Damping damping : {Damping{.rate = -1.0}, Damping{.factor = 1.5}}) {
    EXPECT_THROW(Simulation(model, {.material = soft, .damping = damping}), Error);
  }
  EXPECT_THROW(Simulation(model, {.material = soft, .solver = {.rest_tolerance = -1.0}}), Error);
  EXPECT_THROW(Simulation(model, {.material = soft, .solver = {.max_substeps = 0}}), Error);
  EXPECT_THROW(Simulation(model, {.material = {.young = -1.0, .poisson = 0.3, .density = 1000}}), Error);
  EXPECT_THROW(Simulation(model, {.material = soft, .materials = {{"nowhere", soft}}}), Error);
  EXPECT_THROW(Simulation(std::vector<SimulationBody>{}), Error);
  Simulation unknown(model, {.material = soft, .backend = "abacus"});
  EXPECT_THROW(unknown.advance(0.1), Error);
  EXPECT_NO_THROW(unknown.scene().fix("x0"));
  Simulation none(model, {.material = soft, .make_solver = [](auto&&...) { return nullptr; }});
  EXPECT_THROW(none.solver(), Error);
  Simulation sim(model, {.material = soft});
  EXPECT_THROW(sim.recording(), Error);
  EXPECT_THROW(sim.keep_history(0), Error);
  EXPECT_FALSE(sim.rewind(1.0));
}

TEST(Simulation, TakesASolverOfOnesOwn) {
  int made = 0;
  SimulationOptions options{.material = soft};
  options.make_solver = [&](auto topology, const Scene& scene, const SolverOptions& solver_options) {
    ++made;
    return make_solver("reference", topology, scene, solver_options);
  };
  Simulation sim(make_block({0.04, 0.04, 0.04}, 4, 4, 4), options);
  EXPECT_EQ(made, 0);
  EXPECT_TRUE(sim.advance(0.01).ok());
  EXPECT_EQ(made, 1);
  EXPECT_EQ(sim.solver().name(), "reference");
}

// Velocities of Simulation::state() where tools, contacts and volume constraints act in the step.

constexpr Material tissue_of_organs{.young = 10e3, .poisson = 0.3, .density = 1000};

class VelocityOfStateOn : public WithTools {
 protected:
  static Simulation pressed(ToolContact contact) {
    Simulation sim(make_block({0.04, 0.04, 0.04}, 4, 4, 4),
                   {.material = tissue_of_organs, .backend = GetParam(), .damping = {.rate = 100.0}, .step = 0.5});
    sim.scene().fix("z0").add_tool(
        "plate", {.shape = Box{{0.03, 0.03, 0.01}}, .pose = {.position = {0.02, 0.02, 0.05}}, .contact = contact});
    return sim;
  }
  static void move_down(Simulation& sim, double by) {
    const Vec3 place = sim.pose_of(sim.scene().tool("plate")).position;
    sim.scene().tool("plate").move_to({.position = place - Vec3(0, 0, by)});
    ASSERT_TRUE(sim.advance(1e-3).ok());
  }
};
PHYMUL_ON_EVERY_BACKEND(VelocityOfStateOn);

TEST_P(VelocityOfStateOn, IsThatOfAToolWhichPresses) {
  for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
    Simulation sim = pressed(contact);
    for (int k = 0; k < 40; ++k) move_down(sim, 1e-4);
    const VecList moving = sim.state().velocity;
    for (const Index i : sim.model().group("z1")) EXPECT_NEAR(moving[i].z(), -0.1, 2e-3);
    for (int k = 0; k < 400; ++k) move_down(sim, 0.0);
    EXPECT_GT(sim.force_on(sim.scene().tool("plate")).force.norm(), 0.5);
    EXPECT_LT(largest_norm(sim.state().velocity), 1e-4);
  }
}

TEST_P(VelocityOfStateOn, IsZeroOfWhatContactsAndConstraintsHold) {
  for (const bool touches : {true, false}) {
    const Model low = make_block({0.03, 0.03, 0.01}, 5, 5, 2), cube = make_block({0.01, 0.01, 0.01}, 2, 2, 2);
    const Model high = moved(cube, {0.0072, 0.0081, 0.0111});
    Simulation sim(merged({{"low", &low}, {"high", &high}}),
                   {.material = tissue_of_organs, .backend = GetParam(), .damping = {.rate = 100.0}, .step = 0.5});
    sim.scene().fix("low/z0").gravity({0, 0, -9.81});
    if (touches) sim.scene().contacts({});
    if (!touches) sim.scene().fix("high/z0").constrain_volume("high");
    ASSERT_TRUE(sim.advance(0.8).ok());
    ASSERT_LT(largest_norm(sim.solver().read().velocity), 1e-4);
    EXPECT_LT(largest_norm(sim.state().velocity), 1e-4);
    const VecList before = sim.solver().read().velocity;
    sim.set_state(sim.state());
    EXPECT_LT(largest_distance(sim.solver().read().velocity, before), 1e-4);
  }
}

}  // namespace
}  // namespace phymul::test
