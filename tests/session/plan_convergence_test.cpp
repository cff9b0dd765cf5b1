// SPDX-License-Identifier: MIT
//
// Orders, limits and errors from sequences whose limits are known.
#include <gtest/gtest.h>

#include <cmath>

#include "session/planner/convergence.h"

namespace phymul::test {
namespace {

/// u0 + C h^p at two points.
VecList field(double h, double order) {
  const double part = std::pow(h, order);
  return {Vec3(1.0, 0.5, -0.2) + part * Vec3(0.3, -0.1, 0.2), Vec3(0.2, 0.0, 0.1) + part * Vec3(-0.5, 0.4, 0.0)};
}

TEST(PlanConvergence, FindsOrderLimitAndErrorOfExactSequences) {
  for (const double order : {1.0, 1.5, 2.0, 2.5}) {
    for (const double ratio : {1.4142, 1.7, 2.0}) {
      const double h = 0.3;
      const VecList a = field(h, order), b = field(h / ratio, order), c = field(0.8 * h / ratio, order);
      const Convergence fit = fit_convergence({h, a}, {h / ratio, b}, {0.8 * h / ratio, c});
      EXPECT_NEAR(fit.order, order, 1e-6) << ratio;
      EXPECT_TRUE(fit.converges);
      const VecList limit = field(0.0, order);
      EXPECT_LT(mean_distance(fit.limit, limit), 1e-7);
      const VecList zero(2, Vec3::Zero());
      EXPECT_NEAR(fit.scale, mean_distance(limit, zero), 1e-7);
      const FieldAt finest{0.8 * h / ratio, c};
      EXPECT_NEAR(estimated_error(fit, {h, a}, finest), mean_distance(a, limit) / mean_distance(limit, zero), 1e-6);
      EXPECT_NEAR(estimated_error(fit, finest, finest), mean_distance(c, limit) / mean_distance(limit, zero), 1e-6);
    }
  }
}

TEST(PlanConvergence, KeepsTheOrderInItsRange) {
  // Of order 4: a lower order leaves a larger error, which is the safe side.
  const VecList a = field(0.4, 4.0), b = field(0.2, 4.0), c = field(0.1, 4.0);
  const Convergence steep = fit_convergence({0.4, a}, {0.2, b}, {0.1, c});
  EXPECT_NEAR(steep.order, most_order, 1e-9);
  EXPECT_TRUE(steep.converges);
  // Differences that do not fall.
  const Convergence none =
      fit_convergence({0.4, VecList{{1.0, 0, 0}}}, {0.2, VecList{{1.1, 0, 0}}}, {0.1, VecList{{1.2, 0, 0}}});
  EXPECT_NEAR(none.order, least_order, 1e-9);
  EXPECT_FALSE(none.converges);
}

TEST(PlanConvergence, EqualFieldsHaveNoError) {
  const VecList a{{1.0, 2.0, 3.0}};
  const Convergence fit = fit_convergence({0.4, a}, {0.2, a}, {0.1, a});
  EXPECT_TRUE(fit.converges);
  EXPECT_EQ(estimated_error(fit, {0.4, a}, {0.1, a}), 0.0);
}

TEST(PlanConvergence, AFinestFieldThatTheFitDoesNotExplainRaisesTheError) {
  const VecList a = field(0.4, 2.0), b = field(0.2, 2.0), c = field(0.1, 2.0);
  const Convergence fit = fit_convergence({0.4, a}, {0.2, b}, {0.1, c});
  VecList other = c;
  for (Vec3& u : other) u *= 1.1;
  EXPECT_GT(estimated_error(fit, {0.4, a}, {0.1, other}), estimated_error(fit, {0.4, a}, {0.1, c}));
}

}  // namespace
}  // namespace phymul::test
