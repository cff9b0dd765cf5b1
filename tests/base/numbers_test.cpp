// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

#include "base/decimal.h"
#include "base/denormals.h"

namespace phymul {
namespace {

TEST(Decimal, ParsesWholeNumbersOnly) {
  EXPECT_EQ(parse_decimal("12.5"), 12.5);
  EXPECT_EQ(parse_decimal(" +1 \n"), 1.0);
  EXPECT_EQ(parse_decimal("-.5e+1"), -5.0);
  for (const char* const wrong : {"", " ", "+", "+-1", "++1", "1,5", "abc", "1.5mm", "1 2", "0x10", "nan", "inf",
                                  "-inf", "infinity", "1e400", "--1", "1e", "e5"}) {
    EXPECT_FALSE(parse_decimal(wrong)) << wrong;
    EXPECT_FALSE(DecimalUnit(1e-3).parse(wrong)) << wrong;
    EXPECT_FALSE(DecimalUnit(0.0254).parse(wrong)) << wrong;
  }
  EXPECT_EQ(parse_integer("+7 "), 7);
  EXPECT_EQ(parse_integer("-5"), -5);
  for (const char* const wrong : {"", "1.0", "1e3", "9223372036854775808", "7x", "+-7"}) {
    EXPECT_FALSE(parse_integer(wrong)) << wrong;
  }
}

TEST(Decimal, ShiftsTheExponentInsteadOfRounding) {
  const DecimalUnit millimetre(1e-3);
  EXPECT_EQ(millimetre.parse("12.5"), 0.0125);
  EXPECT_EQ(millimetre.parse("1.1"), 0.0011);
  EXPECT_EQ(millimetre.parse(" +3e+1 "), 0.03);
  EXPECT_EQ(millimetre.parse("2E-1"), 0.0002);
  EXPECT_EQ(millimetre.parse(std::string(200, '0').append("1")), 0.001);
  for (const char* const wrong :
       {"1e 3", "1 e3", "1e3 3", "1e+-3", "1e99999999999999999999", "1e9999999", "1e-9223372036854775808"}) {
    EXPECT_FALSE(millimetre.parse(wrong)) << wrong;
  }
}

TEST(Decimal, WhatIsTooSmallIsZero) {
  for (const std::string& tiny : {std::string("1e-400"), std::string("-2.5E-0400"), std::string("100e-999"),
                                  std::string("1e-99999999999999999999"), "0." + std::string(400, '0') + "1"}) {
    EXPECT_EQ(parse_decimal(tiny), 0.0) << tiny;
  }
  EXPECT_EQ(parse_decimal("1e-322"), 1e-322);
  EXPECT_EQ(DecimalUnit(1e-3).parse("1e-322"), 0.0);
  EXPECT_EQ(DecimalUnit(0.0254).parse("1e-400"), 0.0);
  for (const std::string& large : {std::string("1e400"), std::string("1E+400"), std::string("0.01e999"),
                                   std::string("1e99999999999999999999"), std::string(400, '1') + "e-1"}) {
    EXPECT_FALSE(parse_decimal(large)) << large;
  }
}

TEST(Decimal, WritesReadably) {
  const auto text = [](double value, double unit) {
    std::string out;
    DecimalUnit(unit).append(out, value);
    return out;
  };
  EXPECT_EQ(text(0.0125, 1e-3), "12.5");
  EXPECT_EQ(text(-0.0125, 1e-3), "-12.5");
  EXPECT_EQ(text(2.0, 1e-3), "2000");
  EXPECT_EQ(text(0.0000025, 1e-3), "0.0025");
  EXPECT_EQ(text(0.0, 1e-3), "0");
  EXPECT_EQ(text(6.123234e-19, 1e-3), "6.123234e-16");
  EXPECT_EQ(text(0.0254, 0.0254), "1");
  EXPECT_EQ(text(0.25, 1.0), "0.25");
}

TEST(Decimal, EveryDoubleComesBackBitByBitInPowersOfTen) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> place(-0.3, 0.3);
  for (const double unit : {1e-3, 1e-6, 1e-2, 1.0, 1e3}) {
    const DecimalUnit scale(unit);
    for (int i = 0; i < 20000; ++i) {
      // Half of them places of a body, half of them any bit pattern.
      double value = i % 2 == 0 ? place(random) : std::bit_cast<double>(random());
      if (!std::isfinite(value)) continue;
      std::string text;
      scale.append(text, value);
      const std::optional<double> back = scale.parse(text);
      ASSERT_TRUE(back) << text;
      ASSERT_EQ(std::bit_cast<std::uint64_t>(*back), std::bit_cast<std::uint64_t>(value)) << text << " unit " << unit;
    }
  }
}

TEST(Decimal, WhatWasReadInOtherUnitsComesBackBitByBit) {
  std::mt19937_64 random(3);
  std::uniform_int_distribution<int> digits(1, 99999);
  for (const double unit : {0.0254, 0.3048, 3.0}) {
    const DecimalUnit scale(unit);
    for (int i = 0; i < 20000; ++i) {
      const double value = scale.parse(std::to_string(digits(random)) + "e-4").value();
      std::string text;
      scale.append(text, value);
      ASSERT_EQ(scale.parse(text), value) << text;
    }
  }
}

TEST(Decimal, OtherUnitsComeBackWithinTwoUnitsInTheLastPlace) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> place(-0.3, 0.3);
  const DecimalUnit inch(0.0254);
  for (int i = 0; i < 20000; ++i) {
    const double value = place(random);
    std::string text;
    inch.append(text, value);
    ASSERT_LE(std::abs(inch.parse(text).value() - value), std::abs(value) * 2 * std::numeric_limits<double>::epsilon());
  }
}

}  // namespace
}  // namespace phymul

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
