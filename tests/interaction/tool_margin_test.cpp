// SPDX-License-Identifier: MIT
//
// Tools thinner than the spacing: the margin with which they do not slip through, and what it makes of their force.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>

#include "support/message_of.h"
#include "support/sanitized.h"
#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double margin_spacing = 8.4e-3;                      // m
constexpr int across = 4, cells_below = 4;                     // cells
constexpr double top_of_block = cells_below * margin_spacing;  // m
const Vec3 middle_of_top(0.5 * across * margin_spacing, 0.5 * across * margin_spacing, top_of_block);

/// Of the pressed body, with every cell cut into so many along each axis.
Model slab(int finer) {
  return with_material(make_block({across * margin_spacing, across * margin_spacing, top_of_block}, across * finer,
                                  across * finer, cells_below * finer),
                       {.young = 6e3, .poisson = 0.45, .density = 1000});
}

struct Pressed {
  double force = 0.0;  // N, upward, at the end
  int unfelt = 0;      // ticks without a force, of those with the tip deeper than a spacing
};

/// A capsule comes down at 0.1 m/s, upright, to `depth`, and stays there for `rest` ticks of 1 ms.
Pressed press(const Model& model, const Vec3& place, double radius, double margin, double depth, int rest) {
  constexpr double speed = 0.1;
  Scene scene(model);
  ToolPose pose{.position = place + (radius + margin) * Vec3::UnitZ()};
  scene.fix("z0").add_tool("rod", {.shape = Capsule{radius, 0.1}, .pose = pose, .friction = 0.1, .margin = margin});
  const auto solver = make_solver("cpu", model, scene, {}, damped(50.0));
  const int steps = static_cast<int>(std::ceil(1e-3 / (0.4 * solver->stable_step())));
  const ToolHandle rod = scene.tool("rod");
  // The lower end of the rod itself goes to the depth, not that of its margin.
  const double lowest = top_of_block - depth + radius;
  Pressed seen;
  int at_rest = 0;
  while (at_rest < rest) {
    pose.position.z() = std::max(lowest, pose.position.z() - 1e-3 * speed);
    at_rest += pose.position.z() == lowest ? 1 : 0;
    rod.move_to(pose);
    const StepReport report = solver->step(steps, 1e-3 / steps);
    EXPECT_TRUE(report.ok()) << report.message();
    if (!report.ok()) break;
    const ToolForce& on_rod = solver->tool_force(rod);
    seen.unfelt += pose.position.z() < top_of_block - margin_spacing && on_rod.mean_force.norm() == 0.0 ? 1 : 0;
    seen.force = on_rod.mean_force.z();
  }
  return seen;
}

TEST(ToolMargin, IsTheLargestCoveringRadiusLessTheShapesOwn) {
  const Model block = make_block({0.03, 0.03, 0.03}, 3, 3, 3);  // right triangles with legs of 10 mm
  const double covering = 0.01 / std::sqrt(2.0);
  EXPECT_NEAR(least_margin(block, Sphere{0.002}), 1.25 * covering - 0.002, 1e-12);
  EXPECT_NEAR(least_margin(block, Capsule{0.002, 0.1}, 1.5), 1.5 * covering - 0.002, 1e-12);
  EXPECT_NEAR(least_margin(block, Box{{0.01, 0.003, 0.02}}), 1.25 * covering - 0.003, 1e-12);
  EXPECT_NEAR(least_margin(block, make_distance_grid(block, 0.005)), 1.25 * covering, 1e-12);
  EXPECT_EQ(least_margin(block, Sphere{0.02}), 0.0);
  EXPECT_EQ(least_margin(block, HalfSpace{}), 0.0);
  EXPECT_EQ(least_margin(block, Needle{}), 0.0);
  for (const double stretch : {0.0, -1.0, std::nan("")}) {
    EXPECT_TRUE(refuses([&] { least_margin(block, Sphere{0.002}, stretch); }, "stretch above 0"));
  }
  const Model points = without_cells(block);
  EXPECT_TRUE(refuses([&] { least_margin(points, Sphere{0.002}); }, "body with a surface"));
}

/// Against a search through each kind of triangle.
TEST(ToolMargin, CoversEveryPointOfATriangle) {
  Model model;
  model.rest = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  model.mass = model.stiffness = {1, 1, 1};
  model.neighbours.offset = {0, 0, 0, 0};
  model.cells.resize(1);
  model.cells[0].type = CellType::triangle;
  model.cells[0].particles = {0, 1, 2};
  for (const Vec3& apex : {Vec3(0.5, 0.8, 0), Vec3(0.3, 0.9, 0.2), Vec3(0, 1, 0), Vec3(0.5, 0.1, 0), Vec3(0.2, 0.1, 0),
                           Vec3(-0.7, 0.4, 0), Vec3(1.9, 0.3, 0)}) {
    model.rest[2] = apex;
    double farthest = 0.0;
    for (int i = 0; i <= 400; ++i) {
      for (int j = 0; i + j <= 400; ++j) {
        const Vec3 at = i / 400.0 * model.rest[1] + j / 400.0 * apex;
        double nearest = INFINITY;
        for (const Vec3& corner : model.rest) nearest = std::min(nearest, (at - corner).norm());
        farthest = std::max(farthest, nearest);
      }
    }
    EXPECT_NEAR(least_margin(model, Sphere{1e-9}, 1.0), farthest, 0.004) << apex.transpose();
  }
}

