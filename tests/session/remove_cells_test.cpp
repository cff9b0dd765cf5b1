// SPDX-License-Identifier: MIT
//
// Simulation::remove_cells: the body that is left against one built anew, on every backend, and what follows it.
#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <numeric>

#include "support/bodies.h"
#include "support/cut_bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"
#include "support/outside_backend.h"

namespace phymul {
namespace {

using namespace test;

struct Kind {
  const char* name;
  Model model;
};

/// Tetrahedra, hexahedra (whose domains share their rows), wedges, regions of two materials, fibres, the plane.
std::vector<Kind> kinds() {
  std::vector<Kind> all{{"tetrahedra", slab()},
                        {"hexahedra", make_block({0.06, 0.04, 0.03}, 6, 4, 3)},
                        {"wedges", make_cylinder(0.02, 0.05, 3, 8, 7)},
                        {"regions", slab()},
                        {"fibres", slab()},
                        {"plane", make_strip(0.06, 0.03, 8, 4)}};
  for (Kind& kind : all) set_material(kind.model, {5e3, 0.4, 1000.0});
  set_material(all[3].model, {2e4, 0.3, 1100.0}, [](const Vec3& x) { return x.x() > 0.03; });
  set_material(all[4].model, {.young = 5e3, .poisson = 0.4, .density = 1000.0, .fibre_ratio = 4.0});
  for (std::size_t row = 0; row < all[4].model.cells.size(); ++row) {
    all[4].model.cells[row].fibre = row % 2 == 0 ? Vec3(1, 0, 0) : Vec3(1, 0.5, 0);
  }
  return all;
}

TEST(RemoveCells, LeaveTheTablesOfABodyBuiltAnew) {
  for (Kind& kind : kinds()) {
    SCOPED_TRACE(kind.name);
    const bool regions = std::string(kind.name) == "regions", mixed = std::string(kind.name) == "wedges";
    SimulationOptions options;
    if (regions || mixed) options.topology.stabiliser = 0.4;
    Simulation sim(kind.model, options);
    const std::uint64_t before = sim.solver().topology_hash();
    std::mt19937 bits(3);
    const auto count = static_cast<Index>(kind.model.cells.size());
    std::vector<Index> some;
    for (Index k = 0; k < count / 4; ++k) some.push_back(static_cast<Index>(bits() % count));
    sim.remove_cells(some);
    sim.remove_cells(std::vector<Index>{some.front(), 0, 1});
    const TopologyTextures anew = built_anew(sim);
    EXPECT_LT(difference_of_forces(sim.solver().topology(), anew, sim.model(), 5), 1e-12);
    EXPECT_EQ(sim.solver().topology().mass, anew.mass);
    EXPECT_NE(sim.solver().topology_hash(), before);
    const double left = volume(sim.model(), sim.model().rest) / volume(kind.model, kind.model.rest);
    EXPECT_LT(left, 0.85);
    EXPECT_NEAR(total_mass(sim.model()) / total_mass(kind.model), left, regions ? 0.03 : 0.015);
  }
}

TEST(RemoveCells, OneByOneLeaveNoStaleRow) {
  Simulation sim(slab(), options_for("reference"));
  const Snapshot whole = sim.snapshot();
  std::mt19937 bits(11);
  const auto count = static_cast<Index>(sim.model().cells.size());
  Snapshot between = whole;
  for (int edit = 1; edit <= 10'000; ++edit) {
    if (edit % 350 == 0) sim.restore(edit % 700 == 0 ? whole : between);
    if (edit % 350 == 200) between = sim.snapshot();
    sim.remove_cells(std::vector<Index>{static_cast<Index>(bits() % count)});
    if (edit % 100 != 0) continue;
    ASSERT_LT(difference_of_forces(sim.solver().topology(), built_anew(sim), sim.model(), 5), 1e-12) << edit;
  }
  sim.restore(whole);
  EXPECT_EQ(sim.solver().topology_hash(), whole.topology_hash);
  Model fresh = slab();
  set_material(fresh, options_for("").material);
  EXPECT_EQ(sim.model().mass, fresh.mass);
  EXPECT_LT(difference_of_forces(sim.solver().topology(), build_topology(fresh), fresh, 5), 1e-13);
}

class RemoveCellsOn : public OnEveryBackend {};

/// In single precision a force is off by rounding of sums of its size; so many steps add up.
TEST_P(RemoveCellsOn, MovesOnAsABodyBuiltAnew) {
  for (const bool lattice : {false, true}) {
    SCOPED_TRACE(lattice);
    Simulation sim(lattice ? make_block({0.06, 0.04, 0.03}, 6, 4, 3) : slab(), options_for(GetParam()));
    sim.scene().fix("x0").gravity({0, 0, -9.81});
    ASSERT_TRUE(sim.advance(0.05).ok());
    sim.remove_cells(cells_within(sim.model(), {0.04, 0.02, 0.03}, 0.014));
    sim.remove_cells(cells_within(sim.model(), {0.06, 0.04, 0.0}, 0.012));
    ASSERT_FALSE(sim.removed_cells().empty());
    const auto gone = std::ranges::count(sim.model().mass, 0.0);
    EXPECT_GT(gone, 0);

    const Model left = sim.model();
    Scene scene(left);
    scene.fix("x0").gravity({0, 0, -9.81});
    SolverOptions options;
    options.damping = sim.solver().options().damping;
    const auto anew =
        make_solver("reference", std::make_shared<const TopologyTextures>(built_anew(sim)), scene, options);
    anew->reset(sim.solver().read());
    const double dt = 0.4 * sim.solver().stable_step();
    ASSERT_TRUE(sim.step(200, dt).ok());
    ASSERT_TRUE(anew->step(200, dt).ok());
    const State own = sim.solver().read(), other = anew->read();
    double apart = 0.0, moved = 0.0;
    for (std::size_t i = 0; i < own.position.size(); ++i) {
      apart = std::max(apart, (own.position[i] - other.position[i]).norm());
      moved = std::max(moved, (other.position[i] - left.rest[i]).norm());
      if (left.mass[i] == 0.0) {
        EXPECT_EQ(own.position[i], left.rest[i]);
        EXPECT_EQ(own.velocity[i], Vec3::Zero());
      }
    }
    EXPECT_GT(moved, 1e-3);
    EXPECT_LT(apart, GetParam() == "reference" ? 1e-12 * moved : 2e-5 * moved);
  }
}

TEST_P(RemoveCellsOn, AreUndoneBitForBit) {
  Simulation sim(slab(), options_for(GetParam()));
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  ASSERT_TRUE(sim.advance(0.03).ok());
  const Snapshot before = sim.snapshot();
  const double dt = 0.4 * sim.solver().stable_step();
  ASSERT_TRUE(sim.step(50, dt).ok());
  const State whole = sim.solver().read();
  sim.restore(before);
  sim.remove_cells(cells_within(sim.model(), {0.04, 0.02, 0.03}, 0.014));
  const Snapshot cut = sim.snapshot();
  ASSERT_TRUE(sim.step(50, dt).ok());
  const State part = sim.solver().read();
  EXPECT_NE(part.position, whole.position);
  sim.restore(before);
  EXPECT_TRUE(sim.removed_cells().empty());
  ASSERT_TRUE(sim.step(50, dt).ok());
  EXPECT_EQ(sim.solver().read().position, whole.position);
  sim.restore(cut);
  ASSERT_TRUE(sim.step(50, dt).ok());
  EXPECT_EQ(sim.solver().read().position, part.position);
}

TEST_P(RemoveCellsOn, AreReplayed) {
  const auto scene_of = [](Simulation& sim) { sim.scene().fix("x0").gravity({0, 0, -9.81}); };
  Simulation sim(slab(), options_for(GetParam()));
  scene_of(sim);
  sim.remove_cells(std::vector<Index>{0});
  sim.record();
  ASSERT_TRUE(sim.advance(0.02).ok());
  const Snapshot early = sim.snapshot();
  sim.remove_cells(cells_within(sim.model(), {0.04, 0.02, 0.03}, 0.014));
  ASSERT_TRUE(sim.advance(0.02).ok());
  sim.restore(early);
  ASSERT_TRUE(sim.advance(0.01).ok());
  sim.remove_cells(cells_within(sim.model(), {0.06, 0.04, 0.0}, 0.012));
  ASSERT_TRUE(sim.advance(0.02).ok());
  Simulation other(slab(), options_for(GetParam()));
  other.replay(sim.recording());
  EXPECT_EQ(other.removed_cells(), sim.removed_cells());
  EXPECT_EQ(other.solver().read().position, sim.solver().read().position);
}

PHYMUL_ON_EVERY_BACKEND(RemoveCellsOn);

/// The bound on the step: of bodies with cells taken at random and in lumps.
TEST(RemoveCells, KeepTheStepBelowItsLimit) {
  for (const double nu : {0.3, 0.45}) {
    for (Kind& kind : kinds()) {
      if (kind.model.materials.size() > 1) continue;
      SCOPED_TRACE(kind.name);
      set_material(kind.model, {5e3, nu, 1000.0, kind.model.materials.front().fibre_ratio});
      for (int way = 0; way < 4; ++way) {
        SimulationOptions options;
        options.topology.stabiliser = 0.4;
        Simulation sim(kind.model, options);
        static_cast<void>(sim.solver());  // there before: one made afterwards estimates its spectrum
        std::mt19937 bits(17 + way);
        std::vector<Index> rows;
        const auto count = static_cast<Index>(kind.model.cells.size());
        for (Index k = 0; way < 2 && k < (way + 1) * count / 10; ++k) {
          rows.push_back(static_cast<Index>(bits() % count));
        }
        const Vec3 centre = kind.model.rest[bits() % kind.model.rest.size()];
        if (way > 1) rows = cells_within(kind.model, centre, 0.008 * way);
        sim.remove_cells(rows);
        const TopologyTextures anew = built_anew(sim);
        const double limit = stable_step(anew, estimate_spectrum(anew, anew.rest), 1.0);
        EXPECT_LE(sim.solver().stable_step(), 1.005 * limit) << way;
        EXPECT_GE(sim.solver().stable_step(), 0.6 * limit) << way;
      }
    }
  }
}

/// Where a few light particles set the step of the whole body, of unlike materials, in the plane and in organs.
TEST(RemoveCells, OfUnlikeRatesKeepTheStepBelowItsLimit) {
  Model two = make_tetrahedral_block({0.05, 0.05, 0.05}, 4, 4, 4, 0.3, 5), light = two,
        plane = make_strip(0.05, 0.05, 6, 6, true),
        organ = make_body(solid_ellipsoid({0, 0, 0}, {0.04, 0.03, 0.02}), {.spacing = 0.008});
  light.most_mass_moved = 0.0;
  for (Model* model : {&two, &light, &plane, &organ}) {
    set_material(*model, {3e3, 0.45, 1000.0});
    if (model == &two) set_material(two, {3e5, 0.3, 1000.0}, [](const Vec3& x) { return x.x() > 0.03; });
    model->most_mass_moved = 0.03;  // as of a body that was read from a file with masses of its own
    const auto count = static_cast<Index>(model->cells.size());
    for (int way = 0; way < 20; ++way) {
      Simulation sim(*model, {});
      const TopologyTextures& now = sim.solver().topology();
      const double before = estimate_spectrum(now, now.rest).largest;
      std::mt19937 bits(way);
      std::vector<Index> rows(static_cast<std::size_t>(count));
      std::iota(rows.begin(), rows.end(), 0);
      std::ranges::shuffle(rows, bits);
      rows.resize(rows.size() * static_cast<std::size_t>(1 + way % 9) / 10);
      sim.remove_cells(rows);
      EXPECT_LE(estimate_spectrum(now, now.rest).largest, now.stiffened * before) << way;
    }
  }
}

/// Of a solver that was made after cells had been removed, when they come back.
TEST(RemoveCells, ASecondSolverKeepsItsStepBelowTheLimit) {
  Model model = slab();
  set_material(model, {5e3, 0.4, 1000.0});
  set_material(model, {5e5, 0.4, 1000.0}, [](const Vec3& x) { return x.x() > 0.05; });
  Simulation sim(model);
  const Snapshot whole = sim.snapshot();
  const double limit = sim.solver().stable_step();
  for (const bool stiffest : {false, true}) {
    sim.remove_cells(cells_within(model, Vec3(stiffest ? 0.06 : 0.0, 0.02, 0.015), 0.022));
    const std::shared_ptr<const TopologyTextures> tables(std::shared_ptr<void>(), &sim.solver().topology());
    const auto second = make_solver("cpu", tables, sim.scene());
    sim.restore(whole);
    second->body_changed();
    EXPECT_LE(second->stable_step(), 1.005 * limit) << stiffest;
    EXPECT_GE(second->stable_step(), 0.6 * limit) << stiffest;
  }
}

/// Cells that a model lacks already are not counted as cells that are left.
TEST(RemoveCells, OfABodyThatLacksSomeLeaveOne) {
  Simulation first(slab(), options_for("cpu"));
  first.remove_cells(std::vector<Index>{0});
  Simulation sim(first.model(), options_for("cpu"));
  std::vector<Index> left(sim.model().cells.size() - 1);
  std::iota(left.begin(), left.end(), 1);
  EXPECT_TRUE(refuses([&] { sim.remove_cells(left); }, "some cell of the body to be left"));
  left.pop_back();
  EXPECT_NO_THROW(sim.remove_cells(left));
}

TEST(RemoveCells, ASnapshotThatIsRefusedChangesNothing) {
  Simulation sim(slab(), options_for("reference"));
  sim.scene().fix("x0").gravity({0, 0, -9.81}).add_tool("ball", {.shape = Sphere{0.01}});
  ASSERT_TRUE(sim.advance(0.01).ok());
  const Snapshot before = sim.snapshot();
  sim.remove_cells(std::vector<Index>{3, 4, 5});
  sim.scene().remove_tool("ball");
  Snapshot other = sim.snapshot();
  other.parts.push_back({.name = "of another backend", .bytes = {1}});
  sim.restore(before);
  EXPECT_THROW(sim.restore(other), Error);
  EXPECT_TRUE(sim.removed_cells().empty());
  EXPECT_EQ(sim.snapshot(), before);
  EXPECT_TRUE(sim.advance(0.01).ok());
}

TEST(RemoveCells, OfABackendThatDoesNotFollowChangeNothing) {
  SimulationOptions options = options_for("cpu");
  options.make_solver = [](auto topology, const Scene& scene, const SolverOptions&) {
    return std::make_unique<OutsideBackend>(topology, scene);
  };
  Simulation sim(slab(), std::move(options));
  const double before = sim.solver().stable_step();
  EXPECT_TRUE(refuses([&] { sim.remove_cells(std::vector<Index>{0}); }, "does not follow changes"));
  EXPECT_TRUE(sim.removed_cells().empty());
  EXPECT_EQ(sim.solver().stable_step(), before);
}

TEST(RemoveCells, StayRemovedInAStateFile) {
  Simulation sim(slab(), options_for("cpu"));
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  sim.remove_cells(cells_within(sim.model(), {0.04, 0.02, 0.03}, 0.014));
  ASSERT_TRUE(sim.advance(0.02).ok());
  const std::string path = testing::TempDir() + "removed_cells.state";
  sim.save(path);
  Simulation other(slab(), options_for("cpu"));
  other.scene().fix("x0").gravity({0, 0, -9.81});
  other.load(path);
  EXPECT_EQ(other.removed_cells(), sim.removed_cells());
  EXPECT_EQ(other.snapshot(), sim.snapshot());
  Simulation whole(slab(), options_for("cpu"));
  EXPECT_TRUE(refuses([&] { load_state(whole.unrecorded_solver(), path); }, "other removed cells"));
}

TEST(RemoveCells, RewindAndHistoryFollow) {
  Simulation sim(slab(), options_for("cpu"));
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  sim.keep_history(1);
  ASSERT_TRUE(sim.advance(0.01).ok());
  const double time = sim.time();
  sim.remove_cells(std::vector<Index>{3, 4, 5});
  ASSERT_TRUE(sim.advance(0.01).ok());
  ASSERT_TRUE(sim.rewind(time));
  EXPECT_TRUE(sim.removed_cells().empty());
  ASSERT_TRUE(sim.advance(0.01).ok());
}

TEST(RemoveCells, RefuseWhatTheyCannot) {
  Simulation sim(slab(), options_for("cpu"));
  const std::string range = message_of([&] { sim.remove_cells(std::vector<Index>{2, 100'000}); });
  EXPECT_TRUE(says(range, "got 100000")) << range;
  EXPECT_TRUE(sim.removed_cells().empty());
  const std::vector<Index> all = sim.model().cells_in([](const Vec3&) { return true; });
  const std::string empty = message_of([&] { sim.remove_cells(all); });
  EXPECT_TRUE(says(empty, "some cell of the body to be left")) << empty;
  EXPECT_TRUE(sim.removed_cells().empty());
  Simulation springs(slab());
  const std::string plain = message_of([&] { springs.remove_cells(std::vector<Index>{0}); });
  EXPECT_TRUE(says(plain, "cells or walls with a material")) << plain;
  EXPECT_TRUE(sim.advance(0.01).ok());
  SimulationOptions fine = options_for("cpu");
  fine.solver.max_substeps = 4;
  Model two = slab();
  set_material(two, {1e3, 0.3, 1000.0});
  set_material(two, {1e6, 0.3, 1000.0}, [](const Vec3& x) { return x.x() > 0.055; });
  fine.material = {};
  Simulation local(two, fine);
  ASSERT_GT(local.solver().substeps(), 1);
  EXPECT_TRUE(refuses([&] { local.remove_cells(std::vector<Index>{0}); }, "max_substeps"));
  EXPECT_TRUE(local.removed_cells().empty());
  EXPECT_EQ(local.model().cells[0].share, 1.0);
  EXPECT_TRUE(local.advance(0.01).ok());
}

}  // namespace
}  // namespace phymul
