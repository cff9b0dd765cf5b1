// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/material_fit.h>

#include <cmath>
#include <limits>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include "base/decimal.h"
#include "energy_density.h"
#include "model/material.h"
#include "topology/energies.h"

namespace phymul {
namespace {

void require_strain(StrainTest test, double strain) {
  const bool uniaxial = test == StrainTest::uniaxial;
  if (uniaxial ? strain >= 0.6 && strain <= 1.7 : std::abs(strain) <= 1.0) return;
  throw Error(std::string("expected ") + (uniaxial ? "a stretch from 0.6 to 1.7" : "an amount of shear from -1 to 1") +
              ", for which StrainEnergy::stiffening is meant, got " + to_decimal(strain));
}

double stress_of(const EnergyConstants& p, StrainTest test, double strain) {
  const TopologyOptions options{.strain_energy = StrainEnergy::stiffening};
  Mat3 F = Mat3::Identity(), P;
  if (test == StrainTest::shear) {
    F(0, 1) = strain;
    energy_density<double>(options, p, F, &P);
    return P(0, 1);
  }
  F(0, 0) = strain;
  const auto side = [&](double width) {
    F(1, 1) = F(2, 2) = width;
    energy_density<double>(options, p, F, &P);
    return P(1, 1);
  };
  // The width at which the sides are free, by the secant method from that of constant volume. It lies between one where
  // they are pressed and one where they are pulled, which are halved where that method leaves them or is slow.
  double before = 1.0, pull_before = side(before), width = 1.0 / std::sqrt(strain), pressed = 0.0, pulled = 1e3;
  for (int n = 0; n < 200; ++n) {
    const double pull = side(width);
    if (std::abs(width - before) < 1e-14 || pull == pull_before) break;
    (pull < 0.0 ? pressed : pulled) = width;
    double next = width - pull * (width - before) / (pull - pull_before);
    if (!(next > pressed && next < pulled) || (n > 20 && n % 3 == 2)) next = 0.5 * (pressed + pulled);
    before = width, pull_before = pull;
    width = std::clamp(next, 0.5 * width, 2.0 * width);
  }
  return P(0, 0);
}

/// The unknowns: the logarithm of Young's modulus, then for each fitted constant its square root, or `second` itself.
class Residuals {
 public:
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  Residuals(std::span<const TestPoint> points, const Material& start, const FitOptions& options)
      : points_(points), start_(start), options_(options) {}

  int inputs() const { return 1 + 2 * options_.exponential + options_.second + options_.second_fades; }
  int values() const { return static_cast<int>(points_.size()); }

  Material at(const Eigen::VectorXd& x) const {
    Material m = start_;
    Eigen::Index k = 0;
    m.young = std::exp(x[k++]);
    if (options_.exponential) {
      m.stiffening.exponential = x[k] * x[k];
      m.stiffening.exponent = x[k + 1] * x[k + 1];
      k += 2;
    }
    if (options_.second) m.stiffening.second = x[k++];
    if (options_.second_fades) m.stiffening.second_fades = x[k] * x[k];
    return m;
  }

  Eigen::VectorXd errors(const Material& material) const {
    const EnergyConstants p = energy_constants(StrainEnergy::stiffening, material, Vec3::Zero());
    Eigen::VectorXd error(values());
    for (int n = 0; n < values(); ++n) {
      const TestPoint& point = points_[static_cast<std::size_t>(n)];
      error[n] = stress_of(p, point.test, point.strain) / point.stress - 1.0;
    }
    return error;
  }

  /// Relative errors to this power, with their signs; over `scale`, so that they stay near 1.
  double power = 1.0, scale = 1.0;

  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& values) const {
    values = (errors(at(x)) / scale).unaryExpr([&](double e) {
      const double bounded = std::isfinite(e) ? std::min(std::abs(e), 1e3) : 1e3;  // the next guess is nearer
      return std::copysign(std::pow(bounded, power), e);
    });
    return 0;
  }

