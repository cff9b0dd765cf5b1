// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace phymul {

inline std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// With its dot, in lower case: ".stl".
inline std::string file_ending(const std::string& path) {
  return lower_case(std::filesystem::path(path).extension().string());
}

}  // namespace phymul
