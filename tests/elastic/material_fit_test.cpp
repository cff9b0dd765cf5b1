// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <phymul/material_fit.h>

#include <array>

#include "elastic/energy_density.h"
#include "support/message_of.h"
#include "topology/energies.h"

namespace phymul::test {
namespace {

constexpr Material start{.young = 0.0, .poisson = 0.49, .density = 1000};

/// Tension, compression and shear of the material itself.
std::vector<TestPoint> tested(const Material& material) {
  std::vector<TestPoint> points;
  for (const double s : {0.7, 0.8, 0.9, 0.95, 1.05, 1.1, 1.2, 1.3}) points.push_back({StrainTest::uniaxial, s, 0.0});
  for (const double a : {0.1, 0.2, 0.4}) points.push_back({StrainTest::shear, a, 0.0});
  for (TestPoint& point : points) point.stress = nominal_stress(material, point.test, point.strain);
  return points;
}

TEST(MaterialFit, FindsTheConstantsOfItsOwnStresses) {
  for (const Stiffening& of : {Stiffening{.second = 0.3}, Stiffening{.exponential = 1.0, .exponent = 3.0},
                               Stiffening{.exponential = 1.5, .exponent = 2.0, .second = -0.5},
                               Stiffening{.exponential = 0.3, .exponent = 10.0, .second = 3.0, .second_fades = 8.0}}) {
    Material known = start;
    known.young = 7e3;
    known.stiffening = of;
    const FitOptions terms{
        .exponential = of.exponential > 0.0, .second = of.second != 0.0, .second_fades = of.second_fades > 0.0};
    const MaterialFit fit = fit_material(tested(known), start, terms);
    const Stiffening& found = fit.material.stiffening;
    EXPECT_LT(fit.largest_error, 1e-6);
    EXPECT_NEAR(fit.material.young, known.young, 1e-4 * known.young);
    EXPECT_NEAR(found.exponential, of.exponential, 1e-3);
    EXPECT_NEAR(found.exponent, of.exponent, 1e-3 * of.exponent);
    EXPECT_NEAR(found.second, of.second, 1e-3);
    EXPECT_NEAR(found.second_fades, of.second_fades, 1e-3 * of.second_fades);
    EXPECT_EQ(fit.material.poisson, start.poisson);
  }
}

TEST(MaterialFit, FindsThemAtLargeStrainsToo) {
  for (const Stiffening& of :
       {Stiffening{0.865366, 12.5246, 0.680451, 1.10212}, Stiffening{0.823307, 6.54809, 0.0, 0.0}}) {
    Material known{.young = 5e3, .poisson = 0.45, .density = 1000.0};
    known.stiffening = of;
    std::vector<TestPoint> points;
    for (const double s : {0.65, 0.7, 0.8, 0.9, 1.1, 1.2, 1.3, 1.5, 1.65}) {
      points.push_back({StrainTest::uniaxial, s, nominal_stress(known, StrainTest::uniaxial, s)});
    }
    for (const double a : {0.2, 0.5, -0.7, 0.9}) {
      points.push_back({StrainTest::shear, a, nominal_stress(known, StrainTest::shear, a)});
    }
    EXPECT_LT(fit_material(points, {.young = 0.0, .poisson = 0.45, .density = 1000.0}).largest_error, 1e-3);
  }
}

/// Against a bisection over the width at which the sides are free. The stress has a corner there, or nearly.
TEST(MaterialFit, StressOfAStiffeningMaterialHasFreeSides) {
  for (const auto& [poisson, exponential, exponent, stretch] :
       {std::array{0.4, 0.2, 30.0, 0.65}, {0.45, 2.0, 20.0, 0.66}, {0.45, 5.0, 30.0, 0.71}, {0.3, 1.0, 3.0, 1.7}}) {
    const Material material{.young = 1e3,
                            .poisson = poisson,
                            .density = 1000,
                            .stiffening = {.exponential = exponential, .exponent = exponent}};
    const EnergyConstants constants = energy_constants(StrainEnergy::stiffening, material, Vec3::Zero());
    double pressed = 0.5, pulled = 2.0;
    Mat3 P;
    for (int n = 0; n < 60; ++n) {
      const double width = 0.5 * (pressed + pulled);
      energy_density<double>({.strain_energy = StrainEnergy::stiffening}, constants,
                             Vec3(stretch, width, width).asDiagonal(), &P);
      (P(1, 1) < 0.0 ? pressed : pulled) = width;
    }
    const double stress = nominal_stress(material, StrainTest::uniaxial, stretch);
    EXPECT_NEAR(stress, P(0, 0), 1e-6 * std::abs(P(0, 0))) << poisson << ' ' << exponent << ' ' << stretch;
  }
}

/// bench/reference/measured.csv, which has the source.
std::vector<TestPoint> cortex() {
  std::vector<TestPoint> points;
  const auto add = [&](StrainTest test, std::array<double, 4> strain, std::array<double, 4> kilopascals) {
    for (std::size_t k = 0; k < 4; ++k) points.push_back({test, strain[k], 1e3 * kilopascals[k]});
  };
  add(StrainTest::uniaxial, {1.025, 1.05, 1.075, 1.1}, {0.0838, 0.1488, 0.2366, 0.4151});
  add(StrainTest::uniaxial, {0.975, 0.95, 0.925, 0.9}, {-0.1479, -0.3504, -0.6579, -1.1484});
  add(StrainTest::shear, {0.05, 0.1, 0.15, 0.2}, {0.0633, 0.1412, 0.2698, 0.5435});
  return points;
}

TEST(MaterialFit, HasHumanCortexWithinTenPercentAtEveryPoint) {
  Material tissue = start;
  tissue.poisson = 0.499;
  const auto error = [&](bool exponential, bool second, bool fades) {
    const FitOptions options{FitGoal::largest_error, exponential, second, fades};
    const MaterialFit fit = fit_material(cortex(), tissue, options);
    const Stiffening& s = fit.material.stiffening;
    std::printf("E %.0f Pa, stiffening %.4g %.4g %.4g %.4g: within %.2f %%\n", fit.material.young, s.exponential,
                s.exponent, s.second, s.second_fades, 100.0 * fit.largest_error);
    return fit.largest_error;
  };
  EXPECT_GT(error(false, false, false), 0.5);
  EXPECT_GT(error(true, false, false), 0.3);
  EXPECT_LT(error(true, true, false), 0.14);
  EXPECT_LT(error(true, true, true), 0.10);
}

TEST(MaterialFit, SaysWhatIsWrongWithATable) {
  using enum StrainTest;
  const auto refused = [](std::vector<TestPoint> points, const FitOptions& options = {}) {
    return message_of([&] { fit_material(points, start, options); });
  };
  const TestPoint good{uniaxial, 1.1, 100.0};
  EXPECT_TRUE(says(refused({good, {uniaxial, 0.1, -5.0}}), "point 1", "a stretch from 0.6 to 1.7", "got 0.1"));
  EXPECT_TRUE(says(refused({good, {shear, 1.5, 5.0}}), "point 1", "an amount of shear from -1 to 1", "got 1.5"));
  EXPECT_TRUE(says(refused({{uniaxial, 0.9, 100.0}}), "point 0", "of the sign of the strain", "100 Pa at 0.9"));
  EXPECT_TRUE(says(refused({good, good}), "at least as many points as constants, 5, got 2"));
  EXPECT_TRUE(
      says(refused({good, {uniaxial, 1.2, 90.0}, {uniaxial, 1.3, 60.0}}, {.exponential = false, .second_fades = false}),
           "constants that fit are out of range", "falls at"));
  EXPECT_TRUE(says(refused(std::vector(5, TestPoint{uniaxial, 1.1, 1e-200})), "beyond the range of numbers"));
  EXPECT_TRUE(refuses([] { nominal_stress({.young = 1e3, .poisson = 0.6, .density = 1}, shear, 0.1); }, "1/2"));
}

}  // namespace
}  // namespace phymul::test
