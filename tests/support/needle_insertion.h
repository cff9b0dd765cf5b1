// SPDX-License-Identifier: MIT
//
// A needle that goes into a block, step by step: what tests of needles share.
#pragma once

#include <algorithm>
#include <cmath>

#include "tool_backends.h"

namespace phymul::test {

inline constexpr double block_side = 0.04, offset = 0.5e-3;  // m: of the block; of the tip above it at first

inline Needle thin_needle() {
  return {.length = 0.1,
          .radius = 0.6e-3,
          .puncture = 0.4,
          .cutting = 0.15,
          .static_friction = 12.0,
          .kinetic_friction = 10.0,
          .spread = 0.012};
}

/// The same with a shaft of this bending stiffness, N m^2; 0: one that does not bend.
inline Needle bending(double stiffness) {
  Needle needle = thin_needle();
  needle.bending_stiffness = stiffness;
  return needle;
}

/// Where a node of a hole is.
inline Vec3 place_of(const NeedleNode& node, const State& state) {
  Vec3 place = Vec3::Zero();
  for (std::size_t k = 0; k < node.particles.size(); ++k) place += node.weights[k] * state.position[node.particles[k]];
  return place;
}

/// A needle over the middle of a block whose bottom is held, off the lattice's lines.
struct Insertion {
  Model model;
  Scene scene;
  std::unique_ptr<Solver> solver;
  double dt;
  ToolPose pose{.position = {0.0203, 0.0197, block_side + offset}};

  Insertion(const std::string& backend, int cells, double share, const Needle& needle = thin_needle())
      : model(gel(cells)), scene(model) {
    scene.fix("z0").add_tool("needle", {.shape = needle, .pose = pose, .friction = 0.5});
    solver = make_solver(backend, model, scene, {}, damped(40.0));
    dt = share * solver->stable_step();
  }
  static Model gel(int cells) {
    return with_material(make_block({block_side, block_side, block_side}, cells, cells, cells),
                         {.young = 10e3, .poisson = 0.45, .density = 1000.0});
  }

  /// Mean force on the hub along the shaft over each of `parts` equal parts of the way; up is against insertion.
  std::vector<double> go(double depth, double speed, int parts) {
    const double from = pose.position.z(), to = block_side - depth;
    std::vector<double> force;
    for (int k = 1; k <= parts; ++k) {
      pose.position.z() = from + (to - from) * k / parts;
      scene.tool("needle").move_to(pose);
      const double seconds = std::abs(to - from) / parts / speed;
      EXPECT_TRUE(is_ok(solver->step(std::max(1, static_cast<int>(std::lround(seconds / dt))), dt)));
      force.push_back(solver->tool_force("needle").mean_force.z());
    }
    return force;
  }

  /// The same 20 mm deep and out again, by millimetres.
  std::vector<double> go_in_and_out() {
    std::vector<double> all = go(0.020, 0.1, 20);
    const std::vector<double> out = go(-offset, 0.1, 20);
    all.insert(all.end(), out.begin(), out.end());
    return all;
  }
};

/// Largest difference of two curves over the largest force of both.
inline double apart(const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0.0, most = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    difference = std::max(difference, std::abs(a[k] - b[k]));
    most = std::max({most, std::abs(a[k]), std::abs(b[k])});
  }
  return difference / most;
}

}  // namespace phymul::test
