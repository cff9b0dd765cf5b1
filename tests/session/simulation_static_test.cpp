// SPDX-License-Identifier: MIT
//
// Simulation::solve_static: the rest shape without steps, and the work that it takes.
#include <gtest/gtest.h>

#include <functional>
#include <utility>

#include "support/bodies.h"
#include "support/failure_states.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

Material tissue_of(double poisson) {
  return {.young = 10e3, .poisson = poisson, .density = 1000};
}

enum class Cells { tetrahedra, hexahedra };

Model beam(int across, Cells cells) {
  const Vec3 size{0.2, 0.05, 0.05};
  return cells == Cells::hexahedra ? make_block(size, 4 * across, across, across)
                                   : make_tetrahedral_block(size, 4 * across, across, across, 0.2, 1);
}

/// Steps come as near to rest as the test compares.
SimulationOptions with_steps_to_the_end(double poisson) {
  SimulationOptions options;
  options.material = tissue_of(poisson);
  options.backend = "reference";
  options.solver.rest_tolerance = 1e-10;
  return options;
}

Simulation hung(Model model, double poisson, double gravity) {
  Simulation sim(std::move(model), with_steps_to_the_end(poisson));
  sim.scene().fix("x0").gravity({0, 0, -9.81 * gravity});
  return sim;
}

/// Of a value from time 0 on, along a direction.
Load constant(LoadType type, std::vector<Index> particles, double value, const Vec3& direction) {
  Load load;
  load.type = type;
  load.particles = std::move(particles);
  load.events = {{0.0, value}};
  load.direction = direction;
  return load;
}

double largest_difference(Simulation& a, Simulation& b) {
  return largest_distance(a.state().position, b.state().position);
}

void expect_shape_of_steps(Simulation& solved, Simulation& stepped, const std::string& name) {
  const StaticResult result = solved.solve_static();
  ASSERT_TRUE(result.converged()) << name << ": " << result.message();
  EXPECT_LE(result.residual, 1e-6) << name;
  const RestResult rest = stepped.run_to_rest();
  ASSERT_TRUE(rest.converged()) << name << ": " << rest.message();
  EXPECT_LT(largest_difference(solved, stepped), 1e-5 * stepped.max_displacement()) << name;
  EXPECT_EQ(largest_norm(solved.state().velocity), 0.0) << name;
  EXPECT_EQ(solved.time(), 0.0) << name;
}

TEST(SimulationStatic, FindsTheShapeThatStepsComeToUnderSmallAndLargeLoads) {
  for (const Cells cells : {Cells::tetrahedra, Cells::hexahedra}) {
    for (const double poisson : {0.3, 0.45}) {
      for (const double gravity : {0.01, 1.0}) {
        Simulation solved = hung(beam(2, cells), poisson, gravity);
        Simulation stepped = hung(beam(2, cells), poisson, gravity);
        expect_shape_of_steps(solved, stepped,
                              "nu " + std::to_string(poisson) + ", " + std::to_string(gravity) + " g, " +
                                  (cells == Cells::hexahedra ? "hexahedra" : "tetrahedra"));
      }
    }
  }
}

TEST(SimulationStatic, FindsTheShapeOfImposedMotion) {
  const auto turned = [] {
    Simulation sim(cylinder_275(), with_steps_to_the_end(0.45));
    sim.scene().fix("bottom");
    sim.scene().add(constant(LoadType::rotation, sim.model().group("top"), 1.5, {0, 0, 1}));
    return sim;
  };
  Simulation solved = turned(), stepped = turned();
  expect_shape_of_steps(solved, stepped, "twisted by 1.5 rad");
  EXPECT_LT(solved.solve_static().evaluations, 10);  // it begins where it is
  const auto pressed = [] {
    Simulation sim(make_tetrahedral_block({0.08, 0.08, 0.08}, 4, 4, 4, 0.2, 1), with_steps_to_the_end(0.3));
    sim.scene().fix("z0");
    sim.scene().add(constant(LoadType::translation, sim.model().group("z1"), 0.01, {0, 0, -1}));
    return sim;
  };
  Simulation solved_cube = pressed(), stepped_cube = pressed();
  expect_shape_of_steps(solved_cube, stepped_cube, "pressed by an eighth");
}

