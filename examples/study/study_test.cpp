// SPDX-License-Identifier: MIT
//
// Parts of phymul-study: tables, statistics, identification.
#include <gtest/gtest.h>
#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "crew.h"
#include "fit.h"
#include "sampler.h"
#include "tables.h"

namespace {

Study sampled_study() {
  Study study;
  study.parameters = {{"load", Spread::list, {1.0, 2.0, 3.0}, 1},
                      {"young", Spread::uniform, {2e3, 6e3}, 2},
                      {"turn", Spread::list, {-1.0, 1.0}, 3},
                      {"tilt", Spread::normal, {10.0, 2.0}, 4}};
  study.samples = 50;
  study.seed = 7;
  return study;
}

TEST(StudySampler, EachIntervalOfEachDimensionHasOneValue) {
  for (const int count : {1, 2, 7, 100}) {
    const auto cube = latin_hypercube(count, 4, 3);
    ASSERT_EQ(cube.size(), count);
    for (int d = 0; d < 4; ++d) {
      std::set<int> intervals;
      for (const auto& row : cube) {
        EXPECT_GT(row[d], 0.0);
        EXPECT_LT(row[d], 1.0);
        intervals.insert(static_cast<int>(row[d] * count));
      }
      EXPECT_EQ(intervals.size(), count);
    }
  }
}

TEST(StudySampler, DimensionsAndSeedsAreIndependent) {
  const int count = 400;
  const auto cube = latin_hypercube(count, 3, 1);
  const auto correlation = [&](const auto& a, int i, const auto& b, int j) {
    double sum = 0.0;
    for (int k = 0; k < count; ++k) sum += (a[k][i] - 0.5) * (b[k][j] - 0.5);
    return 12.0 * sum / count;
  };
  EXPECT_NEAR(correlation(cube, 0, cube, 0), 1.0, 0.01);
  const auto other = latin_hypercube(count, 3, 2);
  for (int d = 0; d < 3; ++d) {
    EXPECT_LT(std::abs(correlation(cube, d, cube, (d + 1) % 3)), 4.0 / std::sqrt(count));
    EXPECT_LT(std::abs(correlation(cube, d, other, d)), 4.0 / std::sqrt(count));
  }
}

/// The generator is defined by its source: a change of it would give the samples of a study other values.
TEST(StudySampler, ValuesAreTheSameEverywhere) {
  const auto cube = latin_hypercube(2, 1, 0);
  // SplitMix64 from 0: 0xe220a8397b1dcdaf, 0x6e789e6aa1b965f4, 0x06c45d188009454f.
  const auto share = [](std::uint64_t bits) { return (static_cast<double>(bits >> 12) + 0.5) * 0x1p-52; };
  EXPECT_EQ(cube[0][0], (0 + share(0x6e789e6aa1b965f4U)) / 2);
  EXPECT_EQ(cube[1][0], (1 + share(0x06c45d188009454fU)) / 2);
}

TEST(StudySampler, TableHasTheSameSamplesInEveryCombinationOfTheLists) {
  const Study study = sampled_study();
  const auto table = study_table(study);
  ASSERT_EQ(table.size(), 3 * 2 * 50);
  for (std::size_t k = 0; k < table.size(); ++k) {
    EXPECT_EQ(table[k][0], study.parameters[0].values[k / 100]);
    EXPECT_EQ(table[k][2], study.parameters[2].values[k / 50 % 2]);
    EXPECT_EQ(table[k][1], table[k % 50][1]);
    EXPECT_EQ(table[k][3], table[k % 50][3]);
    EXPECT_GE(table[k][1], 2e3);
    EXPECT_LE(table[k][1], 6e3);
  }
}

TEST(StudySampler, NormalAndLognormalHaveTheirMomentsAndMedian) {
  Study study;
  study.parameters = {{"a", Spread::normal, {10.0, 2.0}, 1}, {"b", Spread::lognormal, {100.0, 2.0}, 2}};
  study.samples = 1000;
  std::vector<double> a, b;
  for (const auto& row : study_table(study)) a.push_back(row[0]), b.push_back(row[1]);
  double mean = 0.0, variance = 0.0;
  for (const double x : a) mean += x / 1000;
  for (const double x : a) variance += (x - mean) * (x - mean) / 999;
  EXPECT_NEAR(mean, 10.0, 0.01);
  EXPECT_NEAR(std::sqrt(variance), 2.0, 0.03);
  std::ranges::sort(b);
  EXPECT_NEAR(percentile(b, 0.5), 100.0, 0.5);
  EXPECT_NEAR(percentile(b, 0.8413447), 200.0, 2.0);  // one standard deviation of the logarithm
}

TEST(StudySampler, RefusesTablesThatNoMachineHolds) {
  Study study = sampled_study();
  study.file = "huge.study";
  study.samples = 1'000'000'000;
  EXPECT_THROW(study_table(study), phymul::Error);
}

TEST(StudyTables, PercentilesInterpolate) {
  EXPECT_EQ(percentile({1.0, 2.0, 3.0, 4.0, 5.0}, 0.5), 3.0);
  EXPECT_EQ(percentile({1.0, 2.0}, 0.25), 1.25);
  EXPECT_EQ(percentile({1.0, 2.0}, 1.0), 2.0);
  EXPECT_EQ(percentile({4.0}, 0.95), 4.0);
}

TEST(StudyTables, SpreadOfATargetIsThatOfItsPlaces) {
  std::vector<SceneResult> results;
  for (const double x : {-1.0, 0.0, 1.0}) {
    results.push_back({.failure = {}, .values = {9, 9, 9, 9, 9, 9, 5 + x, 2 * x, 1, x, 2 * x, 0}});
  }
  results.push_back({.failure = "none", .values = {}});
  const TargetSpread spread = target_spread(results, 1);
  EXPECT_EQ(spread.found, 3);
  EXPECT_EQ(spread.failed, 1);
  EXPECT_NEAR((spread.mean - phymul::Vec3(5, 0, 1)).norm(), 0.0, 1e-15);
  Eigen::Matrix3d covariance;
  covariance << 1, 2, 0, 2, 4, 0, 0, 0, 0;
  EXPECT_NEAR((spread.covariance - covariance).norm(), 0.0, 1e-14);
  EXPECT_NEAR(spread.displacement[1], std::sqrt(5.0), 1e-15);
  EXPECT_NEAR(spread.displacement[2], std::sqrt(5.0), 1e-15);
  EXPECT_NEAR(spread.displacement[0], 0.1 * std::sqrt(5.0), 1e-15);  // of 0, root 5, root 5
  EXPECT_NEAR(spread.distance[0], std::sqrt(5.0), 1e-15);
}

/// Three points on two springs in a row, as an experiment whose answer is known.
struct TwoSprings {
  Study study;
  int solved = 0;

