// SPDX-License-Identifier: MIT
//
// Tools thinner than the spacing: the margin with which they do not slip through, and what it makes of their force.
#include <array>
#include <cmath>
#include <cstdio>

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

}  // namespace
}  // namespace phymul::test
