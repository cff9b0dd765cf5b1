// SPDX-License-Identifier: MIT
//
// What the words after phymul-study ask for.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

struct StudyOptions {
  std::string study;
  std::string out = "out";
  int threads = 0;  ///< of this process; 0: one where there are other processes, else all processors
  bool quiet = false;
  int show = 0;                                            ///< scene whose command is printed; 0: none
  std::vector<std::pair<std::string, double>> synthesise;  ///< true values of the unknowns; empty: no
  std::uint64_t noise_seed = 1;
};

/// None where the program should end now, with `exit_code`. `prints`: false in all processes but one.
std::optional<StudyOptions> read_study_options(int argc, char** argv, bool prints, int& exit_code);
