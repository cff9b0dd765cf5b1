// SPDX-License-Identifier: MIT
//
// The values of a study's parameters, scene by scene: every combination of the lists, and within each the same Latin
// hypercube of the parameters that are sampled. Depends on the file alone: not on the machine, nor on the number of
// processes.
#pragma once

#include <cstdint>
#include <vector>

#include "file.h"

/// [count][dimensions] in (0, 1): of each dimension every interval of length 1 / count holds exactly one value, at a
/// random place in it; intervals of different dimensions are paired at random.
std::vector<std::vector<double>> latin_hypercube(int count, int dimensions, std::uint64_t seed);

/// [scenes][Study::parameters]; the first parameter's list changes slowest, the sample fastest. Throws phymul::Error
/// for more than ten million scenes.
std::vector<std::vector<double>> study_table(const Study& study);

/// Scenes that differ in the sampled parameters alone; they follow each other.
std::size_t scenes_of_a_combination(const Study& study);

/// Random numbers of the normal distribution; the same on every machine.
class NormalNoise {
 public:
  explicit NormalNoise(std::uint64_t seed);
  double next();

 private:
  std::uint64_t state_;
};
