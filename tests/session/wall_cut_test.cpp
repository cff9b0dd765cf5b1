// SPDX-License-Identifier: MIT
//
// Walls that are cut, and whose triangles are removed, alone and on cells: what is left against a body built anew, and
// what follows it.
#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <memory>
#include <numeric>
#include <random>

#include "model/cell_geometry.h"
#include "support/cut_bodies.h"
#include "support/message_of.h"

namespace phymul {
namespace {

using namespace test;

struct Named {
  const char* name;
  Model model;
};
std::vector<Named> bodies_with_walls() {
  return {{"sheet", sheet()},
          {"sphere", sphere()},
          {"tee", tee()},
          {"fin", block_with_fin()},
          {"capsule", slab_in_capsule()}};
}

CutSurface plane_through_wall(std::mt19937& random, const Model& model) {
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const Vec3 through = model.rest[random() % 50];
  CutSurface cut = cut_plane(through, Vec3(any(random), any(random), 0.3 * any(random)));
  const Vec3 edge(any(random), any(random), any(random));
  if (random() % 2 == 0) cut.front = [=](const Vec3& x) { return edge.normalized().dot(x - through); };
  return cut;
}

/// J, and N: largest differences over the largest of a body built anew.
void expect_tables_of_a_new_body(const Simulation& sim) {
  EXPECT_LT(difference_of_forces(sim.solver().topology(), built_anew(sim), sim.model()), 1e-12);
}

Model clamped_sheet() {
  Model model = sheet();
  clamp_edges(model, [](const Vec3& x) { return x.x() < 1e-6; });
  return model;
}

TEST(WallCut, RandomEditsLeaveNoStaleRow) {
  std::vector<Named> bodies = bodies_with_walls();
  bodies.push_back({"clamped", clamped_sheet()});
  for (const Named& body : bodies) {
    SCOPED_TRACE(body.name);
    Simulation sim(with_spare_particles(body.model, 400), without_material("cpu"));
    RandomEdits random{sim, plane_through_wall};
    for (int edit = 1; edit <= 300; ++edit) {
      ASSERT_NO_FATAL_FAILURE(random.make_one());
      if (edit % 10 != 0) continue;
      ASSERT_NO_FATAL_FAILURE(expect_tables_of_a_new_body(sim)) << edit;
      validate(sim.model());
      ASSERT_TRUE(sim.step(2, 0.5 * sim.step_limit()).ok()) << edit;
    }
    EXPECT_GT(random.cuts, 80);
    const Snapshot& whole = random.kept.front();
    sim.restore(whole);
    const std::size_t walls = sim.solver().topology().walls.size();
    for (int again = 0; again < 3; ++again) {
      ASSERT_TRUE(sim.cut(cut_plane(body.model.rest[20], {1.0, 0.3, 0.1})));
      sim.restore(whole);
      EXPECT_EQ(sim.solver().topology().walls.size(), walls);  // rows are used again
    }
    const Simulation fresh(with_spare_particles(body.model, 400), without_material("cpu"));
    EXPECT_TRUE(sim.model() == fresh.model());
    EXPECT_EQ(sim.solver().topology_hash(), fresh.solver().topology_hash());
  }
}

/// Along a row of particles it parts between triangles: each side has the forces of a sheet of its own, which is
/// clamped where the whole one was.
TEST(WallCut, AlongEdgesLeavesTwoSheets) {
  constexpr int n = 8;
  const auto at_clamp = [](const Vec3& x) { return x.y() < 1e-6; };
  Model whole = make_wall(square(n, 0.0), {.material = film});
  clamp_edges(whole, at_clamp);
  const Model cut = cut_body(whole, cut_plane({sheet_side / 2.0, 0.0, 0.0}, {1.0, 0.0, 0.0}));
  ASSERT_EQ(cut.particle_count(), whole.particle_count() + n + 1);
  EXPECT_EQ(cut.cells.size(), whole.cells.size());
  const std::vector<ConnectedBody> parts = connected_bodies(cut);
  ASSERT_EQ(parts.size(), 2u);
  std::mt19937 random(3);
  VecList x = cut.rest;
  for (Vec3& p : x) p += 0.002 * random_vector(random, 3);
  const VecList force = forces_at(build_topology(cut), x);
  for (const ConnectedBody& part : parts) {
    Surface half;
    std::vector<Index> at(cut.rest.size(), -1);
    for (const Index i : part.particles) {
      at[i] = static_cast<Index>(half.vertices.size());
      half.vertices.push_back(cut.rest[i]);
    }
    for (const Index row : part.cells) {
      const std::vector<Index>& of = cut.cells[row].particles;
      if (of.size() < 3) continue;
      half.triangles.push_back({at[of[0]], at[of[1]], at[of[2]]});
    }
    Model alone = make_wall(half, {.material = film});
    EXPECT_EQ(clamp_edges(alone, at_clamp), n / 2);
    VecList places(alone.rest.size());
    const auto row_of = [&](Index i) { return std::ranges::find(alone.rest, cut.rest[i]) - alone.rest.begin(); };
    for (const Index i : part.particles) places[row_of(i)] = x[i];
    const VecList own = forces_at(build_topology(alone), places);
    for (const Index i : part.particles) {
      EXPECT_LT((force[i] - own[row_of(i)]).norm(), 1e-12 * largest_norm(own));
    }
  }
}

/// A strip pulled along a cut keeps its force exactly: the parts' shares of stiffness add up. Bent about an axis across
/// the cut, two halves together are as stiff as the whole but for the free edges' curvature across.
TEST(WallCut, PartsHaveTheirShareOfStiffness) {
  const Model whole = sheet(12);
  const Model cut = cut_body(whole, cut_plane({0.0, 0.047, 0.0}, {0.03, 1.0, 0.0}));
  ASSERT_EQ(connected_bodies(cut).size(), 2u);
  EXPECT_GT(cut.cells.size(), whole.cells.size() + 10);
  EXPECT_NEAR(total_mass(cut) / total_mass(whole), 1.0, 1e-12);
  const auto energy = [](const Model& model, auto place) {
    VecList x;
    for (const Vec3& X : model.rest) x.push_back(place(X));
    return elastic_energy(build_topology(model), x);
  };
  const auto stretched = [](const Vec3& X) { return Vec3(1.1 * X.x(), 0.97 * X.y(), 0.0); };
  EXPECT_NEAR(energy(cut, stretched) / energy(whole, stretched), 1.0, 1e-12);
  const auto rolled = [](const Vec3& X) {
    return Vec3(0.05 * std::sin(X.x() / 0.05), X.y(), 0.05 * (1.0 - std::cos(X.x() / 0.05)));
  };
  EXPECT_NEAR(energy(cut, rolled) / energy(whole, rolled), 1.0, 0.02);
  // Edges beside the cut are none of the sheet's.
  Model clamped = cut;
  EXPECT_EQ(clamp_edges(clamped, {}), 4 * 12 - 2);
}

/// Two halves of a plate on its hinges are two plates; a slit opens, and its ends stay joined.
TEST(WallCut, HalvesOfAHeldSheetFallApart) {
  for (const char* backend : {"reference", "cpu"}) {
    SCOPED_TRACE(backend);
    Simulation sim(with_spare_particles(sheet(), 200), without_material(backend));
    sim.scene().fix("x0").gravity({0, 0, -9.81});
    ASSERT_TRUE(sim.advance(0.02).ok());
    ASSERT_TRUE(sim.cut(cut_plane({0.052, 0.0, 0.0}, {1.0, 0.2, 0.0})));
    const std::vector<ConnectedBody> parts = connected_bodies(sim.model());
    ASSERT_EQ(parts.size(), 2u);
    const std::size_t loose = sim.model().rest[parts[0].particles[0]].x() > 0.05 ? 0 : 1;
    double mass = 0.0;
    Vec3 before = Vec3::Zero(), after = before, speed = before;
    const auto mean = [&](Vec3& place) {
      const State state = sim.solver().read();
      mass = 0.0;
      place = speed = Vec3::Zero();
      for (const Index i : parts[loose].particles) {
        place += sim.model().mass[i] * state.position[i];
        speed += sim.model().mass[i] * state.velocity[i];
        mass += sim.model().mass[i];
      }
      place /= mass;
      speed /= mass;
    };
    mean(before);
    const Vec3 first = speed;
    ASSERT_TRUE(sim.advance(0.1).ok());
    mean(after);
    // Damped by 10 /s on its way.
    const double c = 10.0, g = 9.81, t = 0.1, e = std::exp(-c * t);
    const double fall = first.z() * (1.0 - e) / c - g / c * (t - (1.0 - e) / c);
    EXPECT_NEAR((after - before).z() / fall, 1.0, 0.02);
  }
}

TEST(WallCut, IsUndoneSavedAndReplayedBitForBit) {
  for (const Named& body : bodies_with_walls()) {
    for (const char* backend : {"reference", "cpu"}) {
      SCOPED_TRACE(std::string(body.name) + backend);
      const auto made = [&] {
        auto sim = std::make_unique<Simulation>(with_spare_particles(body.model, 300), without_material(backend));
        sim->scene().gravity({0, 0, -9.81});
        sim->scene().fix(sim->model().particles_in([&](const Vec3& x) { return x.x() < 1e-9; }));
        return sim;
      };
      const auto sim = made(), uncut = made();
      sim->record();
      sim->advance(0.004), uncut->advance(0.004);
      const Snapshot whole = sim->snapshot();
      const CutSurface along = cut_plane({0.0, 0.021, 0.0}, {0.1, 1.0, 0.1});
      ASSERT_TRUE(sim->cut(along));
      sim->remove_cells(std::vector<Index>{3, static_cast<Index>(sim->model().cells.size()) - 2});
      sim->advance(0.004);
      const Snapshot cut = sim->snapshot();
      sim->advance(0.004);
      const State later = sim->solver().read();
      sim->restore(whole);
      EXPECT_TRUE(sim->cuts().empty());
      sim->advance(0.004), uncut->advance(0.004);
      EXPECT_EQ(sim->solver().read(), uncut->solver().read());
      sim->restore(cut);
      EXPECT_EQ(sim->snapshot(), cut);
      sim->advance(0.004);
      EXPECT_EQ(sim->solver().read(), later);
      const auto other = made(), loaded = made();
      other->replay(sim->recording());
      EXPECT_EQ(other->snapshot(), sim->snapshot());
      const std::string path = testing::TempDir() + "wall_cut.state";
      sim->save(path);
      loaded->load(path);
      sim->advance(0.004), loaded->advance(0.004);
      EXPECT_EQ(loaded->solver().read(), sim->solver().read());
    }
  }
}

/// Masses and terms of both backends follow.
TEST(WallCut, BothBackendsMoveAlike) {
  for (const Named& body : bodies_with_walls()) {
    SCOPED_TRACE(body.name);
    std::vector<State> ends;
    double dt = 0.0;  // s, the same for both
    for (const char* backend : {"reference", "cpu"}) {
      Simulation sim(with_spare_particles(body.model, 300), without_material(backend));
      sim.scene().fix(sim.model().particles_in([&](const Vec3& x) { return x.x() < 1e-9; })).gravity({0, 0, -9.81});
      ASSERT_TRUE(sim.cut(cut_plane({0.0, 0.011, 0.0}, {0.1, 1.0, 0.1})));
      const auto last = static_cast<Index>(body.model.cells.size()) - 1;
      sim.remove_cells(std::vector<Index>{last, last - 1, 3});
      if (dt == 0.0) dt = 0.2 * sim.step_limit();
      ASSERT_TRUE(sim.step(200, dt).ok());
      ends.push_back(sim.solver().read());
    }
    EXPECT_LT(largest_distance(ends[0].position, ends[1].position), 2e-5 * body_size(body.model));
  }
}

/// Between a particle and another of a triangle that a cut divides lies the part with more of their side.
TEST(WallCut, BesideATriangleLiesThePartWithMoreOfTheSide) {
  CutSurface slit = cut_plane({0.0, 0.047, 0.0}, {0.03, 1.0, 0.0});
  slit.front = [](const Vec3& x) { return x.x() - 0.05; };
  const Model cut = cut_body(sheet(), slit);
  const TopologyTextures tables = build_topology(cut);
  int ends = 0;
  for (const Cell& part : cut.cells) {
    if (part.share == 1.0) continue;
    for (const Cell& other : cut.cells) {
      if (&other == &part || other.share == 1.0 || cell_centre(other, cut.rest) != cell_centre(part, cut.rest))
        continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const Index a = part.particles[k], b = part.particles[(k + 1) % 3];
        const auto at = [&](Index i) { return std::ranges::find(other.particles, i) != other.particles.end(); };
        if (!at(a) || !at(b)) continue;
        // The first part's share of the side, by where its cut crosses it.
        const double u = part.cuts[0][k], v = part.cuts[0][(k + 1) % 3];
        const double share = u > 0.0 ? u / (u - v) : v / (v - u);
        if (share < 0.5) continue;
        ++ends;
        const Index wanted = part.particles[(k + 2) % 3],
                    unwanted = *std::ranges::find_if(other.particles, [&](Index i) { return i != a && i != b; });
        for (const WallTexel& wall : tables.walls) {
          for (std::size_t side = 0; side < 3; ++side) {
            const Index c = wall.vertex[(side + 1) % 3], d = wall.vertex[(side + 2) % 3];
            if (!((c == a && d == b) || (c == b && d == a)) || wall.vertex[side] == wanted ||
                wall.vertex[side] == unwanted) {
              continue;
            }
            EXPECT_EQ(wall.vertex[3 + side], wanted);
          }
        }
      }
    }
  }
  EXPECT_GT(ends, 0);
}

TEST(WallCut, LeavesTheStepWithinItsLimit) {
  for (const Named& body : bodies_with_walls()) {
    SCOPED_TRACE(body.name);
    Simulation sim(with_spare_particles(body.model, 600), without_material("reference"));
    const Snapshot whole = sim.snapshot();
    const double limit = sim.solver().stable_step();
    const double before = estimate_spectrum(sim.solver().topology(), sim.model().rest).largest;
    std::mt19937 random(5);
    double least = 10.0;
    for (int k = 0; k < 24; ++k) {
      if (k % 3 == 0) sim.restore(whole);
      if (k % 4 == 3) {
        sim.remove_cells(std::vector<Index>{static_cast<Index>(random() % body.model.cells.size())});
      } else if (!sim.cut(plane_through_wall(random, body.model))) {
        continue;
      }
      const TopologyTextures anew = built_anew(sim);
      const double now = estimate_spectrum(anew, anew.rest).largest;
      least = std::min(least, before * std::pow(limit / sim.solver().stable_step(), 2) / now);
    }
    EXPECT_GE(least, 1.0);
  }
}

TEST(WallCut, CapsuleIsCutWithItsBody) {
  const Model model = slab_in_capsule();
  Simulation sim(with_spare_particles(model, 300), without_material("cpu"));
  ASSERT_TRUE(sim.cut(cut_plane({0.031, 0.0, 0.0}, {1.0, 0.2, 0.1})));
  EXPECT_EQ(connected_bodies(sim.model()).size(), 2u);
  EXPECT_NEAR(total_mass(sim.model()) / total_mass(model), 1.0, 1e-12);
  double skin = 0.0, parts = 0.0;  // m^2
  for (const Cell& cell : model.cells) {
    if (cell.type == CellType::triangle) skin += area_vector(cell.particles, model.rest).norm();
  }
  for (const Cell& cell : sim.model().cells) {
    if (cell.type == CellType::triangle) parts += cell.share * area_vector(cell.particles, sim.model().rest).norm();
  }
  EXPECT_NEAR(volume(sim.model(), sim.model().rest) / volume(model, model.rest), 1.0, 1e-12);
  EXPECT_NEAR(parts / skin, 1.0, 1e-12);
}

/// A wall that shares only an edge with a body stays joined to it when the body is cut beside that edge.
TEST(WallCut, WallOnAnEdgeStaysJoined) {
  const Model model = block_with_fin();
  const Model cut = cut_body(model, cut_plane({0.0, 0.007, 0.0}, {0.0, 1.0, 0.0}));
  EXPECT_EQ(connected_bodies(cut).size(), 2u);
  const Model across = cut_body(model, cut_plane({0.022, 0.0, 0.0}, {1.0, 0.0, 0.0}));
  EXPECT_EQ(connected_bodies(across).size(), 2u);
}

TEST(WallCut, SurfaceKeepsItsArea) {
  const Model whole = sheet();
  const Model cut = cut_body(whole, cut_plane({0.052, 0.0, 0.0}, {1.0, 0.2, 0.0}));
  const TissueSurface surface = tissue_surface(cut);
  const VecList place = surface.at(cut.rest);
  double area = 0.0;
  for (const auto& [a, b, c] : surface.triangles) area += 0.5 * (place[b] - place[a]).cross(place[c] - place[a]).norm();
  EXPECT_NEAR(area / (sheet_side * sheet_side), 1.0, 1e-9);
  const TissueSurface capsule = tissue_surface(slab_in_capsule());
  EXPECT_EQ(capsule.triangles.size(), tissue_surface(slab()).triangles.size());
}

TEST(WallCut, RefusesWhatItCannot) {
  Simulation sim(with_spare_particles(sheet(), 3), without_material("cpu"));
  const Snapshot before = sim.snapshot();
  EXPECT_TRUE(says(message_of([&] { sim.cut(cut_plane({0.052, 0.0, 0.0}, {1.0, 0.2, 0.0})); }), "has 3 spare ones"));
  EXPECT_EQ(sim.snapshot(), before);
  std::vector<Index> all(sim.model().cells.size());
  std::iota(all.begin(), all.end(), 0);
  EXPECT_TRUE(says(message_of([&] { sim.remove_cells(all); }), "some cell of the body to be left"));
}

}  // namespace
}  // namespace phymul
