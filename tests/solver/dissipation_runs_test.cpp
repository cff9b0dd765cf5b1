// SPDX-License-Identifier: MIT
//
// Materials that dissipate: what they conserve, their state, and misuse. Closed forms: dissipation_test.cpp.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>

#include "elastic/dissipation.h"
#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"
#include "support/outside_backend.h"

namespace phymul {
namespace {

using namespace test;

class DissipationRunsOn : public OnEveryBackend {};
PHYMUL_ON_EVERY_BACKEND(DissipationRunsOn);

/// Free, of two materials, with both kinds.
Model two_tissues(Model model) {
  set_material(model, {.young = 10e3,
                       .poisson = 0.3,
                       .density = 1000,
                       .retardation_time = 2e-3,
                       .relaxation_strength = 0.8,
                       .relaxation_time = 0.02});
  const double half = 0.5 * body_size(model);
  set_material(model, {.young = 30e3, .poisson = 0.4, .density = 1100, .retardation_time = 1e-3},
               [&](const Vec3& x) { return x.x() > half; });
  return model;
}

TEST(DissipationRuns, ConservesMomentumToRounding) {
  for (const bool plane : {false, true}) {
    const Model model = two_tissues(plane ? make_strip(0.04, 0.02, 4, 2) : jittered_block());
    const Scene scene(model);
    const auto solver = make_solver("reference", model, scene);
    solver->reset(displaced(model, 0.05, 3));
    ASSERT_TRUE(solver->step(400, 0.4 * solver->stable_step()).ok());
    const State now = solver->read();
    double size = 0.0, arm = 0.0;
    for (std::size_t i = 0; i < now.velocity.size(); ++i) {
      size += model.mass[i] * now.velocity[i].norm();
      arm += model.mass[i] * now.position[i].norm() * now.velocity[i].norm();
    }
    ASSERT_GT(size, 0.0);
    EXPECT_LT(solver->momentum().linear.norm(), 1e-12 * size);
    EXPECT_LT(solver->momentum().angular.norm(), 1e-12 * arm);
  }
}

TEST(DissipationRuns, NeverGivesEnergyBack) {
  const Model model = two_tissues(jittered_block());
  const Scene scene(model);
  const auto solver = make_solver("reference", model, scene);
  const State state = displaced(model, 0.05, 5);
  for (const auto& [share, steps] : {std::pair(0.02, 10), std::pair(0.5, 1)}) {
    solver->reset(state);
    const double dt = share * solver->stable_step();
    ASSERT_TRUE(solver->step(1, dt).ok());
    const double first = solver->energy().total();
    double before = first;
    for (int k = 0; k < 200; ++k) {
      ASSERT_TRUE(solver->step(steps, dt).ok());
      const double now = solver->energy().total();
      EXPECT_LT(now, before + 1e-6 * first) << "call " << k << " of " << share << " of the limit";
      before = now;
    }
    EXPECT_LT(before, 0.7 * first);
    EXPECT_GT(before, 0.0);
  }
}

/// Velocities of a state's own time are the mean of those half a step before and after, of all forces.
TEST_P(DissipationRunsOn, TellsVelocitiesOfTheStatesOwnTime) {
  const Model model = two_tissues(jittered_block());
  Simulation sim(model, {.backend = GetParam()});
  sim.set_state(displaced(model, 0.05, 7));
  const double dt = 0.5 * sim.solver().stable_step();
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(sim.advance(dt).ok());
    const State own = sim.state();
    const double kinetic = sim.energy().kinetic;
    const VecList before = sim.solver().read().velocity;
    Solver& solver = sim.unrecorded_solver();
    const Snapshot now = solver.snapshot();
    ASSERT_TRUE(solver.step(1, dt).ok());
    const VecList after = solver.read().velocity;
    solver.restore(now);
    double fastest = 0.0, off = 0.0, product = 0.0;
    for (std::size_t i = 0; i < own.velocity.size(); ++i) {
      const Vec3 mean = 0.5 * (before[i] + after[i]);
      fastest = std::max(fastest, mean.norm());
      off = std::max(off, (own.velocity[i] - mean).norm());
      product += 0.5 * model.mass[i] * before[i].dot(after[i]);
    }
    EXPECT_LT(off, 1e-5 * fastest) << k;
    EXPECT_NEAR(kinetic, product, 1e-5 * product) << k;
  }
}

TEST_P(DissipationRunsOn, ContinuesBitForBitFromASnapshot) {
  const Model model = two_tissues(jittered_block());
  const Scene scene(model);
  const auto topology = std::make_shared<const TopologyTextures>(build_topology(model));
  const auto solver = make_solver(GetParam(), topology, scene, {.threads = 1});
  const State state = displaced(model, 0.05, 11);
  solver->reset(state);
  const double dt = 0.4 * solver->stable_step();
  ASSERT_TRUE(solver->step(50, dt).ok());
  const Snapshot snapshot = solver->snapshot();
  ASSERT_TRUE(solver->step(50, 0.7 * dt).ok());

  const std::string path = testing::TempDir() + "/dissipation_" + GetParam() + ".state";
  save_state(snapshot, path);
  EXPECT_EQ(read_state(path), snapshot);
  const auto other = make_solver(GetParam(), topology, scene, {.threads = 2});
  load_state(*other, path);
  ASSERT_TRUE(other->step(50, 0.7 * dt).ok());
  EXPECT_EQ(other->snapshot(), solver->snapshot());

  Snapshot forgetful = snapshot;  // the state alone is another body's: its strains are those of now
  forgetful.parts.clear();
  other->restore(forgetful);
  ASSERT_TRUE(other->step(50, 0.7 * dt).ok());
  EXPECT_NE(other->read(), solver->read());

  Snapshot damaged = snapshot;
  damaged.parts.front().bytes.pop_back();
  EXPECT_TRUE(refuses([&] { other->restore(damaged); }, "expected the snapshot's part \"strains\" to have"));
}

/// A recording through a file, over a way back to an earlier state, and from a state saved in the middle.
TEST_P(DissipationRunsOn, IsReplayedBitForBit) {
  const Model model = two_tissues(jittered_block());
  const auto topology = std::make_shared<const TopologyTextures>(build_topology(model));
  const auto made = [&](const Scene& scene) { return make_solver(GetParam(), topology, scene, {.threads = 1}); };
  Scene scene = Scene(model).gravity({0, 0, -9.81});
  const auto recorded = made(scene);
  recorded->reset(displaced(model, 0.05, 11));
  const double dt = 0.4 * recorded->stable_step();
  ASSERT_TRUE(recorded->step(7, dt).ok());  // the recording starts with strains

  const std::string path = testing::TempDir() + "/dissipation_" + GetParam();
  Recorder recorder(*recorded, scene);
  recorder.step(30, dt);
  const Snapshot early = recorded->snapshot();
  recorder.step(20, 0.7 * dt);
  recorder.restore(early);
  recorder.step(15, dt);
  save_state(*recorded, path + ".state");
  std::uint64_t middle = 0;
  for (const Input& input : recorder.recording().inputs) middle += input.times;
  scene.gravity({0, 0, -5.0});
  recorder.step(25, dt);
  recorder.checkpoint();
  save_recording(recorder.recording(), path + ".rec");

  Scene again(model), second_half(model);
  const auto replayed = made(again), resumed = made(second_half);
  Replay(read_recording(path + ".rec"), *replayed, again).run();
  EXPECT_EQ(replayed->snapshot(), recorded->snapshot());
  Replay rest(recorder.recording(), *resumed, second_half);
  rest.skip_to(middle);
  load_state(*resumed, path + ".state");
  rest.run();
  EXPECT_EQ(resumed->snapshot(), recorded->snapshot());
}

/// A step that is not accepted leaves the strains of the one before.
TEST_P(DissipationRunsOn, KeepsItsStrainsWhenAStepFails) {
  const Model model = two_tissues(jittered_block());
  const Scene scene(model);
  const auto solver = make_solver(GetParam(), model, scene, {}, {.on_unstable = UnstableStep::allow});
  solver->reset(displaced(model, 0.05, 11));
  ASSERT_TRUE(solver->step(20, 0.4 * solver->stable_step()).ok());
  const Snapshot before = solver->snapshot();
  EXPECT_EQ(solver->step(1, 1e15).status, StepStatus::not_finite);
  EXPECT_EQ(solver->snapshot(), before);
}

TEST(DissipationRuns, OnTheProcessorIsThatOfTheReference) {
  for (const bool plane : {false, true}) {
    const Model model = two_tissues(plane ? make_strip(0.04, 0.02, 4, 2) : jittered_block());
    const Scene scene(model);
    const auto exact = make_solver("reference", model, scene), fast = make_solver("cpu", model, scene);
    const State state = displaced(model, 0.05, 4);
    exact->reset(state);
    fast->reset(state);
    const double dt = 0.4 * exact->stable_step();
    for (int k = 0; k < 4; ++k) {
      ASSERT_TRUE(exact->step(50, dt).ok() && fast->step(50, dt).ok());
      const double apart = largest_distance(exact->read().position, fast->read().position);
      EXPECT_LT(apart, 1e-5 * mean_spacing(model)) << k;
    }
  }
}

TEST(DissipationRuns, RefusesConstantsOutOfTheirRange) {
  Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  const Material good{.young = 10e3, .poisson = 0.3, .density = 1000};
  const auto message = [&](auto change) {
    Material material = good;
    change(material);
    return message_of([&] { set_material(model, material); });
  };
  EXPECT_EQ(message([](Material& m) { m.retardation_time = -1.0; }),
            "material: expected 0 s or more for retardation_time, got -1 s");
  EXPECT_EQ(message([](Material& m) { m.relaxation_strength = -0.5; }),
            "material: expected 0 or more for relaxation_strength, got -0.5");
  EXPECT_EQ(message([](Material& m) { m.relaxation_strength = 1.0; }),
            "material: expected more than 0 s, because relaxation_strength is above 0, for relaxation_time, got 0 s");
  set_material(model, good);
  model.materials.front().retardation_time = std::nan("");
  EXPECT_THROW(build_topology(model), Error);
}

TEST(DissipationRuns, IsPartOfABodysFingerprints) {
  Model model =
      with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2), {.young = 10e3, .poisson = 0.3, .density = 1000});
  const TopologyTextures plain = build_topology(model);
  EXPECT_TRUE(plain.dissipation.empty());
  model.materials.front().retardation_time = 0.01;
  EXPECT_NE(fingerprint(build_topology(model)), fingerprint(plain));
  const Scene scene(model);
  EXPECT_THROW(make_solver("cpu", std::make_shared<const TopologyTextures>(plain), scene), Error);
}

