// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <cmath>
#include <filesystem>

#include "base/checked_file.h"
#include "support/message_of.h"
#include "support/run_scenes.h"
#include "support/text_file.h"

namespace phymul {
namespace {

using namespace test;

std::shared_ptr<const TopologyTextures> tables(const Model& model) {
  return std::make_shared<const TopologyTextures>(build_topology(model));
}

/// A saved state read back goes on as if nothing had been, down to the displacements a State rounds away.
TEST(StateFile, TheTrajectoryGoesOnBitForBit) {
  const std::string path = path_for("goes_on.state");
  for (const Vec3& origin : {Vec3(0, 0, 0), Vec3(1000, -2000, 500)}) {
    const Model model = block_at(origin);
    const auto topology = tables(model);
    Scene scene(model);
    scene.fix("x0").add(
        pull(model, "x1", {0, 0, 1}, {{0, 0}, {0.01, 1e-9}}));  // m: far below a double's last digit there
    for (const BackendCase& backend : cpu_backends) {
      const auto first = make_solver(backend.name, topology, scene, options_for(backend));
      const double dt = 0.4 * first->stable_step();
      ASSERT_TRUE(first->step(40, dt).ok());
      save_state(*first, path);
      const State saved = first->read();
      ASSERT_TRUE(first->step(40, dt).ok());

      const auto second = make_solver(backend.name, topology, scene, options_for(backend));
      load_state(*second, path);
      EXPECT_TRUE(same_bits(second->read(), saved)) << backend.name;
      EXPECT_EQ(second->snapshot(), read_state(path)) << backend.name;
      ASSERT_TRUE(second->step(40, dt).ok());
      EXPECT_TRUE(same_bits(second->read(), first->read())) << backend.name << " at " << origin.transpose();
      EXPECT_EQ(second->snapshot(), first->snapshot()) << backend.name << " at " << origin.transpose();
      EXPECT_EQ(second->energy().total(), first->energy().total()) << backend.name;
    }
  }
}

/// Why a snapshot has displacements: without them the same run parts at the first step.
TEST(StateFile, AStateAloneLosesDigitsOfSinglePrecisionFarFromTheOrigin) {
  const Model model = block_at({1000, -2000, 500});
  Scene scene = Scene(model).fix("x0").add(pull(model, "x1", {0, 0, 1}, {{0, 0}, {0.01, 1e-9}}));
  const auto solver = make_solver("cpu", model, scene);
  ASSERT_TRUE(solver->step(40, 0.4 * solver->stable_step()).ok());
  const Snapshot before = solver->snapshot();
  solver->reset(before.state);
  EXPECT_FALSE(same_bits(solver->snapshot().displacement, before.displacement));
  solver->restore(before);
  EXPECT_EQ(solver->snapshot(), before);
}

TEST(StateFile, RestIsFoundAtTheSameStepAfterARestart) {
  const Model model = with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2));
  const auto topology = tables(model);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -1});
  for (const BackendCase& backend : cpu_backends) {
    SolverOptions options = options_for(backend, 60.0);
    options.rest_tolerance = 1e-5;
    options.rest_steps = 50;
    const auto whole = make_solver(backend.name, topology, scene, options);
    const double dt = 0.4 * whole->stable_step();
    const RestResult at_once = whole->run_to_rest(100000, dt);
    ASSERT_TRUE(at_once.converged()) << at_once.message();
    const auto cut = make_solver(backend.name, topology, scene, options);
    ASSERT_FALSE(cut->run_to_rest(at_once.report.steps - 20, dt).converged());
    EXPECT_GT(cut->snapshot().steps_at_rest, 0);
    const auto rest = make_solver(backend.name, topology, scene, options);
    rest->restore(cut->snapshot());
    EXPECT_EQ(rest->run_to_rest(100000, dt).report.steps, 20) << backend.name;
    EXPECT_TRUE(same_bits(rest->read(), whole->read())) << backend.name;
  }
}

