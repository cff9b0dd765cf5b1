// SPDX-License-Identifier: MIT
#include "isotropic_fit.h"

#include "base/nnls.h"

#include <array>
#include <cmath>

namespace phymul {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Exponents of x, y, z and how often the entry occurs in the tensor: 4! / (p! q! r!).
struct Monomial {
  int p, q, r;
  double count;
};
constexpr std::array<Monomial, 15> monomials{{{4, 0, 0, 1},
                                              {0, 4, 0, 1},
                                              {0, 0, 4, 1},
                                              {2, 2, 0, 6},
                                              {2, 0, 2, 6},
                                              {0, 2, 2, 6},
                                              {3, 1, 0, 4},
                                              {3, 0, 1, 4},
                                              {1, 3, 0, 4},
                                              {0, 3, 1, 4},
                                              {1, 0, 3, 4},
                                              {0, 1, 3, 4},
                                              {2, 1, 1, 12},
                                              {1, 2, 1, 12},
                                              {1, 1, 2, 12}}};

// The row that holds the sum at 1 outweighs the moments; what is left is divided out.
constexpr double sum_row = 10.0;
// Pull towards a balanced set: settles which of equal directions is taken.
constexpr double balance_row = 0.03;

MatrixXd moments(const std::vector<Vec3>& normals) {
  MatrixXd m(15, static_cast<Eigen::Index>(normals.size()));
  for (std::size_t t = 0; t < normals.size(); ++t) m.col(static_cast<Eigen::Index>(t)) = fourth_moment(normals[t]);
  return m;
}

}  // namespace

FourthMoment fourth_moment(const Vec3& normal) {
  const auto powers = [](double x) { return std::array<double, 5>{1.0, x, x * x, x * x * x, x * x * x * x}; };
  const std::array<double, 5> x = powers(normal.x());
  const std::array<double, 5> y = powers(normal.y());
  const std::array<double, 5> z = powers(normal.z());
  FourthMoment m;
  for (std::size_t k = 0; k < monomials.size(); ++k) {
    const auto& [p, q, r, count] = monomials[k];
    m[static_cast<Eigen::Index>(k)] = std::sqrt(count) * x[p] * y[q] * z[r];
  }
  return m;
}

FourthMoment isotropic_moment(int dimension) {
  const double over = dimension == 2 ? 8.0 : 15.0;
  FourthMoment m = FourthMoment::Zero();
  for (std::size_t k = 0; k < monomials.size(); ++k) {
    const auto& [p, q, r, count] = monomials[k];
    if ((p | q | r) % 2 != 0 || (dimension == 2 && r > 0)) continue;
    m[static_cast<Eigen::Index>(k)] = std::sqrt(count) * (count == 1.0 ? 3.0 : 1.0) / over;
  }
  return m;
}

VectorXd sparse_weights(const std::vector<Vec3>& normals, const VecList& centres, int dimension) {
  const auto n = static_cast<Eigen::Index>(normals.size());
  if (n == 0) return {};
  MatrixXd a(19, n);
  a.topRows(15) = moments(normals);
  for (Eigen::Index t = 0; t < n; ++t) a.block<3, 1>(15, t) = balance_row * centres[static_cast<std::size_t>(t)];
  a.row(18).setConstant(sum_row);
  VectorXd b(19);
  b << isotropic_moment(dimension), Vec3::Zero(), sum_row;
  const VectorXd u = non_negative_least_squares(a, b);
  return u / u.sum();
}

}  // namespace phymul
