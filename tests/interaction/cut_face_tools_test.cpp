// SPDX-License-Identifier: MIT
//
// Tools with ToolContact::surface on the faces of cuts. The edge of a curved blade, and the surface that it cuts.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "interaction/tool_shape.h"
#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/run_scenes.h"
#include "support/touching_bodies.h"

namespace phymul {
namespace {

using namespace test;

constexpr double cut_cube_side = 0.04;  // m

Model block(double height, int across, int layers) {
  Model model = make_tetrahedral_block({cut_cube_side, cut_cube_side, height}, across + 1, across + 1, layers, 0.25, 7);
  set_material(model, {1e4, 0.3, 1000.0});
  return model;
}

/// Of a block that is cut at this height the cells above.
std::vector<Index> cells_above(const Model& cut) {
  std::vector<Index> found;
  const std::vector<Index> top = cut.group("z1");
  for (const ConnectedBody& part : connected_bodies(cut)) {
    if (std::ranges::find(part.particles, top.front()) != part.particles.end()) found = part.cells;
  }
  return found;
}

/// A block of this height, made by its mesh or by a cut whose upper part is removed; its lower side is held.
Simulation block_to_press(bool cut, double height, int across, const std::string& backend = "cpu") {
  SimulationOptions options;
  options.backend = backend;
  options.damping.rate = 20.0;
  const int layers = across / 2 + 1;
  Model model = cut ? cut_body(block(0.03, across, 3 * layers / 2), cut_plane({0.02, 0.02, height}, {0, 0, 1}))
                    : block(height, across, layers);
  Simulation sim(std::move(model), options);
  if (cut) sim.remove_cells(cells_above(sim.model()));
  sim.scene().fix("z0");
  return sim;
}

/// Above a block of this height, m: a ball whose lowest point is there.
Tool ball_at(double height) {
  return {
      .shape = Sphere{0.008}, .pose = {.position = {0.0205, 0.0195, height + 0.008}}, .contact = ToolContact::surface};
}

/// N: a ball pressed in by 3 mm.
double force_at_rest(bool cut, double height, int across) {
  Simulation sim = block_to_press(cut, height, across);
  const auto ball = sim.scene().add_tool("ball", ball_at(height - 0.003));
  EXPECT_TRUE(sim.solve_static().converged());
  return sim.force_on(ball).force.z();
}

/// What cells of 5 mm are off by at a face that a cut has made, and at half of that.
TEST(CutFaceTools, PressItAsTheSurfaceOfAMesh) {
  for (const double height : {0.0205, 0.022}) {
    const double fine = force_at_rest(false, height, 16);
    EXPECT_NEAR(force_at_rest(true, height, 8), fine, 0.07 * fine);
    EXPECT_NEAR(force_at_rest(true, height, 16), fine, 0.03 * fine);
  }
}

TEST(CutFaceTools, InStepsHaveTheForceOfRest) {
  const double height = 0.0213;
  Simulation sim = block_to_press(true, height, 8);
  Tool tool = ball_at(height);
  const auto ball = sim.scene().add_tool("ball", tool);
  double fastest = 0.0;  // m/s
  for (int tick = 0; tick < 300; ++tick) {
    if (tick < 60) tool.pose.position.z() -= 5e-5;
    ball.move_to(tool.pose);
    ASSERT_TRUE(sim.advance(1e-3).ok());
    for (const Vec3& v : sim.solver().read().velocity) fastest = std::max(fastest, v.norm());
  }
  const double at_rest = force_at_rest(true, height, 8);
  EXPECT_NEAR(sim.force_on(ball).force.z(), at_rest, 0.02 * at_rest);
  EXPECT_LT(fastest, 0.5);  // of light copies too, under a tool of 5 cm/s
}

/// With ToolContact::particles it meets copies that stand beyond the cut.
TEST(CutFaceTools, AreWarnedOfParticlesBeyondACut) {
  const auto warned = [](Simulation& sim) {
    return std::ranges::any_of(
        sim.warnings(), [](const std::string& text) { return text.find("beyond the cut") != std::string::npos; });
  };
  Simulation before = block_to_press(true, 0.0213, 8);
  Tool tool = ball_at(0.0213);
  before.scene().add_tool("ball", tool);
  EXPECT_FALSE(warned(before));
  tool.contact = ToolContact::particles;
  Simulation later(with_spare_particles(block(0.03, 8, 7), 1000));
  later.scene().fix("z0").fix("z1").add_tool("probe", tool);
  EXPECT_FALSE(warned(later));
  later.cut(cut_plane({0.02, 0.02, 0.0213}, {0, 0, 1}));
  EXPECT_TRUE(warned(later));
}

using CutFaceToolsOn = OnEveryBackend;

TEST_P(CutFaceToolsOn, HaveTheForceOfTheReference) {
  double force[2] = {0.0, 0.0};
  for (const bool reference : {true, false}) {
    const double height = 0.0213;
    Simulation sim = block_to_press(true, height, 8, reference ? "reference" : GetParam());
    const auto ball = sim.scene().add_tool("ball", ball_at(height));
    Tool tool = ball_at(height - 0.001);
    const double dt = 0.4 * sim.solver().stable_step();
    ASSERT_TRUE(sim.step(1, dt).ok());
    ball.move_to(tool.pose);
    ASSERT_TRUE(sim.step(60, dt).ok());
    force[reference ? 0 : 1] = sim.force_on(ball).force.z();
  }
  EXPECT_GT(force[0], 0.02);  // N
  EXPECT_NEAR(force[1], force[0], 1e-3 * force[0]);
}

PHYMUL_ON_EVERY_BACKEND(CutFaceToolsOn);

// Candidates of contacts of a body that is cut while it moves: lists of what a cut does not touch stay, and none lacks
// what counts.

/// A plane across the lower block, under the upper one, as far as y.
CutSurface slit_to(double y, double x) {
  CutSurface cut = cut_plane({x, 0.0, 0.0}, {1.0, 0.1, 0.03});
  cut.front = [y](const Vec3& at) { return at.y() - y; };
  return cut;
}

Model block_of_two() {
  Model low = make_tetrahedral_block({0.045, 0.03, 0.02}, 9, 6, 4, 0.2, 4);
  set_material(low, {1e4, 0.3, 1000.0});
  Model high = make_tetrahedral_block({0.02, 0.02, 0.01}, 4, 4, 2, 0.2, 9);
  set_material(high, {1e4, 0.3, 1000.0});
  return joined_bodies(low, moved(std::move(high), {0.0113, 0.0037, 0.0203}));
}

/// A slit that grows, another, cells that go and come, and steps back, while all is shaken; now and then two edits
/// between steps.
TEST(ContactEdits, ListAllThatCounts) {
  const Model whole = block_of_two();
  std::vector<ContactSurface> surfaces;
  Model body = with_spare_particles(whole, 400);
  for (const double y : {0.006, 0.011, 0.017}) {
    surfaces.push_back(make_contact_surface(cut_body(body, slit_to(y, 0.0212))));
  }
  Model crossed = cut_body(cut_body(body, slit_to(0.017, 0.0212)), slit_to(0.012, 0.0391));
  surfaces.push_back(make_contact_surface(crossed));
  std::vector<char> is_there(crossed.rest.size(), 0);
  for (Cell& cell : crossed.cells) {  // a pit, whose bottom is out of reach of the upper block
    Vec3 centre = Vec3::Zero();
    for (const Index i : cell.particles) centre += 0.25 * crossed.rest[i];
    const Vec3 off = (centre - Vec3(0.021, 0.015, 0.02)).cwiseQuotient(Vec3(0.014, 0.02, 0.016));
    if (off.cwiseAbs().maxCoeff() < 1.0 && centre.z() < 0.02) cell.share = 0.0;
    for (const Index i : cell.particles) is_there[i] = is_there[i] != 0 || cell.share > 0.0;
  }
  for (std::size_t i = 0; i < is_there.size(); ++i) crossed.mass[i] *= is_there[i];
  surfaces.push_back(make_contact_surface(crossed));
  std::mt19937 bits(3);
  ContactCandidates candidates;
  const ContactSurface* before = nullptr;
  std::size_t counting = 0, steps = 0, searches = 0, edits = 0;
  const auto shaken = [&](const ContactSurface& surface, const Vec3& by) {
    VecList place = surface.rest;
    for (std::size_t k = 0; k < place.size(); ++k) {
      place[k] += 1e-4 * random_vector(bits, 3) + (surface.particles[k].body == 1 ? by : Vec3(0, 0, 0));
    }
    return place;
  };
  for (const std::size_t row : {0u, 1u, 2u, 3u, 4u, 3u, 4u, 3u, 2u, 1u}) {
    const ContactSurface& surface = surfaces[row];
    candidates.follow(surface, {}, before);
    before = &surface;
    if (++edits % 4 == 3) continue;  // the next edit comes before a step
    for (int step = 0; step < 2; ++step, ++steps) {
      candidates.jump();
      const VecList place = shaken(surface, {0, 0, -3e-5 * static_cast<double>(steps)});
      const Pairs wanted = pairs_that_count(surface, place, {}, 1e-4);
      const std::size_t searched = candidates.searches();
      const Pairs listed = pairs_listed(candidates, place, 1e-4);
      searches += candidates.searches() - searched;
      counting += wanted.size();
      ASSERT_TRUE(std::ranges::includes(listed, wanted)) << row << ", step " << step;
    }
  }
  EXPECT_GT(counting, 1000u);
  EXPECT_LT(searches, steps / 4) << steps;
}

/// A beam comes back that stands out from a wall, over a floor and toward a block which had the floor alone in its
/// lists: no triangle that these have goes.
TEST(ContactEdits, NewTrianglesJoinListsThatStay) {
  constexpr double cell = 0.005;  // m
  Model low = make_tetrahedral_block({6 * cell, 2 * cell, 3 * cell}, 6, 2, 3, 0.0, 1);
  Model high = make_tetrahedral_block({cell, cell, cell}, 1, 1, 1, 0.0, 1);
  for (Model* const model : {&low, &high}) set_material(*model, {1e4, 0.3, 1000.0});
  const Model whole = joined_bodies(low, moved(std::move(high), {0.003, 0.0024, 0.0105}));
  const auto without = [&](auto is_gone) {
    Model model = whole;
    std::vector<char> is_there(model.rest.size(), 0);
    for (Cell& own : model.cells) {
      Vec3 centre = Vec3::Zero();
      for (const Index i : own.particles) centre += 0.25 * model.rest[i];
      const bool of_low = own.particles[0] < low.particle_count();
      if (of_low && centre.x() < 4 * cell && centre.z() > cell && is_gone(centre)) own.share = 0.0;
      for (const Index i : own.particles) is_there[i] = is_there[i] != 0 || own.share > 0.0;
    }
    for (std::size_t i = 0; i < is_there.size(); ++i) model.mass[i] *= is_there[i];
    return make_contact_surface(model);
  };
  const ContactSurface bare = without([](const Vec3&) { return true; });
  const ContactSurface beam = without([](const Vec3& at) { return at.x() < 2 * cell || at.z() < 2 * cell; });
  ContactCandidates candidates;
  candidates.follow(bare, {});
  EXPECT_FALSE(pairs_listed(candidates, bare.rest, 1e-4).empty());
  candidates.follow(beam, {}, &bare);
  const Pairs listed = pairs_listed(candidates, beam.rest, 1e-4), wanted = pairs_that_count(beam, beam.rest, {}, 1e-4);
  EXPECT_TRUE(std::ranges::includes(listed, wanted));
  EXPECT_FALSE(wanted.empty());
  EXPECT_EQ(candidates.searches(), 1u);
}

TEST(BladeCurve, IsUnrolled) {
  for (const double bow : {-0.01, -0.004, 0.0, 0.007, 0.01}) {
    for (const double belly : {-0.003, 0.0, 0.01}) {
      const BladeCurve curve({.width = 0.02, .belly = belly, .bow = bow});
      double length = 0.0;  // of the edge
      for (int k = 0; k < 400; ++k) {
        const double along = curve.length() * ((k + 0.5) / 400 - 0.5);
        const Vec3 off = 0.002 * curve.normal(along), behind(0, 0, 0.005);
        EXPECT_LT((curve.unrolled(curve.at(along) + off + behind) - Vec3(along, 0.002, 0.005)).norm(), 1e-12);
        length += curve.stretch(along) * curve.length() / 400;
        const Vec3 across = curve.at(along + 1e-7) - curve.at(along - 1e-7);
        EXPECT_LT(std::abs(across.normalized().dot(curve.way(along))), 1e-5);
        EXPECT_NEAR(curve.way(along).dot(curve.normal(along)), 0.0, 1e-12);
        EXPECT_LT(curve.way(along).z(), 0.0);
      }
      const Vec3 end = curve.at(0.5 * curve.length());
      EXPECT_LT((end - Vec3(0.01, -bow, belly)).norm(), 1e-12);
      if (bow == 0.0 && belly == 0.01) {
        EXPECT_NEAR(length, 0.01 * std::numbers::pi, 1e-3);
      }
      if (bow == 0.0) continue;
      // Where a whole circle would come back to: the surface is nowhere near.
      const double across = (0.25 * 0.02 * 0.02 / std::abs(bow) + std::abs(bow));
      EXPECT_GT(std::abs(curve.unrolled({1e-4, -std::copysign(across, bow), 0}).y()), 0.4 * across);
    }
  }
}

}  // namespace
}  // namespace phymul