  explicit TwoSprings(std::uint64_t seed, double deviation = 0.01) {
    study.file = "springs.study";
    study.unknowns = {{"a", 3.0, 1}, {"b", 3.0, 2}};
    study.measurement.deviation = deviation;
    study.measurement.point.resize(3);
    NormalNoise noise(seed);
    const SceneResult exact = solve({1.0, 10.0});
    for (int k = 0; k < 3; ++k) {
      phymul::Vec3& u = study.measurement.displacement.emplace_back();
      for (int axis = 0; axis < 3; ++axis) u[axis] = exact.values[3 * k + axis] + deviation * noise.next();
    }
  }

  static SceneResult solve(const std::vector<double>& v) {
    const double first = 1.0 / v[0], both = first + 1.0 / v[1];
    return {.failure = {}, .values = {first, both, 0.5 * first, both, first, 0, both, both, 2 * both}};
  }

  StudyFit fit(bool ahead = false) {
    const SceneEvaluator evaluate = [&](const std::vector<std::vector<double>>& scenes) {
      std::vector<SceneResult> results;
      for (const auto& scene : scenes) results.push_back(solve(scene)), ++solved;
      return results;
    };
    return fit_unknowns(study, evaluate, ahead);
  }
};

TEST(StudyFit, FindsTheUnknownsOfAnExactMeasurement) {
  TwoSprings springs(1, 1e-9);
  const StudyFit fit = springs.fit();
  EXPECT_TRUE(fit.converged);
  ASSERT_EQ(fit.unknowns.size(), 2);
  EXPECT_NEAR(fit.unknowns[0].value, 1.0, 1e-6);
  EXPECT_NEAR(fit.unknowns[1].value, 10.0, 1e-5);
}

/// The deviation that a fit claims is the one that its values have over many measurements, and so is the correlation.
TEST(StudyFit, DeviationIsThatOfManyMeasurements) {
  const int count = 400;
  std::vector<double> a, b;
  double claimed_a = 0.0, claimed_b = 0.0, claimed_correlation = 0.0, misfit = 0.0;
  for (int k = 0; k < count; ++k) {
    const StudyFit fit = TwoSprings(100 + k).fit();
    ASSERT_TRUE(fit.converged);
    a.push_back(fit.unknowns[0].value);
    b.push_back(fit.unknowns[1].value);
    claimed_a += fit.unknowns[0].deviation / count;
    claimed_b += fit.unknowns[1].deviation / count;
    claimed_correlation += fit.correlation(0, 1) / count;
    misfit += fit.misfit * fit.misfit / count;
  }
  double mean_a = 0.0, mean_b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  for (int k = 0; k < count; ++k) mean_a += a[k] / count, mean_b += b[k] / count;
  for (int k = 0; k < count; ++k) {
    aa += (a[k] - mean_a) * (a[k] - mean_a) / (count - 1);
    bb += (b[k] - mean_b) * (b[k] - mean_b) / (count - 1);
    ab += (a[k] - mean_a) * (b[k] - mean_b) / (count - 1);
  }
  EXPECT_NEAR(mean_a, 1.0, 4 * claimed_a / std::sqrt(count));
  // Of 400 values the deviation is known to 3.5 %; four times that, and b's own is not normal.
  EXPECT_NEAR(std::sqrt(aa) / claimed_a, 1.0, 0.14);
  EXPECT_NEAR(std::sqrt(bb) / claimed_b, 1.0, 0.14);
  EXPECT_NEAR(ab / std::sqrt(aa * bb), claimed_correlation, 0.1);
  EXPECT_NEAR(misfit, 1.0, 4 * std::sqrt(2.0 / 7 / count));
}

TEST(StudyFit, AskingAheadChangesNoBit) {
  const StudyFit one = TwoSprings(5).fit(false), other = TwoSprings(5).fit(true);
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(one.unknowns[k].value, other.unknowns[k].value);
    EXPECT_EQ(one.unknowns[k].deviation, other.unknowns[k].deviation);
  }
}

