// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "support/message_of.h"

namespace phymul {
namespace {

/// Two particles of 1 and 3 kg on the x axis, one moving along y, the other along z.
Model pair() {
  Model model;
  model.rest = {Vec3(0, 0, 0), Vec3(4, 0, 0)};
  model.mass = {1.0, 3.0};
  model.stiffness = {1.0, 1.0};
  model.neighbours = RaggedList{{0, 1, 2}, {1, 0}};
  return model;
}

State moving() {
  return {0.5, {Vec3(1, 0, 0), Vec3(5, 0, 0)}, {Vec3(0, 2, 0), Vec3(0, 0, -1)}};
}

TEST(Monitor, MomentaEnergyAndCentreByHand) {
  EXPECT_EQ(linear_momentum(pair(), moving()), Vec3(0, 2, -3));
  EXPECT_EQ(angular_momentum(pair(), moving()), Vec3(0, 15, 2));
  EXPECT_EQ(angular_momentum(pair(), moving(), Vec3(1, 0, 0)), Vec3(0, 12, 0));
  EXPECT_EQ(centre_of_mass(pair(), moving()), Vec3(4, 0, 0));
  EXPECT_EQ(kinetic_energy(pair(), moving()), 0.5 * 1 * 4 + 0.5 * 3 * 1);
}

TEST(Monitor, VolumeFollowsThePositions) {
  const Model block = make_block({1, 2, 3}, 2, 2, 2), strip = make_strip(2, 1, 3, 3);
  EXPECT_NEAR(volume(block, block.rest), 6.0, 1e-14);
  VecList stretched = block.rest;
  for (Vec3& x : stretched) x.z() *= 1.5;
  EXPECT_NEAR(volume(block, stretched), 9.0, 1e-14);
  for (Vec3& x : stretched) x.x() *= -1.0;
  EXPECT_NEAR(volume(block, stretched), -9.0, 1e-14);
  EXPECT_NEAR(volume(strip, strip.rest), 2.0, 1e-14);
}

TEST(Monitor, DisplacementNorms) {
  State state = moving();
  state.position = {Vec3(0, 3, 0), Vec3(4, 0, 4)};
  const DisplacementNorms norms = displacement_norms(pair(), state);
  EXPECT_DOUBLE_EQ(norms.rms, std::sqrt((9.0 + 16.0) / 2));
  EXPECT_EQ(norms.max, 4.0);
  EXPECT_EQ(norms.max_particle, 1);
  EXPECT_EQ(displacement_norms(pair(), rest_state(pair())).max, 0.0);
  state.position[0].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(displacement_norms(pair(), state).max_particle, 0);
}

/// Ten particles in a row whose reference moves particle i by i along z.
struct Row {
  Model model;
  VecList reference;
  Row() {
    for (int i = 0; i < 10; ++i) {
      model.rest.emplace_back(i, 0, 0);
      reference.emplace_back(i, 0, i);
    }
    model.mass.assign(10, 1.0);
    model.stiffness.assign(10, 1.0);
  }
};

TEST(PositionError, ByHand) {
  const Row row;
  VecList position = row.reference;
  position[2].x() += 1.0;   // REN 1/2
  position[5].y() -= 2.0;   // REN 2/5
  position[0].z() += 0.25;  // the reference does not move: no REN
  const PositionError error = position_error(row.model, position, row.reference);
  EXPECT_DOUBLE_EQ(error.global_ratio, std::sqrt((1.0 + 4.0 + 0.0625) / 285.0));
  EXPECT_EQ(error.max, 2.0);
  EXPECT_EQ(error.max_particle, 5);
  EXPECT_EQ(error.p95, 2.0);         // rank 10 of 10
  EXPECT_EQ(error.median_ren, 0.0);  // rank 5 of 0 0 0 0 0 0 0 0.4 0.5
  EXPECT_EQ(error.max_ren, 0.5);
  const std::vector<double> ren = relative_errors(row.model, position, row.reference);
  EXPECT_TRUE(std::isnan(ren[0]));
  EXPECT_DOUBLE_EQ(ren[2], 0.5);
  EXPECT_DOUBLE_EQ(ren[5], 0.4);
  EXPECT_EQ(ren[9], 0.0);
}

TEST(PositionError, SkippedParticlesDoNotCount) {
  const Row row;
  VecList position = row.reference;
  position[2].x() += 1.0;
  position[5].y() -= 2.0;
  std::vector<std::uint8_t> skip(10, 0);
  skip[5] = 1;
  const PositionError error = position_error(row.model, position, row.reference, skip);
  EXPECT_DOUBLE_EQ(error.global_ratio, std::sqrt(1.0 / (285.0 - 25.0)));
  EXPECT_EQ(error.max_particle, 2);
  skip.assign(10, 1);
  const PositionError none = position_error(row.model, position, row.reference, skip);
  EXPECT_EQ(none.max_particle, -1);
  EXPECT_EQ(none.global_ratio, 0.0);
}

TEST(PositionError, PercentilesByNearestRank) {
  Model model;
  VecList position, reference;
  for (int i = 1; i <= 40; ++i) {
    model.rest.emplace_back(i, 0, 0);
    reference.emplace_back(i, 0, 1);
    position.emplace_back(i, 0.01 * (41 - i), 1);
  }
  const PositionError error = position_error(model, position, reference);
  EXPECT_DOUBLE_EQ(error.p95, 0.38);
  EXPECT_DOUBLE_EQ(error.median_ren, 0.20);
  EXPECT_DOUBLE_EQ(error.max, 0.40);
}

TEST(PositionError, ParticlesWithoutMassDoNotCount) {
  const Model whole = make_tetrahedral_block({1, 1, 1}, 3, 3, 3, 0.1, 3), spare = with_spare_particles(whole, 300);
  const auto error_of = [](const Model& model) {
    VecList reference = model.rest, position = model.rest;
    for (std::size_t i = 0; i < model.rest.size(); ++i) {
      if (model.mass[i] == 0.0) continue;
      reference[i].z() += 0.1;
      position[i].z() += 0.1 + 0.001 * static_cast<double>(i);
    }
    return position_error(model, position, reference);
  };
  EXPECT_EQ(error_of(spare).p95, error_of(whole).p95);
  EXPECT_EQ(error_of(spare).global_ratio, error_of(whole).global_ratio);
}

TEST(PositionError, NotANumberIsTheWorst) {
  const Row row;
  VecList position = row.reference;
  position[3].x() = std::numeric_limits<double>::quiet_NaN();
  const PositionError error = position_error(row.model, position, row.reference);
  EXPECT_EQ(error.max_particle, 3);
  EXPECT_TRUE(std::isinf(error.max) && std::isinf(error.global_ratio) && std::isinf(error.max_ren));
}

TEST(PositionError, DoesNotDependOnTheScale) {
  Model model = make_block({1, 1, 1}, 3, 3, 3);
  VecList position = model.rest, reference = model.rest;
  for (Vec3& x : reference) x.z() += 0.1 * x.x();
  for (Vec3& x : position) x.z() += 0.11 * x.x();
  const PositionError error = position_error(model, position, reference);
  for (VecList* list : {&model.rest, &position, &reference}) {
    for (Vec3& x : *list) x *= 1e-6;
  }
  const PositionError scaled = position_error(model, position, reference);
  EXPECT_NEAR(error.global_ratio, 0.1, 1e-12);
  EXPECT_NEAR(scaled.global_ratio, error.global_ratio, 1e-9);
  EXPECT_NEAR(scaled.median_ren, error.median_ren, 1e-9);
  for (VecList* list : {&model.rest, &position, &reference}) {
    for (Vec3& x : *list) x *= 1e-6;  // displacements of 1e-13 m are still displacements
  }
  EXPECT_NEAR(position_error(model, position, reference).median_ren, error.median_ren, 1e-9);
}

TEST(Monitor, SizesMustAgree) {
  const Row row;
  State state = rest_state(row.model);
  state.velocity.pop_back();
  EXPECT_TRUE(refuses([&] { linear_momentum(row.model, state); }, "10 velocities, one per particle, got 9"));
  EXPECT_THROW(kinetic_energy(row.model, state), Error);
  EXPECT_THROW(angular_momentum(row.model, state), Error);
  state.position.pop_back();
  EXPECT_THROW(centre_of_mass(row.model, state), Error);
  EXPECT_THROW(displacement_norms(row.model, state), Error);
  EXPECT_THROW(volume(row.model, state.position), Error);
  EXPECT_THROW(position_error(row.model, state.position, row.reference), Error);
  EXPECT_THROW(position_error(row.model, row.reference, row.reference, std::vector<std::uint8_t>(3)), Error);
  EXPECT_THROW(relative_errors(row.model, row.reference, state.position), Error);
}

TEST(Monitor, FoldedCellsAreTheFlatAndTheInsideOut) {
  for (const Model& model : {make_block({3, 1, 1}, 3, 1, 1), make_tetrahedral_block({3, 1, 1}, 3, 1, 1, 0.1, 2)}) {
    EXPECT_EQ(first_folded_cell(model, model.rest), -1);
    VecList x = model.rest;
    for (Vec3& p : x) p = Vec3(p.x(), 0.01 * p.y() + p.z(), p.z());
    EXPECT_EQ(first_folded_cell(model, x), -1) << "a hundredth of its volume is thin and not folded";
    for (Vec3& p : x) p.y() = p.z();
    EXPECT_EQ(first_folded_cell(model, x), 0);
    x = model.rest;
    for (Vec3& p : x) p.x() = -p.x();
    EXPECT_EQ(first_folded_cell(model, x), 0);
    x = model.rest;
    x[model.cells[2].particles[0]].z() = std::nan("");
    EXPECT_GE(first_folded_cell(model, x), 0) << "a place that is no number";
  }
}

TEST(Monitor, AFoldedCornerFoldsACellOfPositiveVolume) {
  const Model bar = make_block({3, 1, 1}, 3, 1, 1);
  VecList x = bar.rest;
  x.back() = Vec3(2.4, 0.4, 0.4);
  EXPECT_EQ(first_folded_cell(bar, x), 2);
  EXPECT_GT(volume(bar, x), 2.0);
}

TEST(Monitor, FoldedCellsInThePlane) {
  const Model strip = make_strip(2, 1, 2, 1);
  EXPECT_EQ(first_folded_cell(strip, strip.rest), -1);
  VecList x = strip.rest;
  for (Vec3& p : x) p.y() = -p.y();
  EXPECT_EQ(first_folded_cell(strip, x), 0);
  x.pop_back();
  EXPECT_THROW(first_folded_cell(strip, x), Error);
}

}  // namespace
}  // namespace phymul