/// Evaluations that a search may take of hung beams with Poisson's ratios of 0.3 and 0.45.
void expect_evaluations(double gravity, int most_of_soft, int most_of_stiff) {
  for (const Cells cells : {Cells::tetrahedra, Cells::hexahedra}) {
    for (const int across : {4, 8}) {
      for (const auto& [poisson, most] : {std::pair(0.3, most_of_soft), std::pair(0.45, most_of_stiff)}) {
        const StaticResult result = hung(beam(across, cells), poisson, gravity).solve_static();
        EXPECT_TRUE(result.converged()) << result.message();
        EXPECT_LE(result.evaluations, most) << across << " across, nu " << poisson;
      }
    }
  }
}

/// With one level of particles alone, conjugate gradients take 100 evaluations and more at the first size and twice as
/// many at the second.
TEST(SimulationStatic, TakesAsManyEvaluationsForALargeBodyAsForASmallOne) {
  expect_evaluations(1e-3, 70, 140);
}

/// Its tip comes down by more than its length, and at the clamp its material is strained beyond the law.
TEST(SimulationStatic, TakesFiveTimesAsManyUnderTheWholeWeight) {
  expect_evaluations(1.0, 350, 560);
}

TEST(SimulationStatic, ABackendInSinglePrecisionTakesTheState) {
  Simulation single(beam(2, Cells::tetrahedra), {.material = tissue_of(0.3), .backend = "cpu"});
  single.scene().fix("x0").gravity({0, 0, -0.1});
  Simulation exact = hung(beam(2, Cells::tetrahedra), 0.3, 0.1 / 9.81);
  ASSERT_TRUE(single.solve_static().converged());
  ASSERT_TRUE(exact.solve_static().converged());
  EXPECT_LT(largest_difference(single, exact), 1e-6 * exact.max_displacement());
  // It stays there.
  const double before = single.max_displacement();
  ASSERT_TRUE(single.advance(0.05).ok());
  EXPECT_NEAR(single.max_displacement(), before, 1e-3 * before);
}

TEST(SimulationStatic, SaysThatABodyThatNothingHoldsHasNoRest) {
  Simulation falling(beam(2, Cells::hexahedra), {.material = tissue_of(0.3), .backend = "reference"});
  falling.scene().gravity({0, 0, -9.81});
  const StaticResult none = falling.solve_static();
  EXPECT_EQ(none.status, RestStatus::failed);
  EXPECT_TRUE(says(none.message(), "nothing holds \"Elements\", and the loads drive it: it moves away"))
      << none.message();
  // Held along one axis alone, and loaded along another.
  Simulation sliding(beam(2, Cells::hexahedra), {.material = tissue_of(0.3), .backend = "reference"});
  sliding.scene().gravity({9.81, 0, 0});
  Load held = constant(LoadType::translation, sliding.model().group("z0"), 0.0, {0, 0, 1});
  held.axes = {Axis::free, Axis::free, Axis::held};
  sliding.scene().add(held);
  const StaticResult slides = sliding.solve_static();
  EXPECT_EQ(slides.status, RestStatus::failed);
  EXPECT_TRUE(says(slides.message(), "a rigid motion of it meets no support")) << slides.message();
}

TEST(SimulationStatic, BalancedLoadsNeedNoSupport) {
  Simulation sim(beam(2, Cells::hexahedra), {.material = tissue_of(0.3), .backend = "reference"});
  constexpr double traction = 4.0;  // Pa
  for (const auto& [group, sign] : {std::pair{"x0", -1.0}, std::pair{"x1", 1.0}}) {
    sim.scene().add(constant(LoadType::pressure, sim.model().group(group), traction, {sign, 0, 0}));
  }
  const StaticResult result = sim.solve_static();
  ASSERT_TRUE(result.converged()) << result.message();
  const State state = sim.state();
  const double length = state.position[sim.model().group("x1")[4]].x() - state.position[sim.model().group("x0")[4]].x();
  const double longer = 0.2 * traction / 10e3;
  EXPECT_NEAR(length - 0.2, longer, 0.02 * longer);
}

