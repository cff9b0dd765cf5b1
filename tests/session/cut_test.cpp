// SPDX-License-Identifier: MIT
//
// Simulation::cut: the body that is left against one built anew, on every backend, and what follows it.
#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "interaction/contact_surface.h"
#include "support/bodies.h"
#include "support/cut_bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"

namespace phymul {
namespace {

using namespace test;

CutSurface random_plane(std::mt19937& random, const Model& model) {
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const Vec3 through = model.rest[random() % 50];
  CutSurface cut = cut_plane(through, Vec3(any(random), any(random), any(random)));
  const Vec3 edge(any(random), any(random), any(random));
  cut.front = [=](const Vec3& x) { return edge.normalized().dot(x - through); };
  return cut;
}

CutSurface half_way() {
  CutSurface cut = cut_plane({0.031, 0.0, 0.0}, {1.0, 0.2, 0.1});
  cut.front = [](const Vec3& x) { return x.z() - 0.016; };
  return cut;
}

/// They rest at the place of the first particle. Held with it, the copies of a later cut would hang in the air.
TEST(Cut, SpareParticlesAreInNoGroupAndMoveNowhere) {
  const Model model = slab();
  const Model with_room = with_spare_particles(model, 100);
  ASSERT_EQ(with_room.rest.back(), model.rest.front());
  const auto near = [&](const Vec3& x) { return (x - model.rest.front()).norm() < 0.01; };
  EXPECT_EQ(with_room.particles_in(near), model.particles_in(near));
  State state = rest_state(with_room);
  for (Index i = 0; i < model.particle_count(); ++i) state.position[i].x() += 1e-3;
  EXPECT_NEAR(displacement_norms(with_room, state).rms, 1e-3, 1e-12);
}

TEST(Cut, LeavesTheTablesOfABodyBuiltAnew) {
  for (const bool regions : {false, true}) {
    SCOPED_TRACE(regions);
    Model model = slab();
    set_material(model, {5e3, 0.4, 1000.0});
    if (regions) set_material(model, {2e4, 0.3, 1100.0}, [](const Vec3& x) { return x.x() > 0.03; });
    SimulationOptions options;
    if (regions) options.topology.stabiliser = 0.4;
    Simulation sim(with_spare_particles(model, 400), options);
    EXPECT_LT(difference_of_forces(sim.solver().topology(), build_topology(sim.model(), options.topology), sim.model()),
              1e-15);
    ASSERT_TRUE(sim.cut(half_way()));
    EXPECT_LT(difference_of_forces(sim.solver().topology(), built_anew(sim), sim.model()), 1e-12);

    const Model at_once = cut_body(model, half_way());
    ASSERT_EQ(at_once.cells.size(), sim.model().cells.size());
    EXPECT_TRUE(std::ranges::equal(at_once.cells, sim.model().cells));
    ASSERT_TRUE(sim.cut(cut_plane({0.0, 0.021, 0.0}, {0.1, 1.0, 0.0})));
    ASSERT_TRUE(sim.cut(cut_plane({0.0, 0.0, 0.014}, {0.0, 0.1, 1.0})));
    EXPECT_EQ(sim.cuts().size(), 3u);
    EXPECT_LT(difference_of_forces(sim.solver().topology(), built_anew(sim), sim.model()), 1e-12);
    EXPECT_NEAR(volume(sim.model(), sim.model().rest) / volume(model, model.rest), 1.0, 1e-12);
    if (!regions) {
      EXPECT_NEAR(total_mass(sim.model()) / total_mass(model), 1.0, 1e-12);
    }
  }
}

void edit_at_random(int edits) {
  Model model = slab();
  set_material(model, {5e3, 0.4, 1000.0});
  Simulation sim(with_spare_particles(model, 900), options_for("reference"));
  RandomEdits random{sim, random_plane};
  FollowedSurface surface;
  for (int edit = 1; edit <= edits; ++edit) {
    ASSERT_NO_FATAL_FAILURE(random.make_one());
    if (edit % 3 != 0) surface.of(sim.scene());
    if (edit % (edits / 100) != 0) continue;
    const std::shared_ptr<const ContactSurface> followed = surface.of(sim.scene());
    const ContactSurface fresh = make_contact_surface(sim.model());
    ASSERT_TRUE(followed->body_of == fresh.body_of && followed->rest == fresh.rest) << edit;
    constexpr auto corner = &ContactSurface::Triangle::corner;
    ASSERT_TRUE(std::ranges::equal(followed->triangles, fresh.triangles, {}, corner, corner)) << edit;
    ASSERT_LT(difference_of_forces(sim.solver().topology(), built_anew(sim), sim.model()), 1e-12) << edit;
    validate(sim.model());
  }
  EXPECT_GT(random.cuts, 3 * edits / 10);
  EXPECT_GT(random.refused, edits / 100);
  sim.restore(random.kept.front());
  EXPECT_EQ(sim.solver().topology_hash(), random.kept.front().topology_hash);
  const Simulation fresh(with_spare_particles(model, 900), options_for("reference"));
  EXPECT_TRUE(sim.model() == fresh.model());
}

TEST(Cut, RandomEditsLeaveNoStaleRow) {
  edit_at_random(1000);
}

TEST(LongCut, TenThousandRandomEditsLeaveNoStaleRow) {
  edit_at_random(10000);
}

/// How far, after so many steps, particles are from where a fresh solver of the body as it is moves them on
/// "reference", over the longest of these ways.
double apart_from_fresh(Simulation& sim, int steps) {
  const Model left = sim.model();
  Scene scene(left);
  scene.gravity(sim.scene().gravity());
  for (const Load& load : sim.scene().loads()) scene.add(load);  // with the copies of held particles
  SolverOptions options;
  options.damping = sim.solver().options().damping;
  const auto anew = make_solver("reference", std::make_shared<const TopologyTextures>(built_anew(sim)), scene, options);
  const State before = sim.solver().read();
  anew->reset(before);
  const double dt = 0.5 * sim.step_limit();
  EXPECT_TRUE(sim.step(steps, dt).ok());
  EXPECT_TRUE(anew->step(steps, dt).ok());
  const State a = sim.solver().read(), b = anew->read();
  double moved = 0.0, apart = 0.0;
  for (std::size_t i = 0; i < a.position.size(); ++i) {
    moved = std::max(moved, (b.position[i] - before.position[i]).norm());
    apart = std::max(apart, (a.position[i] - b.position[i]).norm());
  }
  return apart / moved;
}

class CutOn : public OnEveryBackend {};

TEST_P(CutOn, MovesOnAsABodyBuiltAnew) {
  Simulation sim(with_spare_particles(slab(), 300), options_for(GetParam()));
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  ASSERT_TRUE(sim.advance(0.05).ok());
  const State before = sim.solver().read();
  ASSERT_TRUE(sim.cut(half_way()));
  const BodyCut& cut = *sim.cuts().front();
  ASSERT_GT(cut.copies.size(), 10u);
  const State after = sim.solver().read();
  for (const BodyCut::Copy& copy : cut.copies) {
    EXPECT_EQ(after.position[copy.particle], before.position[copy.of]);
    EXPECT_EQ(after.velocity[copy.particle], before.velocity[copy.of]);
  }
  const double apart = apart_from_fresh(sim, 400);
  const State a = sim.solver().read();
  double opened = 0.0;
  for (const BodyCut::Copy& copy : cut.copies) {
    opened = std::max(opened, (a.position[copy.particle] - a.position[copy.of]).norm());
  }
  EXPECT_LT(apart, GetParam() == "reference" ? 1e-10 : 1e-5);
  EXPECT_GT(opened, 1e-4);
}

/// Against a fresh solver of the body that a thousand edits have left, with steps in between.
TEST_P(CutOn, MovesOnAfterManyEditsAsABodyBuiltAnew) {
  Simulation sim(with_spare_particles(slab(), 900), options_for(GetParam()));
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  RandomEdits random{sim, random_plane};
  while (random.edits < 1000) {
    ASSERT_NO_FATAL_FAILURE(random.make_one());
    if (random.edits % 50 != 0) continue;
    ASSERT_TRUE(sim.step(2, 0.5 * sim.step_limit()).ok());
  }
  ASSERT_GT(sim.cuts().size(), 3u);
  ASSERT_GT(sim.removed_cells().size(), 3u);
  EXPECT_LT(apart_from_fresh(sim, 200), GetParam() == "reference" ? 1e-10 : 1e-5);
}

/// Copies that have drifted apart exchange mass where a later cut crosses them. Its momentum goes along.
TEST_P(CutOn, KeepsTheMomentum) {
  Simulation sim(with_spare_particles(slab(), 900), options_for(GetParam()));
  State state = sim.solver().read();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> speed(-0.3, 0.3);
  for (Vec3& velocity : state.velocity) velocity = {0.2 + speed(random), speed(random), speed(random)};
  sim.set_state(state);
  for (const CutSurface& cut :
       {half_way(), cut_plane({0.0, 0.021, 0.0}, {0.1, 1.0, 0.0}), cut_plane({0.0, 0.0, 0.014}, {0.0, 0.1, 1.0})}) {
    const Vec3 before = sim.solver().momentum().linear;
    ASSERT_TRUE(sim.cut(cut));
    const double off = (sim.solver().momentum().linear - before).norm() / before.norm();
    EXPECT_LT(off, GetParam() == "reference" ? 1e-14 : 1e-7) << sim.cuts().size();
    ASSERT_TRUE(sim.step(100, 0.5 * sim.step_limit()).ok());
  }
}

/// Under a force on all particles, also on those that are spare.
TEST_P(CutOn, ComesBackAndIsMadeAgain) {
  Simulation sim(with_spare_particles(slab(), 300), options_for(GetParam()));
  Load push{.type = LoadType::force, .events = {{0.0, 1e-5}}, .direction = {0, 1, 0}};
  push.particles.resize(static_cast<std::size_t>(sim.model().particle_count()));
  std::iota(push.particles.begin(), push.particles.end(), 0);
  sim.scene().fix("x0").gravity({0, 0, -9.81}).add(push);
  sim.advance(0.02);
  sim.keep_history(1);
  const Snapshot whole = sim.snapshot();
  ASSERT_TRUE(sim.cut(half_way()));
  sim.remove_cells(cells_within(sim.model(), {0.06, 0.04, 0.0}, 0.012));
  sim.advance(0.02);
  const Snapshot cut = sim.snapshot();
  sim.advance(0.02);
  const State later = sim.solver().read();
  sim.restore(whole);
  EXPECT_TRUE(sim.cuts().empty());
  EXPECT_TRUE(sim.removed_cells().empty());
  EXPECT_EQ(sim.snapshot(), whole);
  sim.restore(cut);
  EXPECT_EQ(sim.cuts().size(), 1u);
  EXPECT_EQ(sim.snapshot(), cut);
  sim.advance(0.02);
  EXPECT_EQ(sim.solver().read(), later);

  const std::string path = testing::TempDir() + "cut_" + GetParam() + ".state";
  sim.save(path);
  Simulation other(with_spare_particles(slab(), 300), options_for(GetParam()));
  other.scene().fix("x0").gravity({0, 0, -9.81}).add(push);
  other.load(path);
  EXPECT_EQ(other.solver().read(), later);
  EXPECT_TRUE(equal_cuts(other.cuts(), sim.cuts()));
  sim.advance(0.01);
  other.advance(0.01);
  EXPECT_EQ(other.solver().read(), sim.solver().read());
}

TEST_P(CutOn, IsRecorded) {
  Simulation sim(with_spare_particles(slab(), 400), options_for(GetParam()));
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  sim.advance(0.01);
  ASSERT_TRUE(sim.cut(half_way()));
  sim.record();
  sim.advance(0.01);
  ASSERT_TRUE(sim.cut(cut_plane({0.0, 0.021, 0.0}, {0.1, 1.0, 0.0})));
  sim.advance(0.01);
  const Snapshot twice = sim.snapshot();
  sim.remove_cells(cells_within(sim.model(), {0.06, 0.04, 0.0}, 0.012));
  sim.advance(0.01);
  sim.restore(twice);
  sim.advance(0.01);
  Simulation other(with_spare_particles(slab(), 400), options_for(GetParam()));
  other.scene().fix("x0").gravity({0, 0, -9.81});
  other.replay(sim.recording());
  EXPECT_EQ(other.snapshot(), sim.snapshot());
  EXPECT_EQ(other.cuts().size(), 2u);
}
PHYMUL_ON_EVERY_BACKEND(CutOn);

TEST(Cut, HeldParticlesStayHeldOnBothSides) {
  Simulation sim(with_spare_particles(slab(), 300), options_for("cpu"));
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  // Through the particles of a row of the held face, which lie on it.
  const Snapshot whole = sim.snapshot();
  ASSERT_TRUE(sim.cut(cut_plane({0.0, 0.02, 0.0}, {0.0, 1.0, 0.0})));
  sim.advance(0.3);
  int held = 0;
  for (const BodyCut::Copy& copy : sim.cuts().front()->copies) {
    const auto x0 = sim.model().group("x0");
    if (std::ranges::find(x0, copy.of) == x0.end()) continue;
    ++held;
    EXPECT_EQ(std::ranges::binary_search(x0, copy.particle), copy.shared);
    EXPECT_LT((sim.solver().read().position[copy.particle] - sim.model().rest[copy.particle]).norm(), 1e-9);
  }
  EXPECT_GT(held, 1);
  sim.restore(whole);
  EXPECT_EQ(sim.scene().loads().front().particles, sim.model().group("x0"));
}

/// A bar stretched along its length has no stress across: cut along it, it stays at rest, if copies and changed domains
/// keep the strains that their material remembers.
TEST_P(CutOn, DoesNotDisturbWhatDissipates) {
  SimulationOptions options = options_for(GetParam());
  options.material.retardation_time = 2e-3;
  options.material.relaxation_strength = 0.5;
  options.material.relaxation_time = 0.05;
  Simulation sim(with_spare_particles(slab(), 300), options);
  for (const double side : {0.0, 1.0}) {
    Load load{.type = LoadType::translation,
              .particles = sim.model().group(side == 0.0 ? "x0" : "x1"),
              .events = {{0.0, 0.0}, {0.1, 0.006 * side}},
              .direction = {1, 0, 0}};
    load.axes = {Axis::driven, Axis::free, Axis::free};
    sim.scene().add(load);
  }
  ASSERT_TRUE(sim.advance(1.0).ok());
  ASSERT_TRUE(sim.cut(cut_plane({0.0, 0.015, 0.0}, {0.0, 1.0, 0.0})));
  double fastest = 0.0;
  for (int tick = 0; tick < 50; ++tick) fastest = std::max(fastest, sim.advance(1e-3).max_speed);
  EXPECT_LT(fastest, 1e-5);
}

TEST(Cut, PartsComeTrulyApart) {
  Simulation sim(with_spare_particles(slab(), 300), options_for("cpu"));
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  sim.advance(0.05);
  ASSERT_TRUE(sim.cut(cut_plane({0.031, 0.0, 0.0}, {1.0, 0.2, 0.1})));
  const auto pieces = connected_bodies(sim.model());
  ASSERT_EQ(pieces.size(), 2u);
  const double before = sim.solver().read().position[pieces[1].particles.front()].z();
  sim.advance(0.2);
  const double fall = before - sim.solver().read().position[pieces[1].particles.front()].z();
  EXPECT_GT(fall, 0.1);
  sim.remove_cells(pieces[1].cells);
  EXPECT_EQ(connected_bodies(sim.model()).size(), 1u);
}

/// The limit that is predicted after cuts is no longer than the true one, and not much shorter.
TEST(Cut, LeavesTheStepALittleShorter) {
  Simulation sim(with_spare_particles(make_tetrahedral_block({0.06, 0.06, 0.06}, 6, 6, 6, 0.25, 3), 900),
                 {.material = {5e3, 0.4, 1000.0}, .backend = "reference"});
  const Snapshot whole = sim.snapshot();
  const double limit = sim.solver().stable_step();
  const double before = estimate_spectrum(sim.solver().topology(), sim.model().rest).largest;
  std::mt19937 random(5);
  double least = 2.0, most = 0.0;
  for (int k = 0; k < 24; ++k) {
    if (k % 3 == 0) sim.restore(whole);
    if (!sim.cut(random_plane(random, sim.model()))) continue;
    const TopologyTextures anew = built_anew(sim);
    const double now = estimate_spectrum(anew, anew.rest).largest;
    const double said = before * std::pow(limit / sim.solver().stable_step(), 2);
    least = std::min(least, said / now);
    most = std::max(most, now / before);
  }
  EXPECT_GE(least, 1.0);
  EXPECT_LT(std::sqrt(most), 1.6);
}

TEST(Cut, RefusesWhatItCannotCutAndChangesNothing) {
  Simulation sim(with_spare_particles(slab(), 10), options_for("cpu"));
  const Snapshot before = sim.snapshot();
  EXPECT_TRUE(says(message_of([&] { sim.cut(half_way()); }), "has 10 spare ones left"));
  EXPECT_TRUE(says(message_of([&] { sim.cut({}); }), "expected CutSurface::distance"));
  EXPECT_FALSE(sim.cut(cut_plane({1.0, 0.0, 0.0}, {1.0, 0.0, 0.0})));
  EXPECT_EQ(sim.snapshot(), before);
  Simulation cubes(with_spare_particles(make_block({0.06, 0.04, 0.03}, 6, 4, 3), 100), options_for("cpu"));
  EXPECT_TRUE(says(message_of([&] { cubes.cut(half_way()); }), "expected a body of tetrahedra"));
  SimulationOptions local = options_for("cpu");
  local.solver.max_substeps = 4;
  local.material = {};
  Model two = slab();
  set_material(two, {1e3, 0.3, 1000.0});
  set_material(two, {1e6, 0.3, 1000.0}, [](const Vec3& x) { return x.x() > 0.055; });
  Simulation fine(with_spare_particles(two, 300), local);
  ASSERT_GT(fine.solver().substeps(), 1);
  EXPECT_TRUE(says(message_of([&] { fine.cut(half_way()); }), "max_substeps"));
  EXPECT_TRUE(fine.cuts().empty());
  EXPECT_TRUE(says(message_of([] { with_spare_particles(slab(), -1); }), "expected a number of 0 or more"));
}

}  // namespace
}  // namespace phymul
