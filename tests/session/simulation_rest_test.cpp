// SPDX-License-Identifier: MIT
//
// Simulation::run_to_rest: the damping it chooses, and that it leads where a damping given by the user does.
#include <phymul/phymul.h>

#include <gtest/gtest.h>
#include <cmath>
#include <functional>

#include "support/bodies.h"
#include "support/message_of.h"
#include "support/run_scenes.h"
#include "support/wall_cases.h"

namespace phymul::test {
namespace {

constexpr Material beam_material{.young = 10e3, .poisson = 0.3, .density = 1000};

Simulation beam(const std::string& backend, const Damping& damping = {}, const SolverOptions& solver = {}) {
  Simulation sim(make_block({0.2, 0.05, 0.05}, 8, 2, 2),
                 {.material = beam_material, .backend = backend, .damping = damping, .solver = solver});
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  return sim;
}

/// m: how far a body may be from equilibrium that passes the rest test. A net force per mass of
/// tolerance h omega_max^2 shifts a mode of frequency omega by tolerance h (omega_max / omega)^2.
double shift_at_rest(Simulation& sim, double tolerance, double slowest) {
  const double omega_max = 2.0 / sim.solver().stable_step();
  return tolerance * mean_spacing(sim.model()) * std::pow(omega_max / slowest, 2);
}

TEST(SimulationRest, SagsAsWithADampingOfTheUser) {
  Simulation own = beam("reference"), given = beam("reference", {.rate = 20});
  const RestResult rest = own.run_to_rest(), expected = given.run_to_rest();
  ASSERT_TRUE(rest.converged()) << rest.message();
  ASSERT_TRUE(expected.converged()) << expected.message();
  EXPECT_LT(rest.report.steps, expected.report.steps);
  EXPECT_LT(rest.report.time, 5.0);  // s; the beam swings with a period of 0.75 s
  EXPECT_NEAR(own.max_displacement(), given.max_displacement(), 2.0 * shift_at_rest(own, 1e-8, 8.3));
}

TEST(SimulationRest, AgreesInSinglePrecision) {
  Simulation single = beam("cpu"), exact = beam("reference");
  ASSERT_TRUE(single.run_to_rest().converged());
  ASSERT_TRUE(exact.run_to_rest().converged());
  // Of the largest displacement, as SolverOptions::rest_tolerance says; one beam rests this much short of it.
  EXPECT_NEAR(single.max_displacement(), exact.max_displacement(), 5e-4 * exact.max_displacement());
}

/// Stiffness, shape and load change the slowest vibration from 11 to 57 rad/s.
TEST(SimulationRest, FindsTheDampingOfAnyBody) {
  struct Case {
    const char* name;
    Model model;
    Material material;
    const char* held;
  };
  const std::vector<Case> cases{
      {"slender", make_block({0.3, 0.02, 0.02}, 30, 2, 2), {.young = 1e6, .poisson = 0.3, .density = 1000}, "x0"},
      {"stiff", make_block({0.2, 0.05, 0.05}, 8, 2, 2), {.young = 1e6, .poisson = 0.3, .density = 1000}, "x0"},
      {"cylinder", cylinder_275(), {.young = 5e3, .poisson = 0.45, .density = 1000}, "bottom"},
      {"cube", make_block({0.1, 0.1, 0.1}, 6, 6, 6), {.young = 10e3, .poisson = 0.45, .density = 1000}, "z0"},
  };
  for (const Case& c : cases) {
    Simulation sim(c.model, {.material = c.material, .backend = "cpu"});
    sim.scene().fix(c.held).gravity({0, 0, -9.81});
    const RestResult rest = sim.run_to_rest(20'000);
    EXPECT_TRUE(rest.converged()) << c.name << ": " << rest.message();
    EXPECT_EQ(rest.report.steps, std::lround(rest.report.time / (0.5 * sim.solver().stable_step()))) << c.name;
  }
}

/// The damping of the first steps, by how a free body falls; a material that dissipates vibrates no faster.
TEST(SimulationRest, FirstGuessesByTheElasticVibrations) {
  for (const auto& [retardation, strength] : {std::pair(0.0, 0.0), std::pair(5e-3, 0.0), std::pair(1e-3, 0.5)}) {
    SCOPED_TRACE(retardation);
    Material material = beam_material;
    material.retardation_time = retardation;
    material.relaxation_strength = strength;
    material.relaxation_time = 0.1;
    Simulation sim(make_block({0.08, 0.02, 0.02}, 8, 2, 2), {.material = material, .backend = "reference"});
    sim.scene().gravity({0, 0, -9.81});
    const TopologyTextures& tables = sim.solver().topology();
    const double omega_max = std::sqrt(estimate_spectrum(tables, tables.rest).largest);
    const double rate = omega_max * mean_spacing(sim.model()) / body_size(sim.model());
    const int steps = 8;
    const double dt = 0.5 * sim.solver().stable_step(), factor = std::exp(-rate * dt);
    EXPECT_EQ(sim.run_to_rest(steps).report.steps, steps);
    // From rest, which is half a step of gravity upward half a step earlier.
    const double kept = std::pow(factor, steps);
    const double speed = 9.81 * dt * ((1.0 - kept) / (1.0 - factor) - 0.5 * kept);
    EXPECT_NEAR(sim.solver().read().velocity[0].z(), -speed, 1e-6 * speed);
  }
}

TEST(SimulationRest, FallsOnAFloorAndRestsThere) {
  Simulation sim(make_block({0.04, 0.04, 0.04}, 4, 4, 4), {.material = beam_material, .backend = "cpu"});
  sim.scene().gravity({0, 0, -9.81});
  const ToolHandle floor = sim.scene().add_tool({.shape = HalfSpace{}, .pose = {.position = {0, 0, -0.01}}});
  const RestResult rest = sim.run_to_rest();
  EXPECT_TRUE(rest.converged()) << rest.message();
  const double weight = 0.04 * 0.04 * 0.04 * 1000 * 9.81;
  EXPECT_NEAR(sim.force_on(floor).force.z(), -weight, 0.02 * weight);
}

TEST(SimulationRest, SaysWhereItDidNotCome) {
  Simulation sim = beam("cpu");
  const RestResult few = sim.run_to_rest(100);
  EXPECT_FALSE(few.converged());
  EXPECT_EQ(few.status, RestStatus::step_limit);
  EXPECT_EQ(few.report.steps, 100);
  EXPECT_EQ(sim.run_to_rest(0).status, RestStatus::step_limit);
  EXPECT_EQ(sim.run_to_rest(-1).status, RestStatus::failed);

  Simulation falling(make_block({0.04, 0.04, 0.04}, 4, 4, 4), {.material = beam_material, .backend = "cpu"});
  falling.scene().gravity({0, 0, -9.81});
  EXPECT_EQ(falling.run_to_rest(2000).status, RestStatus::step_limit);
}

TEST(SimulationRest, TellsItsProgressAsOneCall) {
  int calls = 0, last = 0;
  bool in_order = true, whole = true;
  SolverOptions options;
  options.progress_seconds = 0.0;
  options.progress = [&](const StepProgress& progress) {
    ++calls;
    in_order = in_order && progress.steps == last + 1;
    whole = whole && progress.of == 400;
    last = progress.steps;
    return progress.steps < 300;
  };
  Simulation sim = beam("cpu", {}, options);
  const RestResult rest = sim.run_to_rest(400);
  EXPECT_EQ(rest.status, RestStatus::stopped);
  EXPECT_EQ(rest.report.steps, 300);
  EXPECT_EQ(calls, 300);
  EXPECT_TRUE(in_order && whole);
}

/// What moves away is not told to be damped more, or run longer.
TEST(SimulationRest, SaysFirstThatNothingHoldsTheBody) {
  const auto rest_of = [](const std::function<void(Scene&)>& change) {
    Simulation sim(make_block({0.04, 0.02, 0.02}, 4, 2, 2), {.material = beam_material, .backend = "cpu"});
    change(sim.scene());
    return sim.run_to_rest(20);
  };
  const auto fall = [](Scene& scene) { scene.gravity({0, 0, -9.81}); };
  const RestResult free = rest_of(fall);
  EXPECT_EQ(free.loose, 0);
  EXPECT_TRUE(
      free.message().starts_with("nothing holds the part of particle 0: it moves away unless its loads balance"))
      << free.message();
  EXPECT_TRUE(says(free.message(), "not at rest after 20 steps"));
  for (const auto& hold : std::vector<std::function<void(Scene&)>>{[](Scene& scene) { scene.fix("x0"); },
                                                                   [](Scene& scene) { scene.add_tool(HalfSpace{}); }}) {
    const RestResult held = rest_of([&](Scene& scene) {
      fall(scene);
      hold(scene);
    });
    EXPECT_EQ(held.loose, -1);
    EXPECT_TRUE(held.message().starts_with("not at rest after")) << held.message();
  }
  EXPECT_EQ(rest_of([](Scene& scene) {
              scene.add({.particles = {3}, .events = {{0, 1}}, .direction = {1, 0, 0}});
            }).loose,
            0);
  EXPECT_EQ(rest_of([](Scene&) {}).loose, -1) << "it floats";
}

TEST(SimulationRest, KnowsWhatHoldsTheBody) {
  const Model model = with_material(make_block({0.04, 0.02, 0.02}, 4, 2, 2), beam_material);
  const auto loose_with = [&](Load load) {
    load.particles = model.group("x0");
    load.events = {{0, 0}};
    load.direction = {1, 0, 0};
    Simulation sim(model, {.backend = "cpu"});
    sim.scene().gravity({0, 0, -9.81}).add(load);
    const bool warns = std::ranges::any_of(sim.warnings(), [](const std::string& w) { return says(w, "holds"); });
    const Index loose = sim.run_to_rest(20).loose;
    EXPECT_EQ(warns, loose >= 0);
    return loose;
  };
  EXPECT_EQ(loose_with({.type = LoadType::rotation}), -1);
  EXPECT_EQ(loose_with({.type = LoadType::translation, .axes = {Axis::free, Axis::free, Axis::held}}), -1);
  EXPECT_EQ(loose_with({.type = LoadType::translation, .axes = {Axis::free, Axis::free, Axis::free}}), 0);

  Simulation torn(model, {.backend = "cpu"});
  torn.scene().gravity({0, 0, -9.81}).attach(model.group("x0"), World{}, {.stiffness = 1e6, .breaking_stress = 10.0});
  EXPECT_EQ(torn.run_to_rest(1).loose, -1);
  const Snapshot whole = torn.snapshot();
  ASSERT_EQ(torn.run_to_rest(1000).report.springs_broken, 9);
  EXPECT_EQ(torn.run_to_rest(1).loose, 0);
  torn.restore(whole);
  EXPECT_EQ(torn.run_to_rest(1).loose, -1);
}

/// At the rim of a clamp a strongly bent beam folds a cell: the result says where, on the way to rest and there.
TEST(SimulationRest, NamesTheCellThatIsFolded) {
  Simulation sim(make_tetrahedral_block({0.2, 0.05, 0.05}, 16, 4, 4, 0.2, 1),
                 {.material = {.young = 10e3, .poisson = 0.45, .density = 1000}, .backend = "cpu"});
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  const RestResult before = sim.run_to_rest(800);
  EXPECT_EQ(before.status, RestStatus::step_limit);
  EXPECT_TRUE(says(before.message(), "m at rest, is flat or inside out: it can keep its particles moving"));
  const RestResult rest = sim.run_to_rest(10'000);
  EXPECT_TRUE(rest.converged()) << rest.message();
  ASSERT_GE(rest.folded, 0);
  EXPECT_LT(rest.folded_at.x(), 0.02);  // at the clamp
  EXPECT_TRUE(says(rest.message(), "the body rests folded"));
}

// Simulation::solve_static of walls: closed forms, and the rest shape that steps reach.

/// A plate on a hinge under pressure: w = (5 + nu) / (1 + nu) p a^4 / (64 D).
TEST(WallRest, PlateBendsAsItsClosedForm) {
  constexpr double E = 1e6, nu = 0.3, t = 1e-3, a = 0.1, p = 1e-3, D = E * t * t * t / 12.0 / (1.0 - nu * nu);
  const Model model = wall_of(disc_surface(a, 10, 0.2), E, nu, t);
  Simulation sim(model);
  sim.scene().fix(model.particles_in([](const Vec3& X) { return X.norm() > a * (1.0 - 1e-9); }));
  Load pressure;
  pressure.type = LoadType::pressure;
  pressure.particles = every_particle(model);
  pressure.direction = {0, 0, 1};
  pressure.events = {{0.0, p}};
  sim.scene().add(pressure);
  const StaticResult result = sim.solve_static();
  ASSERT_TRUE(result.converged()) << result.message();
  EXPECT_LT(result.evaluations, 20);
  EXPECT_NEAR(sim.state().position[0].z(), p * a * a * a * a / (64.0 * D) * (5.0 + nu) / (1.0 + nu),
              0.01 * p * a * a * a * a / (64.0 * D) * 4.0);
}

Model sheet() {
  Model model = make_wall(grid_surface(12, 6, 0.2, [](double u, double v) { return Vec3(0.1 * u, 0.05 * v, 0); }),
                          {.material = {.young = 50e3, .poisson = 0.45, .density = 1050, .thickness = 2e-3}});
  clamp_edges(model, [](const Vec3& X) { return X.x() < 1e-6; });
  return model;
}

void expect_where_steps_lead(const Model& model, const std::function<void(Scene&)>& load, double least) {
  Simulation by_steps(model, {.backend = "reference", .damping = {.rate = 15}}), at_once(model);
  for (Simulation* sim : {&by_steps, &at_once}) {
    sim->scene().fix(model.particles_in([](const Vec3& X) { return X.x() < 1e-6; }));
    load(sim->scene());
  }
  const StaticResult result = at_once.solve_static();
  ASSERT_TRUE(result.converged()) << result.message();
  const RestResult rest = by_steps.run_to_rest();
  ASSERT_TRUE(rest.converged()) << rest.message();
  EXPECT_LE(result.evaluations, 50);
  const double way = at_once.max_displacement();
  EXPECT_GT(way, least);
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    EXPECT_LT((at_once.state().position[i] - by_steps.state().position[i]).norm(), 3e-3 * way);
  }
  // It stays there.
  ASSERT_TRUE(at_once.advance(0.01).ok());
  EXPECT_LT(at_once.energy().kinetic, 1e-8 * at_once.energy().elastic);
}

TEST(WallRest, SheetSagsFar) {
  expect_where_steps_lead(
      sheet(), [](Scene& scene) { scene.gravity(Vec3(0, 0, -0.4)); }, 0.03);
}

TEST(WallRest, SheetFollowsWhatIsImposed) {
  expect_where_steps_lead(
      sheet(),
      [](Scene& scene) {
        Load lift;
        lift.type = LoadType::translation;
        lift.particles = scene.model().particles_in([](const Vec3& X) { return X.x() > 0.1 - 1e-6; });
        lift.direction = {-0.01, 0, 0.05};
        lift.events = {{0.0, 0.051}};
        scene.add(lift);
      },
      0.05);
}

TEST(WallRest, ALoadWhoseSquareIsNotFiniteHasNoRest) {
  Simulation sim(sheet());
  sim.scene().fix(sim.model().particles_in([](const Vec3& X) { return X.x() < 1e-6; })).gravity({0, 0, -1e200});
  EXPECT_FALSE(sim.solve_static({.most_evaluations = 20}).converged());
}

TEST(WallRest, RefusesWhatItCannotDo) {
  const Model model = sheet();
  Simulation loose(model);
  EXPECT_NE(loose.solve_static().message().find("not held against every rigid motion"), std::string::npos);
  Simulation with_tool(model);
  with_tool.scene().add_tool(Sphere{0.01});
  EXPECT_NE(message_of([&] { with_tool.solve_static(); }).find("walls, and the scene has tools"), std::string::npos);
  Model block = with_material(make_block({0.04, 0.02, 0.02}, 4, 2, 2));
  add_capsule(block, model.materials.front());
  Simulation capsule(block);
  EXPECT_NE(message_of([&] { capsule.solve_static(); }).find("got both in one model"), std::string::npos);
}

}  // namespace
}  // namespace phymul::test