TEST(StateFile, ExtremeNumbersComeBackBitForBit) {
  Snapshot saved;
  saved.topology_hash = 0xfedcba9876543210ull;
  saved.backend = "any";
  saved.state.time = 5e-324;
  saved.state.position = {{-0.0, 1.7976931348623157e308, 0.1}};
  saved.state.velocity = {{2.2250738585072014e-308, -5e-324, 3}};
  const ToolState tool{
      .name = "probe",
      .pose = {{1, 2, 3}, Quaternion(0.5, -0.5, 0.5, -0.5), {4, 5, 6}, {7, 8, 9}},
      .placed = false,
      .held = {0},
      .held_at = {{1e-3, 0, -0.0}},
      .needle = {{{{0}, {0.25}, true, true}, {{}, {}, false}}, true, true, 1e-5, {{-1e-3, 0.5, -0.0}}, true}};
  saved.state.tools = {tool, ToolState{}};
  saved.state.threads = {{.name = "thread"}, {.name = "suture", .sewn = {at_mean({0, 1}), {{0}, {1.0}}}}};
  saved.displacement = {{-0.0, 1e-300, 7}};
  saved.last_dt = 1e-9;
  saved.steps_at_rest = 12;
  saved.parts = {{"needle", {0, 255, 10}}, {"", {}}};
  const std::string path = path_for("extreme.state");
  save_state(saved, path);
  const Snapshot again = read_state(path);
  EXPECT_EQ(again, saved);
  EXPECT_TRUE(same_bits(again.state, saved.state));
  EXPECT_TRUE(same_bits(again.displacement, saved.displacement));
  // Little-endian whatever the machine: magic, version 4, and the body's fingerprint at byte 24.
  EXPECT_EQ(text_of(path).substr(0, 16), std::string("phymulSt\4\0\0\0body", 16));
  EXPECT_EQ(text_of(path).substr(24, 8), "\x10\x32\x54\x76\x98\xba\xdc\xfe");
  // What older files do not have is only in those that need it.
  const auto has_parts = [&] {
    const std::string bytes = text_of(path);
    return bytes.find("needles") != std::string::npos || bytes.find("sewn passages") != std::string::npos;
  };
  EXPECT_TRUE(has_parts());
  saved.state.tools[0].needle.free = saved.state.tools[0].needle.hole[0].out = false;
  saved.state.threads[1].sewn.clear();
  save_state(saved, path);
  EXPECT_EQ(read_state(path), saved);
  EXPECT_FALSE(has_parts());
}

TEST(StateFile, OtherBodiesAreRefusedAndTheSolverKeepsItsState) {
  const std::string path = path_for("other.state");
  const Model model = block_at(Vec3::Zero());
  const Scene scene(model);
  const auto solver = make_solver("reference", model, scene);
  save_state(*solver, path);

  const Model stiffer = with_material(model, soft_tissue(0.31));
  const Scene stiff_scene(stiffer);
  const auto other = make_solver("reference", stiffer, stiff_scene);
  ASSERT_TRUE(other->step(3, 0.2 * other->stable_step()).ok());
  const Snapshot before = other->snapshot();
  const std::string message = message_of([&] { load_state(*other, path); });
  EXPECT_TRUE(says(message, path + ": Solver::restore: expected a snapshot of this solver's body, got one of another"));
  EXPECT_TRUE(says(message, "Restore it into a solver over the same tables"));
  EXPECT_EQ(other->snapshot(), before);

  const Model small = make_tetrahedron(0.01);
  const Scene small_scene(small);
  const auto few = make_solver("cpu", small, small_scene);
  EXPECT_TRUE(refuses([&] { load_state(*few, path); }, "Solver::restore: expected a snapshot of this solver's body"));
}

/// A member more than are written would be lost in silence.
TEST(StateFile, KnowsEveryMemberOfAToolsState) {
  EXPECT_EQ(sizeof(NeedleNode), 2 * sizeof(std::vector<int>) + 8)
      << "write the new member in src/session/tool_bytes.cpp";
  EXPECT_EQ(sizeof(NeedleState), 2 * sizeof(std::vector<int>) + 8 + 8 + 8)
      << "write the new member in src/session/tool_bytes.cpp";
  EXPECT_EQ(sizeof(ShaftLoad), 3 * sizeof(double)) << "write the new member in src/session/tool_bytes.cpp";
  EXPECT_EQ(sizeof(Needle), 10 * sizeof(double)) << "write the new member in src/session/tool_bytes.cpp";
  EXPECT_EQ(sizeof(ToolPose), 13 * sizeof(double)) << "write the new member in src/session/tool_bytes.cpp";
}

