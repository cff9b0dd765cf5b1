// SPDX-License-Identifier: MIT
#include "convergence.h"

#include <algorithm>
#include <cmath>

namespace phymul {
namespace {

constexpr double twice_as_fine = 1.9;

/// Of |u1 - u2| to |u2 - u3|; rises with p.
double ratio_of_differences(double p, double h1, double h2, double h3) {
  return (std::pow(h1, p) - std::pow(h2, p)) / (std::pow(h2, p) - std::pow(h3, p));
}

double order_of(double ratio, double h1, double h2, double h3) {
  double low = least_order, high = most_order;
  for (int k = 0; k < 60; ++k) {
    const double p = 0.5 * (low + high);
    (ratio_of_differences(p, h1, h2, h3) < ratio ? low : high) = p;
  }
  return 0.5 * (low + high);
}

}  // namespace

double mean_distance(std::span<const Vec3> a, std::span<const Vec3> b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

Convergence fit_convergence(const FieldAt& coarse, const FieldAt& middle, const FieldAt& fine) {
  Convergence fit;
  const double first = mean_distance(coarse.u, middle.u), second = mean_distance(middle.u, fine.u);
  // Three equal fields have converged; any order will do.
  fit.converges = first >= second * ratio_of_differences(least_order, coarse.h, middle.h, fine.h) * (1.0 - 1e-9);
  fit.order = second > 0.0 ? order_of(first / second, coarse.h, middle.h, fine.h) : most_order;
  const double fine_part = std::pow(fine.h, fit.order);
  const double share = fine_part / (std::pow(middle.h, fit.order) - fine_part);
  fit.limit.resize(fine.u.size());
  for (std::size_t i = 0; i < fine.u.size(); ++i) fit.limit[i] = fine.u[i] + share * (fine.u[i] - middle.u[i]);
  fit.scale = mean_distance(fit.limit, VecList(fit.limit.size(), Vec3::Zero()));
  return fit;
}

double estimated_error(const Convergence& fit, const FieldAt& field, const FieldAt& finest) {
  double error = mean_distance(field.u, fit.limit);
  if (field.h > twice_as_fine * finest.h) {
    const double own = std::pow(field.h, fit.order);
    error = std::max(error, mean_distance(field.u, finest.u) * own / (own - std::pow(finest.h, fit.order)));
  }
  return error / fit.scale;
}

}  // namespace phymul
