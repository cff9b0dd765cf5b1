// SPDX-License-Identifier: MIT
//
// Extreme eigenvalues against those of the dense matrix, and the step that follows from them.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <algorithm>
#include <complex>
#include <limits>

#include "support/bodies.h"
#include "support/dense_operator.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

void expect_spectrum(const TopologyTextures& topology, const VecList& position,
                     const std::vector<std::uint8_t>& fixed = {}) {
  double largest = 0.0, most_negative = 0.0, largest_imaginary = 0.0;
  const Eigen::VectorXcd values = dense_eigenvalues(topology, position, fixed);
  for (const std::complex<double>& value : values) {
    largest = std::max(largest, std::abs(value));
    most_negative = std::min(most_negative, value.real());
    largest_imaginary = std::max(largest_imaginary, std::abs(value.imag()));
  }
  const Spectrum found = estimate_spectrum(topology, position, fixed);
  EXPECT_NEAR(found.largest, largest, 2e-3 * largest);
  // Rigid motions have eigenvalue 0 up to the differences' rounding.
  EXPECT_NEAR(found.most_negative, most_negative, 2e-3 * largest);
  EXPECT_NEAR(found.largest_imaginary, largest_imaginary, 2e-3 * largest);
}

constexpr std::array reactions{Reaction::full, Reaction::shared, Reaction::barycentric, Reaction::averaged,
                               Reaction::conservative};

/// Small bodies of unequal masses, for which Arnoldi's 80 steps are all there are.
std::vector<Model> small_bodies() {
  std::vector<Model> all{make_tetrahedron(0.01), make_block({0.02, 0.01, 0.01}, 2, 1, 1, 26),
                         make_strip(0.02, 0.01, 2, 1, true)};
  for (Model& model : all) {
    for (Index i = 0; i < model.particle_count(); ++i) model.mass[i] = 1.0 + 0.1 * i;
  }
  return all;
}

TEST(Spectrum, IsThatOfTheDenseMatrixForEveryReaction) {
  for (const Model& model : small_bodies()) {
    for (const Reaction reaction : reactions) {
      SCOPED_TRACE(model.name + ", reaction " + std::to_string(static_cast<int>(reaction)));
      const TopologyTextures topology = build_topology(model, {.reaction = reaction});
      expect_spectrum(topology, model.rest);
      expect_spectrum(topology, random_positions(model, 0.1, 3));
    }
  }
}

/// At rest that law's stiffness is taken from its tables, elsewhere from differences of forces.
TEST(Spectrum, OfParticleAverages) {
  std::vector<Model> all{make_block({0.02, 0.01, 0.01}, 2, 1, 1),
                         make_tetrahedral_block({0.02, 0.02, 0.01}, 2, 2, 1, 0.2, 1), make_strip(0.03, 0.02, 3, 2)};
  for (Model& model : all) {
    set_material(model, {10e3, 0.45, 1000.0});
    model.add_group("left", model.particles_in([](const Vec3& X) { return X.x() < 0.0101; }));
    set_material(model, {30e3, 0.3, 1200.0}, "left");
    SCOPED_TRACE(model.name);
    const TopologyTextures topology = build_topology(model, {.law = Law::particle_averaged});
    EXPECT_GT(topology.domains.size(), topology.rest.size());  // materials meet
    expect_spectrum(topology, model.rest);
    expect_spectrum(topology, random_positions(model, 0.05, 3));
    std::vector<std::uint8_t> fixed(model.rest.size(), 0);
    for (const Index i : model.group("x0")) fixed[i] = 5;
    expect_spectrum(topology, model.rest, fixed);
    EXPECT_EQ(estimate_spectrum(topology, model.rest).most_negative, 0.0);
  }
}

TEST(Spectrum, OfParticleAveragesNeedsNoNeighbours) {
  Model model = with_material(make_block({0.02, 0.01, 0.01}, 2, 1, 1), {10e3, 0.3, 1000.0});
  const TopologyOptions options{.law = Law::particle_averaged};
  const double largest = estimate_spectrum(build_topology(model, options), model.rest).largest;
  model.neighbours.offset.assign(model.rest.size() + 1, 0);
  model.neighbours.entry.clear();
  const TopologyTextures bare = build_topology(model, options);
  EXPECT_EQ(estimate_spectrum(bare, model.rest).largest, largest);
  expect_spectrum(bare, random_positions(model, 0.05, 3));
}

TEST(Spectrum, OfASquashedBodyHasFlutterAndGrowth) {
  const Model model = make_block({0.02, 0.01, 0.01}, 2, 1, 1, 26);
  const TopologyOptions options{.reaction = Reaction::full};
  const Spectrum found = estimate_spectrum(build_topology(model, options), random_positions(model, 0.3, 1));
  EXPECT_GT(found.largest_imaginary, 1e-3 * found.largest);
  EXPECT_LT(found.most_negative, -1e-3 * found.largest);
}

TEST(Spectrum, HeldAxesTakeNoPart) {
  const Model model = make_block({0.02, 0.01, 0.01}, 2, 1, 1, 26);
  std::vector<std::uint8_t> fixed(model.rest.size(), 0);
  for (const Index i : model.group("x0")) fixed[i] = 7;
  for (const Index i : model.group("x1")) fixed[i] = 3;
  const TopologyTextures topology = build_topology(model);
  expect_spectrum(topology, model.rest, fixed);
  fixed.assign(fixed.size(), 7);
  fixed[0] = 6;  // one coordinate left
  expect_spectrum(topology, model.rest, fixed);
  fixed[0] = 7;
  EXPECT_EQ(estimate_spectrum(topology, model.rest, fixed).largest, 0.0);
}

TEST(Spectrum, RigidMotionsCountAsZeroAndNotAsGrowth) {
  for (const Body& body : bodies()) {
    EXPECT_EQ(estimate_spectrum(build_topology(body.model), body.model.rest).most_negative, 0.0) << body.name;
  }
}

TEST(Spectrum, WithoutStiffnessIsZeroAndAnyStepIsStable) {
  Model cloud = without_cells(make_tetrahedron(0.01));
  cloud.neighbours.offset.assign(cloud.rest.size() + 1, 0);
  cloud.neighbours.entry.clear();
  const Spectrum found = estimate_spectrum(build_topology(cloud, {.on_sparse = SparseParticle::free}), cloud.rest);
  EXPECT_EQ(found.largest, 0.0);
  EXPECT_EQ(found.most_negative, 0.0);
  EXPECT_EQ(stable_step(found, 1.0), std::numeric_limits<double>::infinity());
}

TEST(Spectrum, StableStepFollowsTheDamping) {
  const Spectrum spectrum{16.0, 0.0, 0.0};
  EXPECT_DOUBLE_EQ(stable_step(spectrum, 1.0), 0.5);
  EXPECT_DOUBLE_EQ(stable_step(spectrum, 0.0), std::sqrt(2.0) / 4.0);
}

TEST(Spectrum, OfAPositionThatIsNotFiniteIsRefused) {
  const Model model = make_tetrahedron(0.01);
  VecList position = model.rest;
  position[2].y() = std::nan("");
  const TopologyTextures topology = build_topology(model);
  EXPECT_TRUE(refuses([&] { estimate_spectrum(topology, position); }, "position of particle 2 is not finite"));
}

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
  Cell list{.type = CellType::poly_vertex};  // of PML: no tissue
  for (Index i = 0; i < model.particle_count(); ++i) list.particles.push_back(i);
  model.cells.push_back(list);
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
}  // namespace phymul::test
