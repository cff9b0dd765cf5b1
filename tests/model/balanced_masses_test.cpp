// SPDX-License-Identifier: MIT
//
// Masses that set_material moves to light particles (Model::most_mass_moved).
#include <gtest/gtest.h>
#include <phymul/elasticity.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "support/bodies.h"
#include "support/dense_operator.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

constexpr Material of_an_organ{.young = 5e3, .poisson = 0.45, .density = 1000};

Model organ(double most_moved, double spacing = 0.012) {
  Model model = make_body(solid_ellipsoid({0, 0, 0}, {0.05, 0.035, 0.03}), {.spacing = spacing});
  model.most_mass_moved = most_moved;
  set_material(model, of_an_organ);
  return model;
}

double largest_eigenvalue(const Model& model) {
  const TopologyTextures topology = build_topology(model);
  return estimate_spectrum(topology, topology.rest).largest;
}

/// Total mass, and the moments of first and second degree about the origin.
Eigen::Matrix4d moments(const Model& model) {
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < model.mass.size(); ++i) {
    const Eigen::Vector4d x(1.0, model.rest[i].x(), model.rest[i].y(), model.rest[i].z());
    sum += model.mass[i] * x * x.transpose();
  }
  return sum;
}

double moved(const Model& from, const Model& to) {
  double sum = 0.0, total = 0.0;
  for (std::size_t i = 0; i < from.mass.size(); ++i) {
    sum += std::max(0.0, to.mass[i] - from.mass[i]);
    total += from.mass[i];
  }
  return sum / total;
}

TEST(BalancedMasses, LengthenTheStepAndKeepTheMoments) {
  const Model plain = organ(0.0), balanced = organ(0.03);
  EXPECT_GT(moved(plain, balanced), 0.01);
  EXPECT_LE(moved(plain, balanced), 0.03);
  EXPECT_GT(*std::ranges::min_element(balanced.mass), 2.0 * *std::ranges::min_element(plain.mass));
  EXPECT_LT(largest_eigenvalue(balanced), largest_eigenvalue(plain) / 1.3);
  const Eigen::Matrix4d before = moments(plain), after = moments(balanced);
  EXPECT_NEAR(after(0, 0), before(0, 0), 1e-12 * before(0, 0));
  const double size = std::sqrt(before(1, 1) / before(0, 0));  // m
  for (int a = 1; a < 4; ++a) {
    EXPECT_NEAR(after(0, a), before(0, a), 1e-12 * before(0, 0) * size);
    for (int b = 1; b < 4; ++b) EXPECT_NEAR(after(a, b), before(a, b), 1e-12 * before(1, 1));
  }
  const auto is_told = [](const Model& model) {
    return std::ranges::count_if(model.notes,
                                 [](const std::string& n) { return n.find("most_mass_moved") < n.size(); });
  };
  EXPECT_EQ(is_told(balanced), 1);
  EXPECT_EQ(is_told(plain), 0);
}

TEST(BalancedMasses, MoveNoMoreThanAllowed) {
  const Model plain = organ(0.0);
  double last = largest_eigenvalue(plain);
  for (const double most : {0.02, 0.04, 0.08}) {
    const Model balanced = organ(most);
    EXPECT_LE(moved(plain, balanced), most);
    const double now = largest_eigenvalue(balanced);
    EXPECT_LT(now, last);
    last = now;
  }
}

/// What keeps the moments may take more from light particles than others gave them.
TEST(BalancedMasses, GainNoLessWhereMoreMayMove) {
  double last = std::numeric_limits<double>::infinity();
  for (const double most : {0.0, 0.03, 0.1, 0.3}) {
    Model model = make_tetrahedral_block({0.1, 0.1, 0.1}, 6, 6, 6, 0.45, 2, 0.02);
    model.most_mass_moved = most;
    set_material(model, of_an_organ);
    const double now = largest_eigenvalue(model);
    EXPECT_LT(now, 1.001 * last) << most;
    last = now;
  }
}