/// A body between plates that hold it along z alone: nothing resists that it slides or turns about z.
TEST(SimulationStatic, LeavesABodyWhereItIsFreeToSlide) {
  for (const double poisson : {0.3, 0.45}) {
    const auto pressed = [&] {
      Simulation sim(make_block({0.08, 0.08, 0.08}, 5, 5, 5), with_steps_to_the_end(poisson));
      for (const auto& [group, by] : {std::pair{"z0", 0.0}, std::pair{"z1", 0.01}}) {
        Load plate = constant(LoadType::translation, sim.model().group(group), by, {0, 0, -1});
        plate.axes = {Axis::free, Axis::free, by == 0.0 ? Axis::held : Axis::driven};
        sim.scene().add(plate);
      }
      return sim;
    };
    Simulation solved = pressed(), stepped = pressed();
    expect_shape_of_steps(solved, stepped, "between plates, nu " + std::to_string(poisson));
    EXPECT_LT(solved.solve_static().evaluations, 10);
  }
}

TEST(SimulationStatic, KeepsTheStateIfItDoesNotConverge) {
  Simulation sim = hung(beam(2, Cells::tetrahedra), 0.3, 0.1);
  ASSERT_TRUE(sim.advance(0.01).ok());
  const State before = sim.solver().read();
  const StaticResult result = sim.solve_static({.most_evaluations = 20});
  EXPECT_EQ(result.status, RestStatus::step_limit);
  EXPECT_GT(result.residual, 1e-6);
  EXPECT_TRUE(says(result.message(), "not at rest after")) << result.message();
  EXPECT_TRUE(sim.solver().read() == before);
  EXPECT_TRUE(sim.solve_static().converged());
  EXPECT_EQ(sim.time(), before.time);
  sim.scene().gravity({0, 0, -1e200});  // m/s^2: its square is not finite
  EXPECT_FALSE(sim.solve_static({.most_evaluations = 100}).converged());
}

TEST(SimulationStatic, ReturnsFromEveryBrokenState) {
  constexpr double side = 0.02;
  constexpr int across = 3;
  Simulation sim(make_tetrahedral_block({side, side, side}, across, across, across, 0.2, 3),
                 {.material = tissue_of(0.45), .backend = "reference"});
  for (const FailureState& failure : failure_states()) {
    std::mt19937 bits(5);
    State state = rest_state(sim.model());
    failure.apply(state.position, side, side / across, bits);
    sim.set_state(state);
    const StaticResult result = sim.solve_static();
    EXPECT_TRUE(result.converged()) << failure.name << ": " << result.message();
    EXPECT_LT(sim.energy().elastic, 1e-12) << failure.name;
  }
}

