// SPDX-License-Identifier: MIT
//
// Memory that runs out while something is made, at each allocation in turn: std::bad_alloc or an Error comes out,
// nothing leaks, and what was given in is as it was.
#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <functional>
#include <memory>
#include <new>
#include <sstream>

#include "session/scene_bytes.h"
#include "support/allocation_count.h"
#include "support/bodies.h"

namespace phymul {
namespace {

struct Attempt {
  bool has_failed = false, came_out = false;
};

/// Calls action() with its k-th allocation failing.
Attempt attempt(const std::function<void()>& action, int k) {
  Attempt made;
  const FailingAllocation failing(static_cast<std::size_t>(k));
  try {
    action();
  } catch (const std::bad_alloc&) {
    made.came_out = true;
  } catch (const Error&) {
    made.came_out = true;
  }
  made.has_failed = failing.has_failed();
  return made;
}

/// Calls action() with its first allocation failing, then with its second, until none fails. `check` is called after
/// each failure. Returns how often one failed.
int fail_each(
    const std::function<void()>& action, const std::function<void()>& check = [] {}) {
  action();  // what is made once and stays
  const std::ptrdiff_t before = live_allocations();
  for (int k = 1;; ++k) {
    const auto [has_failed, came_out] = attempt(action, k);
    // Where memory is asked for that one can do without, as std::stable_sort does, nothing needs to come out.
    if (!has_failed) return k - 1;
    check();
    EXPECT_EQ(live_allocations(), before) << "after failure " << k << (came_out ? "" : ", which did not come out");
    if (testing::Test::HasFailure()) return k;
  }
}

Model soft_block() {
  return test::with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2));
}

/// Everything that a scene has.
void fill(Scene& scene) {
  scene.fix("x0").gravity({0, 0, -9.81}).contacts({});
  const ToolHandle tool = scene.add_tool({.shape = Sphere{0.005}, .pose = {.position = {0.024, 0.01, 0.01}}});
  scene.attach(scene.model().group("z1"), tool, {.stiffness = 1e3, .breaking_stress = 1e6});
  scene.add({.type = LoadType::pressure,
             .particles = scene.model().group("x1"),
             .events = {{0.0, 0.0}, {1.0, 5.0}},
             .direction = Vec3(1, 0, 0)});
}

std::string bytes_of(const Scene& scene) {
  return scene_change_bytes(scene, {}, true);
}

TEST(FailingAllocation, OfOneCallIsSeen) {
  const FailingAllocation failing(2);
  void* const first = ::operator new(8);
  EXPECT_FALSE(failing.has_failed());
  void* second = nullptr;
  EXPECT_THROW(second = ::operator new(8), std::bad_alloc);
  EXPECT_TRUE(failing.has_failed());
  ::operator delete(first);
  ::operator delete(second);
}

TEST(FailingAllocation, WhileABodyIsMade) {
  EXPECT_GT(fail_each([] { soft_block(); }), 50);
  EXPECT_GT(fail_each([] {
              make_body(solid_ball({0, 0, 0}, 0.01), {.spacing = 0.008, .most_volume_error = 0.5});
            }),
            50);
  Model model = soft_block();
  const Model before = model;
  EXPECT_GT(fail_each(
                [&] {
                  Model softer = model;
                  set_material(softer, {.young = 1e3, .poisson = 0.4, .density = 1100},
                               [](const Vec3& x) { return x.x() < 0.01; });
                },
                [&] { EXPECT_TRUE(model == before); }),
            10);
}

TEST(FailingAllocation, WhileFilesAreRead) {
  const Model model = soft_block();
  std::ostringstream out, loads;
  write_pml(model, out);
  const std::string text = out.str();
  EXPECT_GT(fail_each([&] { read_pml_text(text, "a.pml"); }), 50);
  const Load load{
      .type = LoadType::force, .particles = {1, 2, 5}, .events = {{0.0, 0.0}, {1.0, 2.0}}, .direction = Vec3(0, 0, 1)};
  write_lml({load}, model, loads);
  const std::string lml = loads.str();
  EXPECT_GT(fail_each([&] { read_lml_text(lml, "a.lml", model); }), 5);
}

