// SPDX-License-Identifier: MIT
#include "material.h"

#include <algorithm>
#include <cmath>

#include "base/decimal.h"

namespace phymul {
namespace {

/// dpsi/dX + dpsi/dY / s over mu/2; X, Y, k, b, c, d: topology.h.
double slope(const Stiffening& of, double X, double Y, double s) {
  const double within = 1.0 / (1.0 + of.second_fades * X);
  const double growth = 1.0 + of.exponential * std::expm1(std::min(of.exponent * X, most_exponent));
  return growth + of.second * within * (1.0 / s - 1.0 - of.second_fades * within * (Y - X));
}

/// Nominal stresses of an incompressible body, over mu.
double stretched(const Stiffening& of, double s) {
  return (s - 1.0 / (s * s)) * slope(of, s * s + 2.0 / s - 3.0, 2.0 * s + 1.0 / (s * s) - 3.0, s);
}

double sheared(const Stiffening& of, double amount) {
  return amount * slope(of, amount * amount, amount * amount, 1.0);
}

constexpr int strains = 100;  // at which the stress is compared with that at the one before

}  // namespace

std::string fault_of(const Stiffening& of) {
  const auto named = [](const char* name, double value) { return std::string(name) + ' ' + to_decimal(value); };
  const std::string all = named("exponential", of.exponential) + ", " + named("exponent", of.exponent) + ", " +
                          named("second", of.second) + ", " + named("second_fades", of.second_fades);
  const double least = std::min({of.exponential, of.exponent, of.second_fades});
  if (!(least >= 0.0) || !std::isfinite(of.exponential + of.exponent + of.second_fades + of.second)) {
    return "expected a stiffening of finite numbers, of which only second may be below 0, got " + all;
  }
  const auto falls = [&](const std::string& where) {
    return "expected a stiffening by which the stress rises with every stretch from 0.6 to 1.7 and every shear to 1, "
           "but "
           "by " +
           all + " it falls at " + where +
           "; bring second nearer to 0, or make second_fades, or exponential and exponent, larger";
  };
  double tension = 0.0, pressure = 0.0, shear = 0.0;
  for (int n = 1; n <= strains; ++n) {
    const double share = static_cast<double>(n) / strains, up = 1.0 + 0.7 * share, down = 1.0 - 0.4 * share;
    const double pulled = stretched(of, up), pressed = stretched(of, down), turned = sheared(of, share);
    if (!(pulled > tension)) return falls("a stretch of " + to_decimal(up));
    if (!(pressed < pressure)) return falls("a stretch of " + to_decimal(down));
    if (!(turned > shear)) return falls("a shear of " + to_decimal(share));
    tension = pulled, pressure = pressed, shear = turned;
  }
  return {};
}

}  // namespace phymul