/// Every option and constant that moves a body is in the fingerprint.
TEST(StateFile, FingerprintsTellBodiesApart) {
  const Model model = make_block({0.03, 0.02, 0.02}, 3, 2, 2);
  const auto of = [](const Model& m, const TopologyOptions& options = {}) {
    return fingerprint(build_topology(m, options));
  };
  const std::uint64_t own = of(model);
  EXPECT_EQ(own, of(make_block({0.03, 0.02, 0.02}, 3, 2, 2)));
  Model changed = model;
  changed.rest[5].x() = std::nextafter(changed.rest[5].x(), 1.0);
  EXPECT_NE(own, of(changed));
  changed = model;
  changed.mass[5] = std::nextafter(changed.mass[5], 1e9);
  EXPECT_NE(own, of(changed));
  changed = model;
  changed.stiffness[5] = std::nextafter(changed.stiffness[5], 1e9);
  EXPECT_NE(own, of(changed));
  for (const Variant& variant : conservative_variants()) {
    // Of six neighbours all triples pass the thresholds.
    if (variant.name == "conservative" || variant.name == "conservative all" || variant.material) continue;
    EXPECT_NE(own, of(model, variant.options)) << variant.name;
  }
}

std::string a_file() {
  const Model model = make_tetrahedron(0.01);
  Scene scene(model);
  scene.add_tool("ball", {.shape = Sphere{0.01}});
  scene.add_joint({at_particle(0), at_world({0, 0, 1})}, 1.0);
  const auto solver = make_solver("cpu", model, scene);
  const std::string path = path_for("whole.state");
  save_state(*solver, path);
  return text_of(path);
}

TEST(StateFile, DamageIsRefusedWithPlaceAndReason) {
  const std::string good = a_file();
  ASSERT_EQ(message_of([&] { read_state_bytes(good, "s"); }), "(no error)");
  const auto refused = [](const std::string& bytes) { return message_of([&] { read_state_bytes(bytes, "s"); }); };
  EXPECT_EQ(refused(""),
            "s: byte 0: expected the magic word (8 bytes), got the end after 0; the file was cut short: take another "
            "copy, or write it anew");
  std::string wrong = good;
  wrong[0] = 'P';
  EXPECT_EQ(refused(wrong),
            "s: byte 0: expected a state file, which begins with \"phymulSt\", got \"PhymulSt\"; give a file of that "
            "kind");
  wrong = good;
  wrong[8] = 1;
  EXPECT_EQ(refused(wrong),
            "s: byte 8: expected version 4 of a state file, got 1; read it with the version of phymul that wrote it");
  wrong = good;
  wrong[100] = static_cast<char>(wrong[100] ^ 4);
  EXPECT_TRUE(says(refused(wrong), "expected the checksum 0x"));
  EXPECT_TRUE(says(refused(good + "x"), "expected the end of a state file, got 1 bytes more"));
}

TEST(StateFile, CutAtEveryByteAndEveryBitTurnedIsRefused) {
  expect_damage_is_refused(a_file(), [](const std::string& bytes) { read_state_bytes(bytes, "s"); });
}

TEST(StateFile, MutantsWithRightChecksumsAreHarmless) {
  const Model model = make_tetrahedron(0.01);
  Scene scene(model);
  const auto solver = make_solver("cpu", model, scene);
  expect_mutants_are_harmless({"phymulSt", 4, "a state file"}, {"body", "stat"}, a_file(),
                              [&](const std::string& file) {
                                const Snapshot snapshot = read_state_bytes(file, "s");
                                if (snapshot.scene) scene.bring_back(*snapshot.scene);
                                solver->restore(snapshot);
                              });
}

