// SPDX-License-Identifier: MIT
//
// Needles with their defaults: where the tissue gives way does not depend on the mesh, and no cell turns inside out.
#include <algorithm>
#include <map>

#include "support/tool_backends.h"

namespace phymul::test {
namespace {

constexpr double side = 0.072;           // m, of a block
constexpr double spread = 34 * 0.64e-3;  // m, of the default needle
constexpr double part = 5e-5;            // m, of the way in a call

/// A needle over the middle of a block whose bottom is held, off the lattice's lines.
struct Default {
  Model model;
  Scene scene;
  std::unique_ptr<Solver> solver;
  double depth = 0.0;  // m, of the tip below the block's top
  double most = 0.0;   // N on the hub before the puncture
  int gave_way = 0;    // StepReport::tissue_gave_way
  double speed;        // m/s

  Default(double spacing, double young, const Needle& needle = {}, double poisson = 0.45, double at_speed = 0.03)
      : model(block(spacing, {.young = young, .poisson = poisson, .density = 1000.0})), scene(model), speed(at_speed) {
    scene.fix("z0").add_tool("needle", {.shape = needle, .pose = pose(), .friction = 0.3});
    solver = make_solver("cpu", model, scene, {}, damped(40.0));
  }
  static Model block(double spacing, const Material& material) {
    const int cells = static_cast<int>(std::lround(side / spacing));
    return with_material(make_block({side, side, side}, cells, cells, cells), material);
  }
  ToolPose pose() const { return {.position = {0.5 * side + 0.3e-3, 0.5 * side - 0.2e-3, side - depth}}; }
  bool punctured() const { return solver->read().tools.at(0).needle.punctured; }

  /// Deeper until it has punctured, or as deep as `deepest`. False where a cell is beyond the law.
  bool go(double deepest, bool to_puncture) {
    const double dt = 0.4 * solver->stable_step();
    while (depth < deepest && !(to_puncture && punctured())) {
      depth += part;
      scene.tool("needle").move_to(pose());
      const StepReport report = solver->step(std::max(1, static_cast<int>(std::lround(part / speed / dt))), dt);
      EXPECT_TRUE(is_ok(report));
      gave_way += report.tissue_gave_way;
      if (report.beyond_law > 0 || report.inverted > 0) return false;
      if (to_puncture) most = std::max(most, solver->tool_force("needle").force.z());
    }
    return true;
  }
};

TEST(NeedlePuncture, IsThatOfFinerMeshes) {
  for (const double young : {2e3, 5e3, 20e3}) {
    std::vector<double> force, depth;
    for (const double spacing : {9e-3, 6e-3, 4e-3, 3e-3}) {
      Default needle(spacing, young);
      ASSERT_TRUE(needle.go(0.03, true)) << young << ", " << spacing;
      ASSERT_TRUE(needle.punctured()) << young << ", " << spacing;
      // Which of the two came first.
      EXPECT_EQ(needle.gave_way, young < 10e3 ? 1 : 0) << young;
      force.push_back(needle.most);
      depth.push_back(needle.depth);
    }
    const auto [least_force, most_force] = std::ranges::minmax(force);
    const auto [least_depth, most_depth] = std::ranges::minmax(depth);
    RecordProperty("force_" + std::to_string(static_cast<int>(young)), std::to_string(most_force));
    RecordProperty("depth_" + std::to_string(static_cast<int>(young)), std::to_string(most_depth));
    EXPECT_LE(most_force, 1.15 * least_force) << young;
    EXPECT_LE(most_depth, 1.15 * least_depth) << young << ": " << least_depth << " to " << most_depth;
    EXPECT_NEAR(most_force, std::min(2.0, young * spread * spread / (1.25 + 0.6 + 0.085)), 0.05 * most_force) << young;
  }
}

TEST(NeedlePuncture, TurnsNoCellInsideOut) {
  for (const double poisson : {0.3, 0.45, 0.49}) {
    for (const double given : {0.0, 0.008}) {  // m
      for (const double spacing : {9e-3, 6e-3, 4e-3}) {
        SCOPED_TRACE(testing::Message() << poisson << ", " << given << ", " << spacing);
        Default needle(spacing, 5e3, {.spread = given}, poisson, 0.1);
        EXPECT_TRUE(needle.go(0.04, false));
        EXPECT_TRUE(needle.punctured());
        EXPECT_EQ(first_folded_cell(needle.model, needle.solver->read().position), -1);
      }
    }
  }
}

/// The limit follows the tissue's present stiffness.
TEST(NeedlePuncture, IsLaterInTissueThatWasMadeStiffer) {
  Default soft(9e-3, 4e3), stiff(9e-3, 4e3);
  stiff.scene.scale_stiffness(2.0);
  ASSERT_TRUE(soft.go(0.03, true) && stiff.go(0.03, true));
  EXPECT_NEAR(stiff.most / soft.most, 2.0, 0.1);
}

}  // namespace
}  // namespace phymul::test
