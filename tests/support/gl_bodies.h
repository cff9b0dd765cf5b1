// SPDX-License-Identifier: MIT
//
// A block on a GL backend, and what a solver's passes have run. A scene of bodies that touch on the device beside the
// reference.
#pragma once

#include <phymul/distance_grid.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "gl_twins.h"
#include "touching_bodies.h"

namespace phymul::test {

/// A block of soft tissue, 3 x 2 x 2 cm.
class GlBlockTest : public OnBothDevices {
 protected:
  GlBlockTest() : model_(make_block({0.03, 0.02, 0.02}, 6, 4, 4)) { set_material(model_, soft_tissue()); }
  void set_up() override {
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

/// One of each shape, with friction, compliance and margin between them, all of which reach some 5 mm from their
/// position. The half-space less: where it crushes the body, nobody agrees with anybody for long.
inline std::vector<Tool> tools_of_each_shape() {
  return {{.shape = Sphere{0.005}, .friction = 0.4},
          {.shape = Sphere{0.004}, .friction = 0.3, .compliance = 5e-3, .margin = 1e-3},
          {.shape = Capsule{0.005, 0.01}, .friction = 0.5},
          {.shape = HalfSpace{}, .friction = 0.6, .margin = 3e-3},
          {.shape = Box{{0.006, 0.004, 0.005}}, .friction = 0.2},
          {.shape = ball_grid(), .friction = 0.4, .margin = 2.5e-3}};
}

/// Turned upside down, and on by an angle.
inline ToolPose above(const Vec3& at, double angle = 0.0) {
  return {.position = at,
          .orientation = Quaternion(Eigen::AngleAxisd(M_PI + angle, Vec3(0.9, 0.1, -0.2).normalized()))};
}

/// Down into the body's top, on with a speed and a turn, a jump, and out again: 22 calls, or the first of them.
template <class Call>
void drive(const ToolHandle& tool, const Vec3& origin, Call&& call, int calls = 22) {
  for (int k = 0; k < calls; ++k) {
    if (k == 0) tool.move_to(above(origin + Vec3(0.014, 0.011, 0.0235), 0.05));
    if (k == 4) {
      ToolPose on = above(origin + Vec3(0.015, 0.0105, 0.0228), 0.1);
      on.velocity = {0.05, -0.02, -0.02};
      on.spin = {3, -2, 20};
      tool.move_to(on);
    }
    if (k == 12) tool.teleport(above(origin + Vec3(0.016, 0.012, 0.0232), -0.1));
    if (k == 18) tool.move_to(above(origin + Vec3(0.016, 0.01, 0.04)));
    call(k);
  }
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

/// Of those the passes that ran so often.
inline std::vector<std::string> passes_run(Solver& solver, std::int64_t times) {
  std::vector<std::string> names;
  for (const auto& [name, runs] : runs_of(solver)) {
    if (runs == times) names.push_back(name);
  }
  return names;
}

/// The passes of every step of a free body.
inline std::vector<std::string> passes_of(const Model& model, GlBackend backend) {
  const Scene scene(model);
  gl::DeviceSolver solver(backend, tables_of(model, {}), scene, {.profile = true});
  solver.clear_profile();
  EXPECT_TRUE(is_ok(solver.step(10, 0.3 * solver.stable_step())));
  return passes_run(solver, 10);
}

/// Solvers of scenes that have become equal do the same from their rest shapes, by the same passes.
inline void expect_alike(Solver& a, Solver& b, double dt) {
  for (Solver* const solver : {&a, &b}) {
    solver->reset();
    ASSERT_TRUE(solver->step(8, dt).ok());  // what a change makes anew is made
    solver->reset();
    solver->clear_profile();
    ASSERT_TRUE(solver->step(8, dt).ok());
  }
  EXPECT_EQ(runs_of(a), runs_of(b));
  EXPECT_EQ(difference(a.read(), b.read()), "");
}

/// A scene on the device and on the reference.
class BesideReference {
 public:
  BesideReference(const Model& model, const Scene& scene, SolverOptions options, GlBackend backend = GlBackend::compute)
      : tables_(tables_of(model, {})) {
    options.gl.debug = true;
    if (!options.spectrum) options.spectrum = estimate_spectrum(*tables_, tables_->rest);
    dt = 0.4 * stable_step(*options.spectrum, 1.0);
    device = std::make_unique<gl::DeviceSolver>(backend, tables_, scene, options);
    reference = make_solver("reference", tables_, scene, options);
  }

  /// Off the reference by, of the largest motion; after so many steps.
  double off_after(int steps) {
    EXPECT_TRUE(all_step(steps, dt, device, reference));
    const State a = device->read(), b = reference->read();
    return largest_distance(a.position, b.position) / largest_distance(b.position, tables_->rest);
  }

  /// Both from the state of the device, a step each: largest difference of velocities in units of rounding, and the
  /// largest change of a velocity, m/s. Floats know the places of a contact to a few 2^-24 of an edge and of its way,
  /// which is a speed over a step.
  struct OneStep {
    double off = 0.0, change = 0.0;
  };
  OneStep one_step() {
    const State start = device->read();
    device->reset(start);
    reference->reset(start);
    EXPECT_TRUE(all_step(1, dt, device, reference));
    const State a = device->read(), b = reference->read();
    const double way = touching_spacing + largest_distance(start.position, tables_->rest);
    return {largest_distance(a.velocity, b.velocity) * dt / (0x1p-24 * way),
            largest_distance(b.velocity, start.velocity)};
  }

  std::unique_ptr<gl::DeviceSolver> device;
  std::unique_ptr<Solver> reference;
  double dt = 0.0;

 private:
  std::shared_ptr<const TopologyTextures> tables_;
};

}  // namespace phymul::test