TEST(FailingAllocation, WhileASceneIsMadeAndChanged) {
  const Model model = soft_block();
  EXPECT_GT(fail_each([&] {
              Scene scene(model);
              fill(scene);
            }),
            20);
  // Each call alone: a scene that refuses something is as it was.
  Scene scene(model);
  fill(scene);
  const std::vector<std::pair<const char*, std::function<void()>>> calls{
      {"fix", [&] { scene.fix("y0"); }},
      {"tool",
       [&] {
         scene.add_tool({.shape = Sphere{0.01}, .pose = {.position = {0, 0, 1}}});
       }},
      {"joint", [&] { scene.attach(scene.model().group("y1"), World{}, {.stiffness = 1e3}); }},
      {"stiffness", [&] { scene.scale_stiffness(0.5); }}};
  for (const auto& [name, call] : calls) {
    SCOPED_TRACE(name);
    const std::string before = bytes_of(scene);
    for (int k = 1;; ++k) {
      const auto [has_failed, came_out] = attempt(call, k);
      ASSERT_TRUE(has_failed || !came_out) << "an error of its own at call " << k;
      if (!has_failed || !came_out) break;
      ASSERT_TRUE(bytes_of(scene) == before) << "failure " << k << " changed the scene";
    }
  }
}

TEST(FailingAllocation, WhileTablesAndSolversAreMade) {
  const Model model = soft_block(), model_before = model;
  Scene scene(model);
  fill(scene);
  const std::string scene_before = bytes_of(scene);
  const auto check = [&] {
    EXPECT_TRUE(model == model_before);
    EXPECT_TRUE(bytes_of(scene) == scene_before);
  };
  EXPECT_GT(fail_each([&] { build_topology(model); }, check), 50);
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model));
  for (const char* backend : {"reference", "cpu"}) {
    for (const int threads : {1, 3}) {
      SCOPED_TRACE(backend);
      EXPECT_GT(fail_each([&] { make_solver(backend, tables, scene, {.threads = threads}); }, check), 20);
    }
  }
}

/// The state after a failed step, restored and stepped again, is that of a solver that never failed.
TEST(FailingAllocation, WhileASolverStepsAndIsSaved) {
  const Model model = soft_block();
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model));
  for (const char* backend : {"reference", "cpu"}) {
    SCOPED_TRACE(backend);
    Scene scene(model);
    fill(scene);
    const auto solver = make_solver(backend, tables, scene, {.threads = 2});
    const double dt = 0.2 * solver->stable_step();
    ASSERT_TRUE(solver->step(2, dt).ok());
    const Snapshot start = solver->snapshot();
    const auto go = [&] {
      solver->restore(start);
      scene.scale_stiffness(0.5);  // allocates in scene and solver
      solver->step(1, dt);
      scene.scale_stiffness(1.0);
      solver->restore(start);
      solver->step(3, dt);
    };
    go();
    const Snapshot end = solver->snapshot();
    fail_each(go, [&] {
      go();
      EXPECT_TRUE(solver->snapshot() == end);
    });
    EXPECT_GT(fail_each([&] { solver->snapshot(); }), 2);
    // What the recorder's restore brought back of reports stays until a step is done.
    EXPECT_GT(fail_each([&] { Recorder(*solver, scene).step(1, dt); }, [&] { solver->step(1, dt); }), 3);
  }
}

/// What a solver remembers of tools and joints outlives a change of the scene that it could not follow.
TEST(FailingAllocation, WhileASolverFollowsItsScene) {
  const Model model = soft_block();
  for (const char* backend : {"reference", "cpu"}) {
    SCOPED_TRACE(backend);
    Scene scene(model);
    const ToolHandle tool = scene.add_tool({.shape = Sphere{0.005}, .pose = {.position = {0.02, 0.01, 0.025}}});
    scene.attach(model.group("z0"), World{}, {.stiffness = 1e4});
    scene.attach(model.group("z1"), tool, {.stiffness = 1e3, .breaking_stress = 0.1});
    tool.grasp(0.01);
    const auto solver = make_solver(backend, model, scene, {}, {.threads = 1});
    const double dt = 0.2 * solver->stable_step();
    tool.move_to({.position = {0.02, 0.01, 0.03}});
    ASSERT_TRUE(solver->step(20, dt).ok());
    const State before = solver->read();
    ASSERT_FALSE(before.joints.empty()) << "no spring broke";
    ASSERT_FALSE(before.tools[0].held.empty()) << "nothing is held";
    const auto change = [&] {
      scene.gravity({0, 0, scene.gravity().z() - 1e-3});  // so that everything is followed anew
      solver->step(1, dt);
    };
    const int failures = fail_each(change, [&] {
      const State now = solver->read();
      EXPECT_TRUE(now.joints == before.joints);
      EXPECT_TRUE(now.tools[0].name == before.tools[0].name && now.tools[0].held == before.tools[0].held);
    });
    EXPECT_GT(failures, 3);
  }
}

