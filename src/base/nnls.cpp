// SPDX-License-Identifier: MIT
#include "nnls.h"

#include <Eigen/QR>
#include <algorithm>
#include <vector>

namespace phymul {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Gradients below this share of |column| |b| are rounding.
constexpr double gradient_tolerance = 1e-12;

VectorXd solve_passive(const MatrixXd& a, const VectorXd& b, const std::vector<Index>& passive) {
  const MatrixXd columns = a(Eigen::all, passive);
  return columns.colPivHouseholderQr().solve(b);
}

// The column that promises most: largest gradient over column length, above rounding, not barred; -1: none is left.
Index steepest(const VectorXd& gradient, const VectorXd& length, double scale, const std::vector<bool>& barred) {
  Index best = -1;
  double most = gradient_tolerance * scale;
  for (Index j = 0; j < gradient.size(); ++j) {
    if (barred[j] || !(length[j] > 0.0)) continue;
    const double slope = gradient[j] / length[j];
    if (slope > most * (best < 0 ? 1.0 : 1.0 + 1e-9)) {
      most = slope;
      best = j;
    }
  }
  return best;
}

// Walks from x towards the unconstrained answer z of the passive columns as far as no entry turns negative, and
// releases the entries that reach zero.
void walk(std::vector<Index>& passive, const VectorXd& z, VectorXd& x) {
  double step = 1.0;
  std::size_t blocking = passive.size();
  for (std::size_t k = 0; k < passive.size(); ++k) {
    const double value = z[static_cast<Index>(k)];
    if (value > 0.0) continue;
    const double reach = x[passive[k]] / (x[passive[k]] - value);
    if (reach < step || blocking == passive.size()) {
      step = std::min(step, reach);
      blocking = k;
    }
  }
  for (std::size_t k = 0; k < passive.size(); ++k) {
    double& entry = x[passive[k]];
    entry += step * (z[static_cast<Index>(k)] - entry);
    if (k == blocking) entry = 0.0;
  }
  std::erase_if(passive, [&x](Index j) {
    if (x[j] > 0.0) return false;
    x[j] = 0.0;
    return true;
  });
}

}  // namespace

VectorXd non_negative_least_squares(const MatrixXd& a, const VectorXd& b) {
  VectorXd x = VectorXd::Zero(a.cols());
  const VectorXd length = a.colwise().norm().transpose();
  const double scale = b.norm();
  std::vector<Index> passive;
  std::vector<bool> barred(static_cast<std::size_t>(a.cols()), false);
  // Each round lowers the residual, so that no passive set comes twice; the bound only guards against rounding.
  for (Index round = 0; round < 10 * (a.cols() + 10); ++round) {
    const VectorXd gradient = a.transpose() * (b - a * x);
    const Index entering = steepest(gradient, length, scale, barred);
    if (entering < 0) break;
    passive.push_back(entering);
    barred[entering] = true;
    VectorXd z = solve_passive(a, b, passive);
    if (!(z[z.size() - 1] > 0.0)) {  // its gradient was rounding after all: stays barred until x moves
      passive.pop_back();
      continue;
    }
    while (z.size() > 0 && z.minCoeff() <= 0.0) {
      walk(passive, z, x);
      z = passive.empty() ? VectorXd() : solve_passive(a, b, passive);
    }
    for (std::size_t k = 0; k < passive.size(); ++k) x[passive[k]] = z[static_cast<Index>(k)];
    std::fill(barred.begin(), barred.end(), false);
    for (const Index j : passive) barred[j] = true;
  }
  return x;
}

}  // namespace phymul
