// SPDX-License-Identifier: MIT
//
// Tools thinner than the spacing: the margin with which they do not slip through, and what it makes of their force.
#include <array>
#include <cmath>
#include <cstdio>

#include "message_of.h"
#include "tool_backends.h"

namespace phymul::test {
namespace {

constexpr double spacing = 8.4e-3;      // m
constexpr int across = 8, high = 5;     // cells
constexpr double top = high * spacing;  // m
const Vec3 middle(0.5 * across * spacing, 0.5 * across * spacing, top);

/// Of the pressed body, with every cell cut into so many along each axis.
Model slab(int finer) {
  Model model = make_block({across * spacing, across * spacing, top}, across * finer, across * finer, high * finer);
  set_material(model, {.young = 6e3, .poisson = 0.45, .density = 1000});
  return model;
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
  SolverOptions options;
  options.damping.rate = 50.0;
  const auto solver = make_solver("cpu", model, scene, {.cell_average = 0.9}, options);
  const int steps = static_cast<int>(std::ceil(1e-3 / (0.4 * solver->stable_step())));
  const ToolHandle rod = scene.tool("rod");
  // The lower end of the rod itself goes to the depth, not that of its margin.
  const double lowest = top - depth + radius;
  Pressed seen;
  int at_rest = 0;
  while (at_rest < rest) {
    pose.position.z() = std::max(lowest, pose.position.z() - 1e-3 * speed);
    at_rest += pose.position.z() == lowest ? 1 : 0;
    rod.pose(pose);
    const StepReport report = solver->step(steps, 1e-3 / steps);
    EXPECT_TRUE(report.ok()) << report.message();
    if (!report.ok()) break;
    const ToolForce& on_rod = solver->tool_force(rod);
    seen.unfelt += pose.position.z() < top - spacing && on_rod.mean_force.norm() == 0.0 ? 1 : 0;
    seen.force = on_rod.mean_force.z();
  }
  return seen;
}

TEST(ToolMargin, IsTheLargestCoveringRadiusLessTheShapesOwn) {
  const Model block = make_block({0.03, 0.03, 0.03}, 3, 3, 3);  // right triangles with legs of 10 mm
  const double covering = 0.01 / std::sqrt(2.0);
  EXPECT_NEAR(least_margin(block, Sphere{0.002}), covering - 0.002, 1e-12);
  EXPECT_NEAR(least_margin(block, Capsule{0.002, 0.1}, 1.5), 1.5 * covering - 0.002, 1e-12);
  EXPECT_NEAR(least_margin(block, Box{{0.01, 0.003, 0.02}}), covering - 0.003, 1e-12);
  EXPECT_NEAR(least_margin(block, make_distance_grid(block, 0.005)), covering, 1e-12);
  EXPECT_EQ(least_margin(block, Sphere{0.02}), 0.0);
  EXPECT_EQ(least_margin(block, HalfSpace{}), 0.0);
  EXPECT_EQ(least_margin(block, Needle{}), 0.0);
  for (const double stretch : {0.0, -1.0, std::nan("")}) {
    EXPECT_NE(message_of([&] { least_margin(block, Sphere{0.002}, stretch); }).find("stretch above 0"),
              std::string::npos);
  }
  Model points = block;
  points.cells.clear();
  EXPECT_NE(message_of([&] { least_margin(points, Sphere{0.002}); }).find("body with a surface"), std::string::npos);
}

/// Against a search through each kind of triangle.
TEST(ToolMargin, CoversEveryPointOfATriangle) {
  Model model;
  model.rest = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  model.mass = {1, 1, 1};
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
    EXPECT_NEAR(least_margin(model, Sphere{1e-9}), farthest, 0.004) << apex.transpose();
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
      const Pressed with = press(model, middle + spacing * place, radius, margin, 0.025, 1);
      EXPECT_EQ(with.unfelt, 0) << radius << " m at " << place.transpose();
      EXPECT_GT(with.force, 0.0) << radius << " m at " << place.transpose();
      through += press(model, middle + spacing * place, radius, 0.0, 0.025, 1).force == 0.0;
      std::printf("%g %g %g: %d %.4f\n", radius, place.x(), place.y(), with.unfelt, with.force);
    }
  }
  EXPECT_GT(through, 5);  // without it, this is what they do
}

/// The table of docs/tools.md: force on a rod 8 mm deep over that on a body of a third of the spacing, by margin.
TEST(ToolMargin, ForceOverThatOfAFineBody) {
  const Model coarse = slab(1), fine = slab(3);
  std::printf(
      "| radius, mm | fine, N | no margin | half of it | least_margin, mm | with it |\n|---|---|---|---|---|---|\n");
  for (const double radius : {0.0025, 0.004, 0.005, 0.008}) {
    const double full = least_margin(coarse, Capsule{radius, 0.1});
    EXPECT_EQ(least_margin(fine, Capsule{radius, 0.1}), 0.0);
    std::array<double, 3> least{INFINITY, INFINITY, INFINITY}, most{};
    double truth = 0.0;
    for (const Vec3& place : places) {
      truth += press(fine, middle + spacing * place, radius, 0.0, 0.008, 150).force / places.size();
      for (std::size_t k = 0; k < 3; ++k) {
        const double force =
            press(coarse, middle + spacing * place, radius, 0.5 * static_cast<double>(k) * full, 0.008, 150).force;
        least[k] = std::min(least[k], force);
        most[k] = std::max(most[k], force);
      }
    }
    std::printf("| %.1f | %.3f | %.2f to %.2f | %.2f to %.2f | %.1f | %.2f to %.2f |\n", 1e3 * radius, truth,
                least[0] / truth, most[0] / truth, least[1] / truth, most[1] / truth, 1e3 * full, least[2] / truth,
                most[2] / truth);
  }
}

}  // namespace
}  // namespace phymul::test