/// Places on the face of a cell: over a particle, on edges, inside of either triangle.
const std::array<Vec3, 6> places{Vec3(0, 0, 0),     Vec3(0.5, 0, 0),    Vec3(0.5, 0.5, 0),
                                 Vec3(0.3, 0.2, 0), Vec3(0.7, 0.85, 0), Vec3(0.25, 0.75, 0)};

TEST(ToolMargin, NoRodPassesUnfelt) {
  const Model model = slab(1);
  int through = 0;
  for (const double radius : {0.0005, 0.0025, 0.005, 0.008}) {
    const double margin = least_margin(model, Capsule{radius, 0.1});
    for (const Vec3& place : places) {
      const Pressed with = press(model, middle_of_top + margin_spacing * place, radius, margin, 0.025, 1);
      EXPECT_EQ(with.unfelt, 0) << radius << " m at " << place.transpose();
      EXPECT_GT(with.force, 0.1) << radius << " m at " << place.transpose();
      through += press(model, middle_of_top + margin_spacing * place, radius, 0.0, 0.025, 1).force == 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(through, 5);  // without it, this is what they do
}

/// The table of docs/measurements/tools.md: force on a rod 8 mm deep over that on a body of a sixth of the spacing, by
/// margin.
TEST(ToolMargin, ForceOverThatOnAFineBody) {
  const Model coarse = slab(1), fine = slab(sanitized ? 2 : 6);  // the table is of the latter
  std::printf("| radius, mm | on the fine body, N | no margin, mm | half | least_margin | with stretch 2 |\n");
  for (const double radius : {0.0025, 0.005, 0.008}) {
    const double full = least_margin(coarse, Capsule{radius, 0.1});
    const double truth = press(fine, middle_of_top + margin_spacing * places[3], radius,
                               least_margin(fine, Capsule{radius, 0.1}), 0.008, 100)
                             .force;
    const std::array<double, 4> margins{0.0, 0.5 * full, full, least_margin(coarse, Capsule{radius, 0.1}, 2.0)};
    std::array<double, 4> least{INFINITY, INFINITY, INFINITY, INFINITY}, most{};
    for (const Vec3& place : places) {
      for (std::size_t k = 0; k < margins.size(); ++k) {
        const double ratio =
            press(coarse, middle_of_top + margin_spacing * place, radius, margins[k], 0.008, 100).force / truth;
        least[k] = std::min(least[k], ratio);
        most[k] = std::max(most[k], ratio);
      }
    }
    std::printf("| %.1f | %.2f |", 1e3 * radius, truth);
    for (std::size_t k = 0; k < margins.size(); ++k) {
      std::printf(" %.1f: %.2f to %.2f |", 1e3 * margins[k], least[k], most[k]);
    }
    std::printf("\n");
    EXPECT_GT(least[2], 0.0);
  }
}

// Tools that draw tissue (Tool::suction).

constexpr double cube_side = 0.02;

using Suction = WithTools;
PHYMUL_ON_EVERY_BACKEND(Suction);

/// A step of a free body at rest: each particle gets its share, and the tool feels them all.
TEST_P(Suction, IsSharedByMassAndDistance) {
  const Model model = soft_block({cube_side, cube_side, cube_side}, 4, 4, 4);
  const Vec3 mouth(0.009, 0.008, cube_side + 0.004);
  constexpr double radius = 0.002, reach = 0.008, suction = 0.3, dt = 1e-4;
  Scene scene(model);
  scene.add_tool("tube",
                 {.shape = Sphere{radius}, .pose = {.position = mouth}, .suction = suction, .suction_reach = reach});
  const auto solver = make(model, scene);
  const double felt = balanced_step(*solver, {"tube"}, dt);
  double mass = 0.0;  // kg, within reach
  const auto gap = [&](Index i) { return (model.rest[i] - mouth).norm() - radius; };
  for (Index i = 0; i < model.particle_count(); ++i) mass += gap(i) < reach ? model.mass[i] : 0.0;
  Vec3 total = Vec3::Zero();
  int drawn = 0;
  const State after = solver->read();
  for (Index i = 0; i < model.particle_count(); ++i) {
    const double weight = std::max(0.0, 1.0 - gap(i) / reach);
    const Vec3 force = suction * model.mass[i] / mass * weight * (mouth - model.rest[i]).normalized();
    EXPECT_LE((after.position[i] - model.rest[i] - dt * dt / model.mass[i] * force).norm(), 1e-10) << i;
    total += force;
    drawn += weight > 0.0;
  }
  EXPECT_GT(drawn, 10);
  EXPECT_NEAR(felt, total.norm(), 1e-6 * suction);
  EXPECT_LT(felt, suction);
  EXPECT_EQ(solver->tool_force("tube").particles, 0) << "pressed or held";
}

/// Not even in the step in which it alone makes it touch.
TEST_P(Suction, DrawsNothingIntoTheTool) {
  const Model model = soft_block({cube_side, cube_side, cube_side}, 4, 4, 4);
  Scene scene = Scene(model).fix("z0");
  scene.add_tool("cup", {.shape = Box{{0.02, 0.02, 0.002}},
                         .pose = {.position = {0.01, 0.01, cube_side + 0.0023}},
                         .suction = 0.1,
                         .suction_reach = 0.002});
  const auto solver = make(model, scene, {.damping = {.rate = 20.0}});
  const double dt = 0.3 * solver->stable_step();
  for (int step = 0; step < 60; ++step) {
    ASSERT_TRUE(solver->step(1, dt).ok());
    const State state = solver->read();
    for (const Index i : model.group("z1")) ASSERT_LE(state.position[i].z(), cube_side + 0.0003 + 1e-8) << step;
  }
  EXPECT_EQ(solver->tool_force("cup").particles, 25);
}

/// It draws the tissue to the tool, holds it there while the tool goes away, and lets go above its force.
TEST_P(Suction, LiftsTissueUpToItsForce) {
  const Model model = soft_block({cube_side, cube_side, cube_side}, 6, 6, 6);
  const auto lifted = [&](double suction, double rise) {
    Scene scene = Scene(model).fix("z0");
    scene.add_tool("tube", {.shape = Sphere{0.004},
                            .pose = {.position = {0.01, 0.01, cube_side + 0.0045}},
                            .friction = 0.3,
                            .suction = suction,
                            .suction_reach = 0.003});
    const auto solver = make(model, scene, {.damping = 20.0});
    const double dt = 0.4 * solver->stable_step();
    EXPECT_TRUE(solver->step(200, dt).ok());
    scene.tool("tube").move_to({.position = {0.01, 0.01, cube_side + 0.0045 + rise}});
    EXPECT_TRUE(solver->step(600, dt).ok());
    EXPECT_TRUE(solver->step(200, dt).ok());
    const State state = solver->read();
    double top = 0.0;
    for (const Vec3& x : state.position) top = std::max(top, x.z());
    return std::pair(top - cube_side, solver->tool_force("tube").mean_force.z());
  };
  const auto [height, force] = lifted(2.0, 0.002);
  EXPECT_GT(height, 0.0022) << "in contact: the tool was 0.5 mm above";
  EXPECT_LT(force, -0.02);
  EXPECT_GT(force, -2.0);
  const auto [left, none] = lifted(0.02, 0.006);
  EXPECT_LT(left, 1e-4) << "torn off";
  EXPECT_EQ(none, 0.0);
}

TEST(SuctionOptions, AreThoseOfTheSnapshot) {
  const Tool tube{.shape = Sphere{1e-3}, .pose = {.position = {0, 0, 0.1}}, .suction = 0.05, .suction_reach = 2e-3};
  for (const auto& change : {std::function([](Tool& tool) { tool.suction = 0.0; }),
                             std::function([](Tool& tool) { tool.suction_reach = 3e-3; })}) {
    Simulation sim(soft_block({cube_side, cube_side, cube_side}, 2, 2, 2), {.backend = "reference"});
    sim.scene().add_tool("tube", tube);
    const Snapshot before = sim.snapshot();
    Tool other = tube;
    change(other);
    sim.scene().remove_tool("tube").add_tool("tube", other);
    EXPECT_TRUE(says(message_of([&] { sim.unrecorded_solver().restore(before); }), "is tool \"tube\""));
    sim.restore(before);
    EXPECT_EQ(sim.scene().tools()[0].tool.suction, 0.05);
    EXPECT_EQ(sim.scene().tools()[0].tool.suction_reach, 2e-3);
  }
}

TEST(SuctionOptions, WhatMakesNoSenseIsRefused) {
  const Model model = soft_block({cube_side, cube_side, cube_side}, 2, 2, 2);
  Scene scene(model);
  const auto message = [&](const Tool& tool) { return message_of([&] { scene.add_tool("tube", tool); }); };
  EXPECT_TRUE(says(message({.shape = Sphere{1e-3}, .suction = -1}), "suction (N), 0 or more; got -1"));
  EXPECT_TRUE(says(message({.shape = Sphere{1e-3}, .suction = 1}), "a suction reach above 0 m, got 0"));
  EXPECT_TRUE(says(message({.shape = Needle{}, .suction = 1, .suction_reach = 1e-3}), "a suction of 0 N for a needle"));
}

}  // namespace

}  // namespace phymul::test
