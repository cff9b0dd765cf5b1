// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <string_view>

namespace phymul::bench {

/// Prints `usage` and says true where an argument asks for it; the program then ends with 0.
inline bool prints_usage(int argc, char** argv, const char* usage) {
  for (int k = 1; k < argc; ++k) {
    const std::string_view argument = argv[k];
    if (argument == "--help" || argument == "-h") return std::puts(usage) >= 0;
  }
  return false;
}

}  // namespace phymul::bench