/// rad/s, ascending, of the organ held where x < -0.03 m.
std::vector<double> frequencies(const Model& model) {
  const TopologyTextures topology = build_topology(model);
  std::vector<std::uint8_t> fixed;
  for (const Vec3& x : model.rest) fixed.push_back(x.x() < -0.03 ? 7 : 0);
  std::vector<double> found;
  for (const auto& value : dense_eigenvalues(topology, topology.rest, fixed)) {
    if (value.real() > 1.0) found.push_back(std::sqrt(value.real()));  // 1/s^2; of held coordinates it is 0
  }
  std::ranges::sort(found);
  return found;
}

TEST(BalancedMasses, ChangeNoLowFrequency) {
  const std::vector<double> plain = frequencies(organ(0.0, 0.017)), balanced = frequencies(organ(0.03, 0.017));
  EXPECT_LT(balanced.back(), plain.back() / 1.1);
  for (int k = 0; k < 10; ++k) EXPECT_NEAR(balanced[k], plain[k], 5e-3 * plain[k]) << k;  // of so coarse a body
}

TEST(BalancedMasses, OfLatticesAreTheSharesOfTheirVolume) {
  Model plain = make_block({0.1, 0.05, 0.05}, 8, 4, 4), balanced = plain;
  plain.most_mass_moved = 0.0;
  set_material(plain, of_an_organ);
  set_material(balanced, of_an_organ);
  EXPECT_EQ(plain.mass, balanced.mass);
}

TEST(BalancedMasses, StayInTheirPartOfTheBody) {
  // A fine end, all of which is light for its stiffness, takes nothing from the coarse rest.
  const auto fine = [](const Vec3& x) { return x.x() > 0.03; };
  Model plain = make_body(solid_ellipsoid({0, 0, 0}, {0.06, 0.03, 0.03}),
                          {.spacing = 0.014, .spacing_at = [&](const Vec3& x) { return fine(x) ? 0.005 : 0.014; }});
  Model balanced = plain;
  plain.most_mass_moved = 0.0;
  set_material(plain, of_an_organ);
  set_material(balanced, of_an_organ);
  double before = 0.0, after = 0.0;
  for (std::size_t i = 0; i < plain.rest.size(); ++i) {
    if (!fine(plain.rest[i])) continue;
    before += plain.mass[i];
    after += balanced.mass[i];
  }
  EXPECT_NE(plain.mass, balanced.mass);
  EXPECT_NEAR(after, before, 0.01 * before);
  EXPECT_LT(largest_eigenvalue(balanced), largest_eigenvalue(plain) / 1.3);
}

TEST(BalancedMasses, AreTakenFromTheNeighbours) {
  const Model plain = organ(0.0), balanced = organ(0.03);
  double gained = 0.0;  // with their neighbours, over the mass of these, by all that were light
  for (Index i = 0; i < plain.particle_count(); ++i) {
    if (balanced.mass[i] < 1.3 * plain.mass[i]) continue;
    std::set<Index> around;
    for (const Cell& cell : plain.cells) {
      if (std::ranges::count(cell.particles, i) > 0) around.insert(cell.particles.begin(), cell.particles.end());
    }
    double before = 0.0, after = 0.0;
    for (const Index j : around) {
      before += plain.mass[j];
      after += balanced.mass[j];
    }
    gained += (after - before) / before;
  }
  EXPECT_LT(gained, 0.0);
}

TEST(BalancedMasses, FollowTheLastMaterial) {
  Model twice = organ(0.03);
  const Model once = twice;
  set_material(twice, {.young = 20e3, .poisson = 0.3, .density = 1200}, [](const Vec3& x) { return x.x() > 0.0; });
  EXPECT_NE(twice.mass, once.mass);
  set_material(twice, of_an_organ);
  EXPECT_EQ(twice.mass, once.mass);
  EXPECT_EQ(twice.notes, once.notes);
}

TEST(BalancedMasses, RefuseAShareOutOfRange) {
  for (const double share : {-0.01, 1.0, std::nan("")}) {
    Model model = make_block({0.1, 0.05, 0.05}, 2, 1, 1);
    model.most_mass_moved = share;
    EXPECT_NE(message_of([&] { set_material(model, of_an_organ); }).find("most_mass_moved"), std::string::npos);
    EXPECT_TRUE(model.materials.empty());
  }
}

}  // namespace
}  // namespace phymul::test
