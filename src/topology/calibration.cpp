// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/topology.h>

#include <algorithm>
#include <cmath>

#include "base/decimal.h"

namespace phymul {
namespace {

// Lame constants of C/2 |F n0 - n(F)|^2 with C = 1, averaged over all directions: at small strain the vector is
// 2 (eps n - (n.eps n) n) + (n.eps n) n, whose square averages to mu tr(eps^2) + lambda/2 (tr eps)^2 with these.
constexpr double unit_mu = 7.0 / 15.0, unit_lambda = -1.0 / 5.0;
/// Of which Poisson's ratio is the lowest that a volume energy on top can reach.
constexpr double lowest_poisson = unit_lambda / (2.0 * (unit_lambda + unit_mu));

}  // namespace

Calibration calibrate(const Material& material) {
  const double nu = material.poisson;
  if (!(material.young > 0.0) || !std::isfinite(material.young)) {
    throw Error("Young's modulus is " + to_decimal(material.young) + " Pa; expected a finite value above 0");
  }
  if (!(nu >= lowest_poisson && nu < 0.5)) {
    throw Error("Poisson's ratio is " + to_decimal(nu) + "; expected " + to_decimal(lowest_poisson) +
                " to 0.5 (excluded). Tissue that keeps its volume takes 0.45 to 0.49");
  }
  const double mu = material.young / (2.0 * (1.0 + nu));
  const double lambda = material.young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  const double c = mu / unit_mu;
  return {c, std::max(0.0, lambda - unit_lambda * c)};
}

}  // namespace phymul
