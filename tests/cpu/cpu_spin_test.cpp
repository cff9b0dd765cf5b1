// SPDX-License-Identifier: MIT
//
// The torque that rounding leaves on a body that is turned without being deformed: what it gains or loses of its spin
// in single precision. docs/measurements/accuracy.md has the formula.
#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <Eigen/Geometry>
#include <cmath>
#include <iostream>

#include "support/bodies.h"

namespace phymul::test {
namespace {

constexpr Material spun_tissue{.young = 10e3, .poisson = 0.3, .density = 1000};
constexpr double most_units = 20.0;  // of the unit below; lattices have 8, tetrahedra 1

Vec3 centre_of(const Model& model) {
  Vec3 sum = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    sum += model.mass[i] * model.rest[i];
    mass += model.mass[i];
  }
  return sum / mass;
}

/// N m: what half a unit in the last place makes of the stabiliser's forces, which cancel in a turn by 1 rad:
/// 2^-24 s mu V.
double unit_of(const TopologyTextures& tables) {
  double sum = 0.0;
  for (const DomainTexel& domain : tables.domains) sum += domain.spread_stiffness / domain.inverse_volume;
  return std::ldexp(sum, -24);
}

/// N m about z on the body turned by `angle`, at rest otherwise.
double torque_at(Solver& solver, double angle, double dt) {
  const Model& model = solver.model();
  const Vec3 centre = centre_of(model);
  const Eigen::AngleAxisd turn(angle, Vec3::UnitZ());
  State state = rest_state(model);
  for (Vec3& x : state.position) x = centre + turn * (x - centre);
  solver.reset(state);
  EXPECT_TRUE(solver.step(1, dt).ok());
  return solver.momentum(centre).angular.z() / dt;
}

struct Turning {
  const char* name;
  Model model;
};

std::vector<Turning> turning() {
  return {{"two cubes", make_block({0.02, 0.01, 0.01}, 2, 1, 1)},
          {"lattice", make_block({0.06, 0.03, 0.03}, 12, 6, 6)},
          {"tetrahedra", make_tetrahedral_block({0.06, 0.03, 0.03}, 12, 6, 6, 0.2, 3)}};
}

TEST(CpuSpin, TheTorqueOfRoundingIsBounded) {
  double worst = 0.0;
  for (const Turning& body : turning()) {
    SCOPED_TRACE(body.name);
    const Model model = with_material(body.model, spun_tissue);
    const Scene scene(model);
    const auto single = make_solver("cpu", model, scene), exact = make_solver("reference", model, scene);
    const double unit = unit_of(single->topology()), dt = 0.1 * exact->stable_step();
    double largest = 0.0;
    for (int k = 1; k <= 60; ++k) {
      const double angle = 0.05 * k, turn = 2.0 * std::sin(0.5 * angle);
      largest = std::max(largest, std::abs(torque_at(*single, angle, dt)) / (unit * turn));
      EXPECT_LT(std::abs(torque_at(*exact, angle, dt)), 1e-6 * unit * turn) << angle;
    }
    EXPECT_LT(largest, most_units);
    std::cout << body.name << ": at most " << largest << " of 2^-24 s mu V 2 sin(angle / 2)\n";
    worst = std::max(worst, largest);
  }
  EXPECT_GT(worst, 0.1) << "or the unit is none";
}

/// A free body that turns by 0.8 rad in 8 s: slow enough to show it.
TEST(CpuSpin, ASlowSpinDriftsNoFasterThanThatTorque) {
  const Model model = with_material(turning().front().model, spun_tissue);
  const Scene scene(model);
  const Vec3 centre = centre_of(model);
  const double rate = 0.1, time = 8.0, dt = 1e-3;
  for (const char* backend : {"reference", "cpu"}) {
    const auto solver = make_solver(backend, model, scene);
    State state = rest_state(model);
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      state.velocity[i] = rate * Vec3::UnitZ().cross(model.rest[i] - centre);
    }
    solver->reset(state);
    const double before = solver->momentum(centre).angular.z();
    ASSERT_TRUE(solver->step(static_cast<int>(time / dt), dt).ok());
    const double gained = std::abs(solver->momentum(centre).angular.z() - before);
    const double bound = most_units * unit_of(solver->topology()) * rate * time;
    std::cout << backend << ": " << gained / before << " of its momentum, bound " << bound * time / before << '\n';
    EXPECT_LT(gained, solver->name() == "cpu" ? bound * time : 1e-9 * before);
  }
}

}  // namespace
}  // namespace phymul::test
