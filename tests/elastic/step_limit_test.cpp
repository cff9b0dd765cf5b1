// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/body.h>
#include <phymul/elasticity.h>
#include <phymul/error.h>
#include <phymul/shapes.h>
#include <phymul/step_limit.h>
#include <phymul/topology.h>

#include <algorithm>

#include "support/message_of.h"

namespace phymul {
namespace {

Model block() {
  Model model = make_block({0.1, 0.1, 0.1}, 8, 8, 8);
  set_material(model, {.young = 5e3, .poisson = 0.3, .density = 1000.0});
  return model;
}

/// Gives the cell at a place another stiffness, and returns its row.
Index stiffen(Model& model, const Vec3& place, double young) {
  const auto at = [&](const Vec3& x) { return (x - place).norm() < 1e-6; };
  set_material(model, {.young = young, .poisson = 0.3, .density = 1000.0}, at);
  return static_cast<Index>(std::ranges::find_if(model.cells,
                                                 [&](const Cell& cell) {
                                                   Vec3 centre = Vec3::Zero();
                                                   for (const Index i : cell.particles) centre += model.rest[i] / 8.0;
                                                   return at(centre);
                                                 }) -
                            model.cells.begin());
}
const Vec3 middle(0.05625, 0.05625, 0.05625), corner(0.00625, 0.00625, 0.00625);  // m, of two cells

TEST(StepLimit, OfAnEvenBlockIsNearlyTheSameWithoutItsCorners) {
  const Model model = block();
  const TopologyTextures topology = build_topology(model);
  const StepLimit limit = describe_limit(model, topology);
  EXPECT_DOUBLE_EQ(limit.stable_step, stable_step(estimate_spectrum(topology, topology.rest), 1.0));
  EXPECT_GE(limit.without, limit.stable_step);
  EXPECT_LT(limit.without, 1.15 * limit.stable_step) << limit.message();
  EXPECT_EQ((StepLimit{.stable_step = 1e-3, .places = {}, .without = 1e-3}.message()),
            "The stable step of 0.001 s is set by the whole body: no single cell stands out.");
}

TEST(StepLimit, NamesAStiffCellAndWhatTheStepWouldBeWithoutIt) {
  const double even = describe_limit(block(), build_topology(block()), 1).stable_step;
  Model model = block();
  const Index stiff = stiffen(model, middle, 500e3);
  const StepLimit limit = describe_limit(model, build_topology(model), 1);
  ASSERT_EQ(limit.places.size(), 1u);
  EXPECT_LT(limit.stable_step, 0.3 * even) << limit.message();
  EXPECT_NEAR(limit.without, even, 0.1 * even) << limit.message();
  EXPECT_EQ(limit.places.front().cell, stiff);
  EXPECT_EQ(limit.places.front().particles, model.cells[stiff].particles);
  EXPECT_GT(limit.places.front().share, 0.8);
  EXPECT_LT((limit.places.front().place - middle).norm(), 1e-9);
  EXPECT_TRUE(says(limit.message(), "is set by cell " + std::to_string(stiff)));
}

TEST(StepLimit, NamesPlacesInTheirOrder) {
  Model model = block();
  const Index worst = stiffen(model, middle, 500e3), next = stiffen(model, corner, 50e3);
  const StepLimit limit = describe_limit(model, build_topology(model), 3);
  ASSERT_GE(limit.places.size(), 2u);
  EXPECT_EQ(limit.places[0].cell, worst);
  EXPECT_EQ(limit.places[1].cell, next);
  EXPECT_GT(limit.places[1].stable_step, 1.5 * limit.places[0].stable_step);
  EXPECT_GT(limit.without, 1.5 * limit.places[1].stable_step);
  EXPECT_TRUE(says(limit.message(), "other place"));
}

TEST(StepLimit, OfAHeldPlaceIsThatOfTheOthers) {
  Model model = block();
  stiffen(model, middle, 500e3);
  const TopologyTextures topology = build_topology(model);
  const StepLimit first = describe_limit(model, topology, 1);
  std::vector<std::uint8_t> fixed(model.rest.size(), 0);
  for (const Index i : first.places.front().particles) fixed[i] = 7;
  EXPECT_DOUBLE_EQ(describe_limit(model, topology, 0, fixed).stable_step, first.without);
}

TEST(StepLimit, OfABodyWithoutStiffnessIsInfinite) {
  Model model = block();
  std::vector<std::uint8_t> fixed(model.rest.size(), 7);
  EXPECT_EQ(describe_limit(model, build_topology(model), 8, fixed).stable_step,
            std::numeric_limits<double>::infinity());
}

TEST(StepLimit, RefusesOtherSizesAndReactionsWithoutVibrations) {
  const Model model = block();
  const TopologyTextures topology = build_topology(model);
  EXPECT_THROW(describe_limit(make_block({0.1, 0.1, 0.1}, 2, 2, 2), topology), Error);
  EXPECT_THROW(describe_limit(model, topology, 8, std::vector<std::uint8_t>(3, 0)), Error);
  Model springs = make_block({0.1, 0.1, 0.1}, 2, 2, 2);
  EXPECT_THROW(describe_limit(springs, build_topology(springs, {.reaction = Reaction::shared})), Error);
}

}  // namespace
}  // namespace phymul