 private:
  std::span<const TestPoint> points_;
  Material start_;
  FitOptions options_;
};

/// Improves `x` by Levenberg and Marquardt's method. The powers of `largest_error` approach the least largest error.
void improve(Residuals& residuals, FitGoal goal, Eigen::VectorXd& x) {
  for (const double power : {1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0}) {
    residuals.power = power;
    residuals.scale = power > 1.0 ? std::max(residuals.errors(residuals.at(x)).cwiseAbs().maxCoeff(), 1e-12) : 1.0;
    Eigen::NumericalDiff<Residuals, Eigen::Central> slopes(residuals);
    Eigen::LevenbergMarquardt<decltype(slopes)> solver(slopes);
    solver.parameters.maxfev = 200;
    solver.minimize(x);
    if (goal == FitGoal::least_squares) return;
  }
}

void require_points(std::span<const TestPoint> points, int constants) {
  for (std::size_t n = 0; n < points.size(); ++n) {
    const auto& [test, strain, stress] = points[n];
    const std::string row = "fit_material: point " + std::to_string(n) + ": ";
    try {
      require_strain(test, strain);
    } catch (const Error& error) {
      throw Error(row + error.what());
    }
    const double change = test == StrainTest::uniaxial ? strain - 1.0 : strain;
    if (!(stress * change > 0.0) || !std::isfinite(stress)) {
      throw Error(row + "expected a finite stress of the sign of the strain, neither of them 0, got " +
                  to_decimal(stress) + " Pa at " + to_decimal(strain));
    }
  }
  if (static_cast<int>(points.size()) >= constants) return;
  throw Error("fit_material: expected at least as many points as constants, " + std::to_string(constants) + ", got " +
              std::to_string(points.size()) + "; measure more, or fit fewer terms (FitOptions)");
}

}  // namespace

double nominal_stress(const Material& material, StrainTest test, double strain) {
  require_in_range(material);
  require_strain(test, strain);
  return stress_of(energy_constants(StrainEnergy::stiffening, material, Vec3::Zero()), test, strain);
}

MaterialFit fit_material(std::span<const TestPoint> points, const Material& start, const FitOptions& options) {
  Residuals residuals(points, start, options);
  require_points(points, residuals.inputs());
  Material unit = start;
  unit.young = 1.0;
  require_in_range(unit);
  MaterialFit best{.largest_error = std::numeric_limits<double>::infinity()};
  double least = std::numeric_limits<double>::infinity();
  std::string fault = "the stresses are beyond the range of numbers";
  // From each start the method ends in the nearest minimum, which may be a poor one.
  for (const auto& [root, exponent] : {std::pair{0.5, 3.0}, {0.5, 10.0}, {0.5, 30.0}, {0.9, 6.0}, {0.9, 15.0}}) {
    if (!options.exponential && exponent != 3.0) continue;  // the same start again
    for (const double second : {0.0, 8.0}) {
      if (!options.second && !options.second_fades && second != 0.0) continue;
      Eigen::VectorXd x(residuals.inputs());
      Eigen::Index k = 1;
      if (options.exponential) {
        x[k++] = root;
        x[k++] = std::sqrt(exponent);
      }
      if (options.second) x[k++] = second;
      if (options.second_fades) x[k] = std::sqrt(2.0 * second + 0.1);
      x[0] = 0.0;
      const Eigen::ArrayXd per_young = residuals.errors(residuals.at(x)).array() + 1.0;
      x[0] = std::log(std::max(std::abs(per_young.sum() / per_young.square().sum()), 1e-30));
      improve(residuals, options.goal, x);
      const Material found = residuals.at(x);
      const Eigen::VectorXd errors = residuals.errors(found);
      const double largest = errors.cwiseAbs().maxCoeff(),
                   measure = options.goal == FitGoal::least_squares ? errors.norm() : largest;
      const std::string own = fault_of(found.stiffening);
      if (!own.empty()) fault = own;
      if (!own.empty() || !(measure < least)) continue;
      least = measure;
      best = {.material = found, .stress = {}, .largest_error = largest};
    }
  }
  if (!std::isfinite(least)) {
    throw Error("fit_material: the constants that fit are out of range: " + fault +
                "; fit other terms (FitOptions), or add points at larger strains");
  }
  for (const TestPoint& point : points) {
    best.stress.push_back(nominal_stress(best.material, point.test, point.strain));
  }
  return best;
}

}  // namespace phymul
