// SPDX-License-Identifier: MIT
//
// Tools with ToolContact::surface on the faces of cuts.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>

#include "support/bodies.h"
#include "support/every_backend.h"

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

}  // namespace
}  // namespace phymul
