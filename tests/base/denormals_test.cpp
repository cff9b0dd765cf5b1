// SPDX-License-Identifier: MIT
#include "base/denormals.h"

#include <gtest/gtest.h>

namespace phymul::test {
namespace {

TEST(DenormalsAreZero, WhileTheGuardLives) {
  if (denormals_are_zero == 0) GTEST_SKIP() << "NOT TESTED: the library knows no such switch of this processor";
  const volatile float small = 1e-30f, tenth = 0.1f, tiny = 1e-40f;
  volatile float result = 0.0f;
  const auto product = [&] { return small * (1e-9f * tenth); };  // a result below 1e-38 ...
  const auto sum = [&] { return tiny + tiny; };                  // ... and numbers below it
  EXPECT_GT(product(), 0.0f);
  EXPECT_GT(sum(), 0.0f);
  {
    const DenormalsAreZero guard;
    result = product();
    EXPECT_EQ(result, 0.0f);
    result = sum();
    EXPECT_EQ(result, 0.0f);
  }
  result = product();
  EXPECT_GT(result, 0.0f);
}

}  // namespace
}  // namespace phymul::test