TEST(FailingAllocation, WhileASimulationIsMadeAndStepped) {
  const Model model = soft_block();
  for (const char* backend : {"reference", "cpu"}) {
    SCOPED_TRACE(backend);
    EXPECT_GT(fail_each([&] {
                Simulation sim(model, {.backend = backend});
                sim.scene().fix("x0").gravity({0, 0, -9.81});
                sim.step(1, 0.2 * sim.solver().stable_step());
              }),
              50);
  }
}

/// What is left of a removal that fails is the whole body, in the tables and in the solver.
TEST(FailingAllocation, WhileCellsAreRemoved) {
  const Model model = soft_block();
  for (const char* backend : {"reference", "cpu"}) {
    SCOPED_TRACE(backend);
    const auto made = [&] {
      Simulation sim(model, {.backend = backend});
      sim.scene().fix("x0").gravity({0, 0, -9.81});
      sim.solver();
      return sim;
    };
    Simulation whole = made();
    const double dt = 0.2 * whole.solver().stable_step();
    whole.step(5, dt);
    int failures = 0;
    for (int k = 1;; k += 2, ++failures) {
      Simulation sim = made();
      if (!attempt([&] { sim.remove_cells(std::vector<Index>{1, 4}); }, k).has_failed) break;
      if (!sim.removed_cells().empty()) continue;  // it needed no memory there
      ASSERT_TRUE(sim.step(5, dt).ok()) << k;
      ASSERT_LT(test::largest_distance(sim.solver().read().position, whole.solver().read().position), 1e-12) << k;
    }
    EXPECT_GT(failures, 50);
  }
}

/// A cut that fails leaves the body whole, and one whose undoing fails leaves it cut: in the model and in the solver.
TEST(FailingAllocation, WhileABodyIsCut) {
  const Model whole =
      with_spare_particles(test::with_material(make_tetrahedral_block({0.02, 0.02, 0.02}, 2, 2, 2, 0.2, 3)), 100);
  const auto cut = [](Simulation& sim) { return sim.cut(cut_plane({0.0101, 0.01, 0.01}, {1, 0.1, 0.2})); };
  for (const bool undone : {false, true}) {
    for (const char* backend : {"reference", "cpu"}) {
      SCOPED_TRACE(backend);
      Snapshot start;
      const auto made = [&] {
        Simulation sim(whole, {.backend = backend});
        sim.scene().fix("x0").gravity({0, 0, -9.81});
        EXPECT_TRUE(sim.step(5, 0.2 * sim.solver().stable_step()).ok());
        start = sim.snapshot();
        if (undone) {
          EXPECT_TRUE(cut(sim) && sim.step(5, 0.2 * sim.solver().stable_step()).ok());
        }
        return sim;
      };
      Simulation wanted = made();
      const Model model = wanted.model();
      const double dt = 0.2 * wanted.solver().stable_step();
      ASSERT_TRUE(wanted.step(5, dt).ok());
      int failures = 0;
      for (int k = 1;; k += undone ? 17 : 71) {
        Simulation sim = made();
        const auto [has_failed, came_out] = attempt([&] { undone ? sim.restore(start) : (void)cut(sim); }, k);
        if (!has_failed) break;
        if (!came_out) continue;  // it needed no memory there
        ++failures;
        ASSERT_TRUE(sim.model() == model) << k;
        ASSERT_TRUE(sim.step(5, dt).ok()) << k;
        ASSERT_LT(test::largest_distance(sim.solver().read().position, wanted.solver().read().position), 1e-12) << k;
        EXPECT_THROW(sim.remove_cells(sim.model().cells_in([](const Vec3&) { return true; })), Error) << k;
      }
      EXPECT_GT(failures, undone ? 5 : 20);
    }
  }
}

}  // namespace
}  // namespace phymul
