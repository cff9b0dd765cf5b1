// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace phymul {

/// Of the letters A to Z, whatever the locale.
inline std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

/// With its dot, in lower case: ".stl".
inline std::string file_ending(const std::string& path) {
  return lower_case(std::filesystem::path(path).extension().string());
}

}  // namespace phymul
