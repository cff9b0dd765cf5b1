// SPDX-License-Identifier: MIT
//
// A block on a GL backend, and what a solver's passes have run.
#pragma once

#include <phymul/distance_grid.h>

#include <string>
#include <utility>
#include <vector>

#include "gl_twins.h"

namespace phymul::test {

/// A block of soft tissue, 3 x 2 x 2 cm.
class GlBlockTest : public OnBothDevices {
 protected:
  GlBlockTest() : model_(make_block({0.03, 0.02, 0.02}, 6, 4, 4)) { set_material(model_, soft_tissue()); }
  void SetUp() override {
    OnBothDevices::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    tables_ = tables_of(model_, {});
    options_.damping.rate = 30.0;
    options_.gl.debug = true;
    options_.spectrum = estimate_spectrum(*tables_, tables_->rest);
    dt_ = 0.4 * stable_step(*options_.spectrum, 1.0);
  }
  GlTwins twins(const Scene& scene) const { return {tables_, scene, options_, GetParam()}; }
  std::unique_ptr<gl::DeviceSolver> make(const Scene& scene) const {
    return std::make_unique<gl::DeviceSolver>(GetParam(), tables_, scene, options_);
  }

  /// Copies arrive as the state was; a lost device costs what came after the newest. `untouched`: another solver of the
  /// same scene. Returns the copy.
  State copy_and_lose(gl::DeviceSolver& solver, Solver& untouched) const {
    EXPECT_TRUE(solver.step(20, dt_).ok());
    const State kept = solver.read();
    solver.request_read();
    EXPECT_TRUE(solver.step(20, dt_).ok());
    State copy;
    while (!solver.collect(copy)) {
    }
    EXPECT_EQ(copy, kept);
    solver.context()->mark_lost();
    EXPECT_EQ(solver.step(5, dt_).status, StepStatus::device_lost);
    EXPECT_EQ(solver.read(), kept);
    EXPECT_TRUE(solver.step(20, dt_).ok());
    for (int k = 0; k < 2; ++k) EXPECT_TRUE(untouched.step(20, dt_).ok());
    EXPECT_LE(largest_distance(solver.read().position, untouched.read().position), 1e-9 * body_size(model_));
    return copy;
  }

  Model model_;
  std::shared_ptr<const TopologyTextures> tables_;
  SolverOptions options_;
  double dt_ = 0.0;
};

/// Distances of a ball of 3 mm, up to 2 mm from it along the axes: a margin of more is beyond the grid.
inline std::shared_ptr<const DistanceGrid> ball_grid() {
  constexpr int n = 11;
  std::vector<float> values;
  for (int row = 0; row < n * n * n; ++row) {
    const int i = row % n - 5, j = row / n % n - 5, k = row / (n * n) - 5;
    const Vec3 corner(i, j, k);
    values.push_back(static_cast<float>(1e-3 * corner.norm() - 3e-3));
  }
  return std::make_shared<const DistanceGrid>(Vec3::Constant(-5e-3), 1e-3, std::array<int, 3>{n, n, n}, values);
}

/// What draws or dispatches, and how often; 0 for what runs once a batch, of which the clock makes more or fewer.
inline std::vector<std::pair<std::string, std::int64_t>> runs_of(Solver& solver) {
  std::vector<std::pair<std::string, std::int64_t>> runs;
  for (const PassProfile& pass : solver.profile()) {
    const bool of_batch = pass.name.starts_with("report") || pass.name.starts_with("tool_sums");
    runs.emplace_back(pass.name, of_batch ? 0 : pass.runs);
  }
  return runs;
}

}  // namespace phymul::test