TEST(DissipationRuns, ThatABackendDoesNotTakeIsRefusedByName) {
  const Model model = with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2),
                                    {.young = 10e3, .poisson = 0.3, .density = 1000, .retardation_time = 0.01});
  const Scene scene(model);
  try {
    const OutsideBackend refused(std::make_shared<const TopologyTextures>(build_topology(model)), scene);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::not_supported);
    EXPECT_TRUE(says(error.what(), "retardation_time"));
  }
}

TEST(DissipationRuns, SimulationSaysThatSleepHasNoEffect) {
  SimulationOptions options{.material = {.young = 10e3, .poisson = 0.3, .density = 1000, .retardation_time = 0.01},
                            .backend = "cpu"};
  options.solver.sleep_tolerance = 1e-6;
  const Simulation simulation(make_block({0.02, 0.02, 0.02}, 2, 2, 2), options);
  ASSERT_FALSE(simulation.warnings().empty());
  EXPECT_TRUE(says(simulation.warnings().back(), "sleep_tolerance has no effect"));
}

/// The lasting stiffness alone, and from there on no stress that relaxes.
TEST_P(DissipationRunsOn, StaysInTheStaticRest) {
  SimulationOptions options{.material = {.young = 10e3,
                                         .poisson = 0.3,
                                         .density = 1000,
                                         .retardation_time = 0.01,
                                         .relaxation_strength = 2.0,
                                         .relaxation_time = 0.5},
                            .backend = GetParam()};
  Simulation simulation(make_block({0.04, 0.02, 0.02}, 4, 2, 2), options);
  simulation.scene().fix("x0").gravity({0, 0, -9.81});
  ASSERT_TRUE(simulation.solve_static().converged());
  const State rest = simulation.solver().read();
  ASSERT_TRUE(simulation.advance(0.5).ok());
  const State after = simulation.solver().read();
  const double most = largest_distance(rest.position, simulation.model().rest);
  EXPECT_GT(most, 0.0);
  EXPECT_LT(largest_distance(after.position, rest.position), 1e-3 * most);
}

