// SPDX-License-Identifier: MIT
//
// A blade that goes into a slab.
#pragma once

#include <phymul/phymul.h>

#include <string>

namespace phymul::test {

/// A slab of 60 x 40 x 20 mm on its lower face, and a blade that goes into it along -x in the plane y = 20.5 mm, with
/// its edge along z.
struct Stroke {
  Simulation sim;
  ToolHandle blade;
  ToolPose pose;

  explicit Stroke(const std::string& backend, double toughness = 0.0, double lowest = 0.005, double young = 1e4,
                  int across = 9, Index spare = 600, int threads = 0, double friction = 0.0, int tick_budget = 0)
      : sim(with_spare_particles(
                make_tetrahedral_block({0.06, 0.04, 0.02}, across, across * 2 / 3, across / 3, 0.25, 7), spare),
            {.material = {young, 0.45, 1000.0},
             .backend = backend,
             .damping = {.rate = 20.0},
             .tick_budget = tick_budget,
             .solver = {.threads = threads}}),
        blade(sim.scene().fix("z0").add_tool(
            "scalpel",
            {.shape = Blade{.width = 0.025 - lowest, .toughness = toughness, .height = 0.01, .friction = friction},
             .pose = first(lowest)})),
        pose(first(lowest)) {}

  static ToolPose first(double lowest) {
    Mat3 axes;
    axes << 0, 0, 1, 0, 1, 0, 1, 0, 0;
    axes.col(1) = axes.col(2).cross(axes.col(0));
    return {.position = {0.062, 0.0205, 0.5 * (0.025 + lowest)}, .orientation = Quaternion(Eigen::Quaterniond(axes))};
  }

  StepReport go_on(double by, double seconds = 1e-3) {
    pose.position.x() -= by;
    blade.move_to(pose);
    return sim.advance(seconds);
  }
};

}  // namespace phymul::test
