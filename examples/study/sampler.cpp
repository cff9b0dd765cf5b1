// SPDX-License-Identifier: MIT
#include "sampler.h"

#include <phymul/error.h>

#include <unsupported/Eigen/SpecialFunctions>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace {

/// SplitMix64: Steele, Lea, Flood, Fast splittable pseudorandom number generators, OOPSLA 2014. The distributions of
/// the standard library differ between its implementations.
std::uint64_t next_bits(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15U;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

/// Between 0 and 1, both left out.
double next_share(std::uint64_t& state) {
  return (static_cast<double>(next_bits(state) >> 12) + 0.5) * 0x1p-52;
}

double value_at_share(const StudyParameter& it, double share) {
  const std::vector<double>& v = it.values;
  switch (it.spread) {
    case Spread::uniform:
      return v[0] + (v[1] - v[0]) * share;
    case Spread::normal:
      return v[0] + v[1] * Eigen::numext::ndtri(share);
    case Spread::lognormal:
      return v[0] * std::exp(std::log(v[1]) * Eigen::numext::ndtri(share));
    case Spread::list:
      break;
  }
  return v[0];
}

}  // namespace

std::vector<std::vector<double>> latin_hypercube(int count, int dimensions, std::uint64_t seed) {
  std::vector<std::vector<double>> result(count, std::vector<double>(dimensions));
  std::vector<int> interval(count);
  std::uint64_t state = seed;
  for (int d = 0; d < dimensions; ++d) {
    std::iota(interval.begin(), interval.end(), 0);
    for (int k = count - 1; k > 0; --k) {
      // The bias of the remainder is below count / 2^64.
      std::swap(interval[k], interval[static_cast<int>(next_bits(state) % static_cast<std::uint64_t>(k + 1))]);
    }
    constexpr double below_1 = 1.0 - 0x1p-53;
    for (int k = 0; k < count; ++k) result[k][d] = std::min((interval[k] + next_share(state)) / count, below_1);
  }
  return result;
}

std::size_t scenes_of_a_combination(const Study& study) {
  return study.samples > 0 ? static_cast<std::size_t>(study.samples) : 1;
}

std::vector<std::vector<double>> study_table(const Study& study) {
  const std::size_t most = 10'000'000, each = scenes_of_a_combination(study);
  std::size_t combinations = 1;
  int sampled = 0;
  for (const StudyParameter& it : study.parameters) {
    if (it.spread == Spread::list) combinations *= it.values.size();
    if (it.spread != Spread::list) ++sampled;
    if (combinations > most / each) {
      fail_at(study.file, it.line,
              "expected at most " + std::to_string(most) + " scenes in all; shorten the lists, or take fewer samples");
    }
  }
  const auto shares = latin_hypercube(static_cast<int>(each), sampled, study.seed);
  std::vector<std::vector<double>> table;
  table.reserve(combinations * each);
  for (std::size_t c = 0; c < combinations; ++c) {
    for (std::size_t s = 0; s < each; ++s) {
      std::vector<double>& row = table.emplace_back(study.parameters.size());
      std::size_t rest = c;
      int dimension = sampled;
      for (std::size_t p = row.size(); p-- > 0;) {
        const StudyParameter& it = study.parameters[p];
        if (it.spread != Spread::list) {
          row[p] = value_at_share(it, shares[s][--dimension]);
        } else {
          row[p] = it.values[rest % it.values.size()];
          rest /= it.values.size();
        }
      }
    }
  }
  return table;
}

NormalNoise::NormalNoise(std::uint64_t seed) : state_(seed) {}

double NormalNoise::next() {
  return Eigen::numext::ndtri(next_share(state_));
}