class EditedDissipationOn : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Cpu, EditedDissipationOn, testing::Values("reference", "cpu"),
                         [](const auto& backend) { return std::string(backend.param); });

/// Of domains that have all their cells still, whose particles may have another mass. Strains are found from places of
/// single precision on "cpu".
TEST_P(EditedDissipationOn, AnEditLeavesTheRatesOfWhatItDoesNotTouch) {
  SimulationOptions options{.material = {.young = 10e3, .poisson = 0.3, .density = 1000, .retardation_time = 5e-3},
                            .backend = GetParam()};
  const Model block = make_tetrahedral_block({0.06, 0.04, 0.03}, 6, 4, 3, 0.25, 7);
  Simulation sim(with_spare_particles(block, 300), options);
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  CutSurface plane = cut_plane({0.031, 0.0, 0.0}, {1.0, 0.2, 0.1});
  plane.front = [](const Vec3& x) { return x.z() - 0.016; };
  ASSERT_TRUE(sim.cut(plane));  // copies share their masses with what they copy, so that an edit beside changes these
  ASSERT_TRUE(sim.advance(0.02).ok());
  const auto strains = [&] { return strains_of(sim.solver().snapshot(), sim.solver().topology()); };
  const StrainMemory before = strains();
  const std::vector<Index> cells =
      sim.model().cells_in([](const Vec3& x) { return (x - Vec3(0.03, 0.02, 0.01)).norm() < 0.008; });
  const std::size_t edited = sim.solver().topology().edited.size();
  sim.remove_cells(cells);
  const TopologyTextures& t = sim.solver().topology();
  std::vector<bool> touched(t.mass.size(), false);
  for (const Index cell : cells) {
    for (const Index i : sim.model().cells[cell].particles) touched[i] = true;
  }
  const auto is_whole = [&](Index d) { return !touched[t.domains[d].particle]; };
  ASSERT_GE(std::count_if(t.edited.begin() + static_cast<std::ptrdiff_t>(edited), t.edited.end(), is_whole), 1);
  const StrainMemory after = strains();
  ASSERT_EQ(after.size(), before.size());
  const double roundoff = options.backend == "cpu" ? 0x1p-24 : 0x1p-53;
  const double spacing = 0.01, least_edge = 0.2 * spacing;
  const double most = largest_distance(sim.solver().read().position, sim.model().rest);
  double apart = 0.0, step = 0.0;
  for (Index d = 0; d < static_cast<Index>(before.size()); ++d) {
    for (std::size_t k = 0; is_whole(d) && k < 6; ++k) apart = std::max(apart, std::abs(after[d][k] - before[d][k]));
  }
  sim.step(1, 0.3 * sim.solver().stable_step());
  const StrainMemory later = strains();
  for (std::size_t d = 0; d < later.size(); ++d) {
    for (std::size_t k = 0; k < 6; ++k) step = std::max(step, std::abs(later[d][k] - after[d][k]));
  }
  EXPECT_LE(apart, 8.0 * roundoff * most / least_edge);
  EXPECT_GT(step, 100.0 * apart) << "or the body hardly moves";
  RecordProperty("apart", std::to_string(1e9 * apart));
}

}  // namespace
}  // namespace phymul