/// On a bed, hung by ligaments that pull only, and glued to a body that is held.
TEST(SimulationStatic, FindsTheShapeOnJoints) {
  const Model block = make_tetrahedral_block({0.06, 0.03, 0.03}, 4, 2, 2, 0.2, 1);
  const Model upper = moved(block, {0.01, 0.002, 0.031});
  const NamedBody bodies[] = {{"lower", &block}, {"upper", &upper}};
  struct Case {
    const char* name;
    Model model;
    std::function<void(Scene&)> hold;
    int evaluations;  // ligaments let the body swing far
  };
  const Case cases[] = {
      {"bed", block,
       [](Scene& scene) { scene.attach(scene.model().group("z0"), World{}, {.stiffness = 1e5, .damping = 50.0}); },
       150},
      {"ligaments", block,
       [](Scene& scene) {
         scene.attach(scene.model().group("x0"), World{{-0.01, 0, 0.02}}, {.stiffness = 1e5, .slack = true});
         scene.attach(scene.model().group("x1"), World{{0.01, 0, 0.02}}, {.stiffness = 2e5, .slack = true});
       },
       1200},
      {"threads", block,  // each slack at the start: what holds the body changes on the way
       [](Scene& scene) {
         for (const Index i : scene.model().group("z1")) {
           const Anchor end = at_world(scene.model().rest[i] + Vec3(0, 0, 0.045));
           scene.add_joint({.springs = {{.a = at_particle(i), .b = end, .rest_length = 0.05}},
                            .stiffness = 1e4,
                            .damping = 1.0,
                            .slack = true});
         }
       },
       6000},
      {"glue", merge_models(bodies),
       [](Scene& scene) {
         scene.fix("lower/z0");
         scene.attach(scene.model().group("upper/z0"), "lower", {.stiffness = 1e6, .damping = 100.0});
       },
       400},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    Simulation direct(c.model, with_steps_to_the_end(0.3)), stepped(c.model, with_steps_to_the_end(0.3));
    for (Simulation* sim : {&direct, &stepped}) {
      sim->scene().gravity({0, 1.0, -3.0});
      c.hold(sim->scene());
    }
    const StaticResult result = direct.solve_static({.most_evaluations = c.evaluations});
    ASSERT_TRUE(result.converged()) << result.message();
    ASSERT_EQ(stepped.run_to_rest(400'000).status, RestStatus::converged);
    const double moved_by = largest_distance(direct.state().position, c.model.rest);
    EXPECT_GT(moved_by, 1e-4);
    EXPECT_LT(largest_difference(direct, stepped), 1e-4 * moved_by);
    for (const SceneJoint& joint : stepped.scene().joints()) {
      const JointReport& found = direct.report_of(direct.scene().joint(joint.name));
      const JointReport& expected = stepped.solver().joint_report(joint.name);
      ASSERT_EQ(found.springs.size(), expected.springs.size());
      EXPECT_LT((found.force - expected.force).norm(), 1e-3 * (expected.largest + 1e-3)) << joint.name;
      EXPECT_NEAR(found.largest, expected.largest, 1e-3 * (expected.largest + 1e-3)) << joint.name;
      EXPECT_EQ(found.broken, 0);
      EXPECT_NEAR(found.springs[0].length, expected.springs[0].length, 1e-4 * moved_by);
    }
    std::printf("%s: %d evaluations, moved by %.2f mm\n", c.name, result.evaluations, 1e3 * moved_by);
  }
}

/// A notch, a corner without cells and what was there, and spare particles: none of these has mass or stiffness.
TEST(SimulationStatic, FindsTheShapeOfWhatCutsAndRemovalsLeave) {
  std::vector<Simulation> sims;
  for (int k = 0; k < 2; ++k) {
    Simulation& sim = sims.emplace_back(hung(with_spare_particles(beam(4, Cells::tetrahedra), 100), 0.3, 0.01));
    CutSurface notch = cut_plane({0.083, 0.025, 0.025}, {1, 0.1, 0});
    notch.front = [](const Vec3& x) { return 0.03 - x.z(); };
    ASSERT_TRUE(sim.cut(notch));
    std::vector<Index> corner;
    for (Index row = 0; row < static_cast<Index>(sim.model().cells.size()); ++row) {
      const auto is_far = [&](Index i) { return sim.model().rest[i].x() > 0.13 && sim.model().rest[i].y() > 0.02; };
      if (std::ranges::all_of(sim.model().cells[row].particles, is_far)) corner.push_back(row);
    }
    sim.remove_cells(corner);
    EXPECT_GT(std::ranges::count(sim.model().mass, 0.0), 60);
  }
  expect_shape_of_steps(sims[0], sims[1], "cut and removed");
}

/// What a search keeps for the next one alters no bit of it, also where the body, what is held or a tool has changed.
TEST(SimulationStatic, ASecondSearchIsThatOfASimulationThatHadNone) {
  const auto make = [] { return hung(with_spare_particles(beam(4, Cells::tetrahedra), 100), 0.3, 0.01); };
  const std::vector<std::pair<std::string, std::function<void(Simulation&)>>> changes{
      {"load", [](Simulation& sim) { sim.scene().gravity(Vec3(0, 0.05, -0.1)); }},
      {"held", [](Simulation& sim) { sim.scene().fix("x1"); }},
      {"stiffness", [](Simulation& sim) { sim.scene().scale_stiffness(2.0); }},
      {"cut",
       [](Simulation& sim) {
         CutSurface notch = cut_plane({0.083, 0.025, 0.025}, {1, 0.1, 0});
         notch.front = [](const Vec3& x) { return 0.03 - x.z(); };
         sim.cut(notch);
       }},
      {"tool",
       [](Simulation& sim) {
         sim.scene().add_tool("ball", {.shape = Sphere{0.02}, .pose = {.position = {0.1, 0.025, 0.066}}});
       }},
      {"no tool", [](Simulation& sim) { sim.scene().remove_tool("ball"); }}};
  Simulation sim = make();
  ASSERT_TRUE(sim.solve_static().converged());
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const Vec3 gravity = k == 0 ? Vec3(0, 0, -0.01 * 9.81) : Vec3(0, 0.05, -0.1);
    sim.scene().gravity(1.1 * gravity);
    ASSERT_TRUE(sim.solve_static({.predict = true}).converged()) << changes[k].first;
    sim.scene().gravity(gravity);
    changes[k].second(sim);
    State start = sim.state();
    ASSERT_TRUE(sim.solve_static().converged()) << changes[k].first;
    Simulation fresh = make();
    for (std::size_t done = 0; done <= k; ++done) changes[done].second(fresh);
    start.tools.clear();
    fresh.set_state(start);
    ASSERT_TRUE(fresh.solve_static().converged()) << changes[k].first;
    EXPECT_EQ(sim.state().position, fresh.state().position) << changes[k].first;
  }
}

TEST(SimulationStatic, SaysWhichJointWouldBreak) {
  Simulation sim(make_tetrahedral_block({0.06, 0.03, 0.03}, 4, 2, 2, 0.2, 1), with_steps_to_the_end(0.3));
  sim.scene().gravity({0, 0, -9.81});
  sim.scene().attach(sim.model().group("z1"), World{}, {.stiffness = 1e5, .breaking_stress = 200.0, .name = "thread"});
  const StaticResult weak = sim.solve_static();
  EXPECT_EQ(weak.status, RestStatus::failed);
  EXPECT_TRUE(says(weak.message(), "joint \"thread\""));
  EXPECT_EQ(sim.state().position, sim.model().rest);
}

TEST(SimulationStatic, IsRecorded) {
  Simulation sim = hung(beam(2, Cells::tetrahedra), 0.3, 0.1);
  sim.record();
  ASSERT_TRUE(sim.advance(0.01).ok());
  ASSERT_TRUE(sim.solve_static().converged());
  sim.scene().gravity({0, 0, -2});
  ASSERT_TRUE(sim.advance(0.01).ok());
  Simulation again = hung(beam(2, Cells::tetrahedra), 0.3, 0.1);
  again.replay(sim.recording());
  EXPECT_TRUE(again.solver().read() == sim.solver().read());
}

TEST(SimulationStatic, RefusesWhatItDoesNotSupport) {
  const auto refusal = [](const std::function<void(Simulation&)>& change) {
    Simulation sim = hung(beam(2, Cells::hexahedra), 0.3, 0.1);
    change(sim);
    return message_of([&] { sim.solve_static(); });
  };
  EXPECT_TRUE(says(refusal([](Simulation& sim) { sim.scene().contacts({}); }), "contacts"));
  EXPECT_TRUE(says(refusal([](Simulation& sim) { sim.scene().constrain_volume(); }), "volume constraint"));
  EXPECT_TRUE(says(refusal([](Simulation& sim) {
                     Load ramp = constant(LoadType::force, {0}, 0.0, {1, 0, 0});
                     ramp.events.push_back({1.0, 1e-3});
                     sim.scene().add(ramp);
                   }),
                   "load 1 has an event at 1 s"));
  Simulation springs(make_block({0.02, 0.02, 0.02}, 2, 2, 2), {.backend = "reference"});
  EXPECT_TRUE(refuses([&] { springs.solve_static(); }, "a body with a material"));
  Simulation plane(make_strip(0.04, 0.02, 4, 2), {.material = tissue_of(0.3), .backend = "reference"});
  EXPECT_TRUE(refuses([&] { plane.solve_static(); }, "three dimensions"));
  Model loose = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  add_particle(loose, {0.1, 0.1, 0.1});
  Simulation partly(
      loose, {.material = tissue_of(0.3), .backend = "reference", .topology = {.on_sparse = SparseParticle::free}});
  EXPECT_TRUE(refuses([&] { partly.solve_static(); }, "particle 27 is in no cell with a material"));
  Simulation sim = hung(beam(2, Cells::hexahedra), 0.3, 0.1);
  EXPECT_TRUE(refuses([&] { sim.solve_static({.tolerance = 0.0}); }, "StaticOptions::tolerance"));
  EXPECT_TRUE(refuses([&] { sim.solve_static({.most_evaluations = 0}); }, "StaticOptions::most_evaluations"));
}

}  // namespace
}  // namespace phymul::test
