// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace phymul {

/// "<kind> <number>" with the first number from `number` on that no item of the scene has in its name.
template <class Named>
std::string default_name(const std::string& kind, std::uint64_t number, const std::vector<Named>& items) {
  while (true) {
    std::string name = kind + ' ' + std::to_string(number++);
    if (std::ranges::find(items, name, &Named::name) == items.end()) return name;
  }
}

}  // namespace phymul
