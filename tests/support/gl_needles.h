// SPDX-License-Identifier: MIT
//
// A needle in a block of gel, on the device beside the reference.
#pragma once

#include "gl_touching_bodies.h"
#include "needle_insertion.h"

namespace phymul::test {

/// The same hole, but for rounding.
inline void expect_like(const NeedleState& a, const NeedleState& b) {
  EXPECT_EQ(a.punctured, b.punctured);
  EXPECT_EQ(a.through, b.through);
  EXPECT_NEAR(a.slip, b.slip, 1e-6);
  ASSERT_EQ(a.hole.size(), b.hole.size());
  for (std::size_t k = 0; k < a.hole.size(); ++k) {
    ASSERT_EQ(a.hole[k].particles, b.hole[k].particles) << k;
    for (std::size_t j = 0; j < a.hole[k].weights.size(); ++j) {
      EXPECT_NEAR(a.hole[k].weights[j], b.hole[k].weights[j], 1e-4) << k << ", " << j;
    }
  }
  EXPECT_EQ(a.shaft.size(), b.shaft.size());
}

/// For a device of a test's own.
inline FloatTools tools_of(const Scene& scene) {
  FloatTools tools(gl::Device::most_steps);
  tools.follow(scene);
  return tools;
}

/// From time 0 on.
inline void begin_batch(gl::Device& device, FloatTools& tools, int steps, double dt) {
  std::vector<double> instants;
  for (int k = 0; k <= steps; ++k) instants.push_back(k * dt);
  tools.begin_batch(steps, dt, 0.0);
  device.begin_batch({.dt = dt, .largest_acceleration = 1e30, .runaway_speed = 1e9}, instants, tools);
}

class BesideNeedle {
 public:
  explicit BesideNeedle(double stiffness, int cells = 4, const Vec3& origin = {0, 0, 0},
                        SolverOptions options = damped(40.0))
      : model(moved(Insertion::gel(cells), origin)), scene(model), tables_(tables_of(model, {})) {
    pose.position = origin + Vec3(0.0203, 0.0197, block_side + offset);
    scene.fix("z0").add_tool("needle", {.shape = bending(stiffness), .pose = pose, .friction = 0.5});
    options.gl.debug = true;
    options.spectrum = estimate_spectrum(*tables_, tables_->rest);
    dt = 0.4 * stable_step(*options.spectrum, 1.0);
    options_ = options;
    device = make();
    reference = make_solver("reference", tables_, scene, options);
  }

  /// Another solver of the scene on the device.
  std::unique_ptr<gl::DeviceSolver> make() const {
    return std::make_unique<gl::DeviceSolver>(GlBackend::compute, tables_, scene, options_);
  }
  SolverOptions& options() { return options_; }

  /// Both to `pose`.
  void go(double seconds) {
    scene.tool("needle").move_to(pose);
    const int steps = std::max(1, static_cast<int>(std::lround(seconds / dt)));
    ASSERT_TRUE(all_step(steps, dt, device, reference));
  }

  Model model;
  Scene scene;
  std::unique_ptr<gl::DeviceSolver> device;
  std::unique_ptr<Solver> reference;
  ToolPose pose;
  double dt = 0.0;

 private:
  std::shared_ptr<const TopologyTextures> tables_;
  SolverOptions options_;
};

}  // namespace phymul::test
