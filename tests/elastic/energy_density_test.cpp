// SPDX-License-Identifier: MIT
//
// The energy of a material as a function of the deformation gradient alone: which law it is where, and what it leads
// to.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "elastic/energy_density.h"
#include "support/bodies.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

constexpr double shear = 3e3;

double bulk_of(double poisson) {
  return 2.0 * shear * (1.0 + poisson) / (3.0 * (1.0 - 2.0 * poisson));
}

double energy_of(const Mat3& F, double bulk, Mat3* gradient = nullptr, const Stiffening& of = {}) {
  if (of == Stiffening{}) return energy_density<double>({}, {shear, bulk}, F, gradient);
  return energy_density<double>({.strain_energy = StrainEnergy::stiffening},
                                {shear, bulk, of.exponential, of.exponent, of.second, of.second_fades}, F, gradient);
}

/// None, like cortex, and the laws of Mooney and Rivlin, Demiray, and Veronda and Westmann.
constexpr Stiffening laws[] = {{},
                               like_cortex,
                               {.second = 0.5},
                               {.exponential = 1.0, .exponent = 20.0},
                               {.exponential = 2.0, .exponent = 5.0, .second = -1.0}};

Mat3 random_turn(std::mt19937& bits) {
  std::normal_distribution<double> any;
  return Eigen::Quaterniond(any(bits), any(bits), any(bits), any(bits)).normalized().toRotationMatrix();
}

TEST(EnergyDensity, IsNeoHookeanForStretchesOfSixToSeventeenTenths) {
  std::mt19937 bits(1);
  std::uniform_real_distribution<double> stretch(0.6, 1.7);
  const double bulk = bulk_of(0.45);
  for (int k = 0; k < 2000; ++k) {
    Vec3 s(stretch(bits), stretch(bits), stretch(bits));
    if (k < 8) s = Vec3(k & 1 ? 0.6 : 1.7, k & 2 ? 0.6 : 1.7, k & 4 ? 0.6 : 1.7);
    const Mat3 F = random_turn(bits) * s.asDiagonal() * random_turn(bits);
    const double J = s.prod();
    const double shape = 0.5 * shear * (std::pow(J, -2.0 / 3.0) * s.squaredNorm() - 3.0);
    const double volume =
        bulk * (std::abs(J - 1.0) < 0.5 ? 0.5 * (J - 1.0) * (J - 1.0) : 0.5 * std::abs(J - 1.0) - 0.125);
    EXPECT_NEAR(energy_of(F, bulk), shape + volume, 1e-9 * (shape + volume)) << s.transpose();
  }
}

TEST(EnergyDensity, ItsGradientIsTheSlopeOfTheEnergyEverywhere) {
  std::mt19937 bits(2);
  std::normal_distribution<double> any;
  const double bulk = bulk_of(0.45), h = 1e-6;
  for (int k = 0; k < 2000; ++k) {
    Mat3 F, way, gradient;
    for (double& f : F.reshaped()) f = any(bits) * std::pow(10.0, 0.3 * any(bits));
    for (double& f : way.reshaped()) f = any(bits);
    if (k % 2 == 1) F = Mat3::Identity() + 0.1 * F;
    const Stiffening& law = laws[k % std::size(laws)];
    energy_of(F, bulk, &gradient, law);
    const double slope = gradient.cwiseProduct(way).sum();
    const double found =
        (energy_of(F + h * way, bulk, nullptr, law) - energy_of(F - h * way, bulk, nullptr, law)) / (2 * h);
    EXPECT_NEAR(found, slope, 1e-4 * gradient.norm() * way.norm() + 1e-3) << F;
  }
}

/// Down along the energy from any start, inverted ones too, a deformation ends in a rotation.
TEST(EnergyDensity, HasNoMinimaButRotations) {
  std::mt19937 bits(3);
  std::normal_distribution<double> any;
  for (const double poisson : {-0.3, 0.3, 0.45}) {
    const double bulk = bulk_of(poisson);
    for (int k = 0; k < (sanitized ? 20 : 200); ++k) {
      const Stiffening& law = laws[k < 100 ? 0 : k % std::size(laws)];
      Mat3 F, gradient;
      for (double& f : F.reshaped()) f = any(bits) * std::exp(0.7 * any(bits));
      if (k % 4 == 0) F.row(2) *= 1e-3;
      if (k % 4 == 1) F *= 1e-2;
      for (int step = 0; step < 20000; ++step) {
        energy_of(F, bulk, &gradient, law);
        F -= (k < 100 ? 0.02 : 0.005) / (shear + bulk) * std::min(1.0, (shear + bulk) * 5.0 / gradient.norm()) *
             gradient;
      }
      EXPECT_LT((F.transpose() * F - Mat3::Identity()).norm(), 1e-3) << poisson << '\n' << F;
      EXPECT_GT(F.determinant(), 0.0);
    }
  }
}

}  // namespace
}  // namespace phymul::test
