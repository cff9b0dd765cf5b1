// SPDX-License-Identifier: MIT
//
// How soft the cells of make_body are in bending: a cantilever, in any direction against the lattice that it is filled
// by, held by its end's surface.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <random>

#include "body_shapes.h"

namespace phymul {
namespace {

using namespace test;

const Vec3 size(0.2, 0.05, 0.05);                 // m
constexpr double far_end = 0.19, lightly = 1e-3;  // m; of the earth's gravity

/// m: mean way of the end under a little of its weight, along the third of `axes`.
double sag(Simulation& sim, const Mat3& axes) {
  sim.scene().gravity(-9.81 * lightly * axes.col(2));
  EXPECT_TRUE(sim.solve_static().converged());
  const State now = sim.state();
  double sum = 0.0, mass = 0.0;
  for (Index i = 0; i < sim.model().particle_count(); ++i) {
    if (axes.col(0).dot(sim.model().rest[i]) < far_end) continue;
    sum -= sim.model().mass[i] * axes.col(2).dot(now.position[i] - sim.model().rest[i]);
    mass += sim.model().mass[i];
  }
  return sum / mass;
}

TEST(FilledBeam, IsALittleTooSoft) {
  const SimulationOptions options{.material = {.young = 10e3, .poisson = 0.3, .density = 1000.0}, .backend = "cpu"};
  Simulation lattice(make_block(size, 48, 12, 12), options);
  lattice.scene().fix("x0");
  const double right = sag(lattice, Mat3::Identity());
  std::mt19937 bits(1);
  std::normal_distribution<double> normal;
  for (int direction = 0; direction < 10; ++direction) {
    const Eigen::Quaterniond turn(normal(bits), normal(bits), normal(bits), normal(bits));
    const Mat3 axes = turn.normalized().toRotationMatrix();
    Surface box = box_surface({0, 0, 0}, size);
    for (Vec3& vertex : box.vertices) vertex = axes * vertex;
    for (const auto& [across, most] : {std::pair{4, 0.065}, {6, 0.045}}) {
      const double spacing = size.y() / across;
      Simulation sim(make_body(box, {.spacing = spacing}), options);
      sim.scene().hold(sample_surface(box, spacing / 3.0, [&](const Vec3& x) { return axes.col(0).dot(x) < 1e-9; }));
      const double softer = sag(sim, axes) / right - 1.0;
      EXPECT_GT(softer, 0.0) << direction << ", " << across;
      EXPECT_LT(softer, most) << direction << ", " << across;
    }
  }
}

}  // namespace
}  // namespace phymul
