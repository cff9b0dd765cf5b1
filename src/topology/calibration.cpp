// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/topology.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "base/decimal.h"

namespace phymul {
namespace {

// Lame constants of C/2 |F n0 - g n(F)|^2 with C = 1, averaged over all directions, g = [2/(1+(A/A0)^2)]^p: at small
// strain the vector is 2 (eps n - (n.eps n) n) + ((1-p) n.eps n + p tr eps) n, whose square averages to mu tr(eps^2) +
// lambda/2 (tr eps)^2 with
//   mu     = ((1-p)^2 2/15 + 12/15) / 2
//   lambda = (1-p)^2/15 + 2 p (1-p)/3 + p^2 - 4/15
struct Lame {
  double mu, lambda;
};

Lame unit_lame(double p) {
  const double q = 1.0 - p;
  return {(q * q * 2.0 / 15.0 + 12.0 / 15.0) / 2.0, q * q / 15.0 + 2.0 * p * q / 3.0 + p * p - 4.0 / 15.0};
}

double poisson_of(const Lame& lame) {
  return lame.lambda / (2.0 * (lame.lambda + lame.mu));
}

double young_of(const Lame& lame) {
  return lame.mu * (3.0 * lame.lambda + 2.0 * lame.mu) / (lame.lambda + lame.mu);
}

constexpr double largest_exponent = 2.0;  // above it bodies with few neighbours lose local stability

void require_range(const Material& material, double highest, bool inclusive, const char* advice) {
  const double nu = material.poisson;
  if (nu >= -3.0 / 8.0 && (inclusive ? nu <= highest : nu < highest)) return;
  char text[256];
  std::snprintf(text, sizeof text, "Poisson's ratio is %g; this route takes -0.375 to %.4g%s. %s", nu, highest,
                inclusive ? "" : " (excluded)", advice);
  throw Error(text);
}

Calibration by_area_exponent(const Material& material) {
  require_range(material, poisson_of(unit_lame(largest_exponent)), true, "Use the volume term, or another ratio");
  double low = 0.0;
  double high = largest_exponent;
  for (int round = 0; round < 100; ++round) {  // nu grows with p throughout
    const double middle = (low + high) / 2.0;
    (poisson_of(unit_lame(middle)) < material.poisson ? low : high) = middle;
  }
  const double p = material.poisson <= poisson_of(unit_lame(0.0)) ? 0.0 : (low + high) / 2.0;
  return {material.young / young_of(unit_lame(p)), 0.0, p};
}

Calibration by_volume_term(const Material& material) {
  require_range(material, 0.5, false, "Tissue that keeps its volume takes 0.45 to 0.49");
  const double nu = material.poisson;
  const double mu = material.young / (2.0 * (1.0 + nu));
  const double lambda = material.young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  const double c = 15.0 / 7.0 * mu;
  return {c, std::max(0.0, lambda + c / 5.0), 0.0};
}

}  // namespace

Calibration calibrate(const Material& material, PoissonRoute route) {
  if (!(material.young > 0.0) || !std::isfinite(material.young)) {
    throw Error("Young's modulus is " + to_decimal(material.young) + " Pa; expected a finite value above 0");
  }
  return route == PoissonRoute::area_exponent ? by_area_exponent(material) : by_volume_term(material);
}

}  // namespace phymul