/// The search tries a place and turns back; beyond it, where only derivatives there would look, nothing has a result.
TEST(StudyFit, AskingAheadNeedsNoSceneThatTheSearchDoesNotNeed) {
  Study study;
  study.unknowns = {{"a", std::exp(2.0), 1}};
  study.measurement.deviation = 1.0;
  study.measurement.point.resize(1);
  study.measurement.displacement.emplace_back(0, 0, 0);
  double farthest = 0.0, end = -HUGE_VAL;  // logarithms
  const SceneEvaluator bent = [&](const std::vector<std::vector<double>>& scenes) {
    std::vector<SceneResult> results;
    for (const auto& scene : scenes) {
      const double x = std::log(scene[0]);
      farthest = std::min(farthest, x);
      results.push_back({.failure = x < end ? "folded" : "", .values = {std::atan(x), 0, 0}});
    }
    return results;
  };
  const StudyFit alone = fit_unknowns(study, bent, false);
  EXPECT_LT(farthest, -3.0);
  end = farthest - 0.005;
  const StudyFit ahead = fit_unknowns(study, bent, true);
  EXPECT_EQ(ahead.unknowns[0].value, alone.unknowns[0].value);
}

TEST(StudyFit, SaysWhatTheMeasurementDoesNotDetermine) {
  TwoSprings springs(1);
  const SceneEvaluator blind = [](const std::vector<std::vector<double>>& scenes) {
    std::vector<SceneResult> results;
    for (const auto& scene : scenes) results.push_back(TwoSprings::solve({scene[0], 5.0}));
    return results;
  };
  try {
    fit_unknowns(springs.study, blind, false);
    FAIL() << "expected an error";
  } catch (const phymul::Error& error) {
    EXPECT_NE(std::string(error.what()).find("do not determine b;"), std::string::npos) << error.what();
  }
}

TEST(StudyCrew, EndsWithoutThoseThreadsThatCouldNotBeMade) {
  int made = 0;
  const auto make_work = [&made]() -> SceneWork {
    if (++made == 3) throw phymul::Error("no third one");
    return [](const std::vector<double>&) { return SceneResult(); };
  };
  EXPECT_THROW(StudyCrew(4, make_work), phymul::Error);
}

TEST(StudyFit, SaysWhichSceneHasNoResult) {
  TwoSprings springs(1);
  const SceneEvaluator failing = [](const std::vector<std::vector<double>>& scenes) {
    return std::vector<SceneResult>(scenes.size(), {.failure = "folded", .values = {}});
  };
  EXPECT_THROW(fit_unknowns(springs.study, failing, false), phymul::Error);
}

}  // namespace