TEST(StateFile, AFileThatCannotBeWrittenLeavesTheOldOne) {
  const std::string folder = path_for("folder_of_states");
  std::filesystem::create_directories(folder);
  EXPECT_TRUE(refuses([&] { save_state(Snapshot{}, folder + "/none/x.state"); }, folder + "/none/x.state: "));
  EXPECT_TRUE(refuses([&] { read_state(folder); }, "expected a file, got a folder"));
}

TEST(StateHistory, GoesBackToTheNewestStateAtOrBeforeATime) {
  const Model model = block_at(Vec3::Zero());
  const auto topology = tables(model);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  for (const BackendCase& backend : cpu_backends) {
    const auto solver = make_solver(backend.name, topology, scene, options_for(backend));
    const double dt = 0.4 * solver->stable_step();
    StateHistory history(10, 1 << 30);
    history.follow(*solver, solver->step(0, dt));
    for (int k = 0; k < 100; ++k) history.follow(*solver, solver->step(1, dt));
    EXPECT_EQ(history.size(), 11u);
    const State end = solver->read();
    EXPECT_EQ(history.newest_at(-dt), nullptr);
    ASSERT_NE(history.newest_at(0.0), nullptr);
    ASSERT_TRUE(history.rewind(*solver, 34.5 * dt));
    EXPECT_NEAR(solver->read().time, 30 * dt, 1e-9 * dt);
    EXPECT_EQ(history.size(), 4u);
    for (int k = 0; k < 70; ++k) history.follow(*solver, solver->step(1, dt));
    EXPECT_TRUE(same_bits(solver->read(), end)) << backend.name;
    EXPECT_EQ(history.size(), 11u);
    EXPECT_FALSE(history.rewind(*solver, -1.0));
    EXPECT_TRUE(same_bits(solver->read(), end));

    solver->reset();  // what was later belongs to a run that was left
    history.follow(*solver, solver->step(1, dt));
    EXPECT_EQ(history.size(), 1u);
  }
}

/// The sum of ten milliseconds is not a hundredth of a second to the last bit.
TEST(StateHistory, GoesBackToWholeTicks) {
  Simulation sim(block_at(Vec3::Zero()), {.backend = "reference"});
  sim.keep_history(1);
  for (int tick = 0; tick < 30; ++tick) ASSERT_TRUE(sim.advance(1e-3).ok());
  for (int tick = 29; tick >= 0; --tick) {
    ASSERT_TRUE(sim.rewind(1e-3 * tick));
    ASSERT_NEAR(sim.time(), 1e-3 * tick, 1e-9);
  }
  EXPECT_FALSE(sim.rewind(std::nan("")));
}

TEST(StateHistory, HoldsNoMoreThanItsBytes) {
  const Model model = block_at(Vec3::Zero());
  const Scene scene(model);
  const auto solver = make_solver("cpu", model, scene);
  const std::size_t state = 3 * sizeof(Vec3) * model.rest.size();
  StateHistory history(2, 5 * state + 5 * sizeof(Snapshot));
  const double dt = 0.4 * solver->stable_step();
  for (int k = 0; k < 100; ++k) {
    history.follow(*solver, solver->step(1, dt));
    EXPECT_LE(history.bytes(), 5 * (state + sizeof(Snapshot)));
  }
  EXPECT_EQ(history.size(), 5u);
  EXPECT_EQ(history.newest_at(80 * dt), nullptr);
  const std::size_t of_five = history.bytes();
  ASSERT_TRUE(history.rewind(*solver, 95 * dt));
  EXPECT_EQ(history.bytes() * 5, of_five * history.size());  // states that went take no room
  EXPECT_LT(history.size(), 5u);
  StateHistory tiny(1, 1);
  tiny.follow(*solver, solver->step(1, dt));
  tiny.follow(*solver, solver->step(1, dt));
  EXPECT_EQ(tiny.size(), 1u);
  EXPECT_TRUE(refuses([] { StateHistory(0, 1); }, "a state every 1 step or more"));
}

}  // namespace
}  // namespace phymul
