// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/error.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
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

/// The item of that name; throws Error, with the known names, if there is none.
template <class Items>
auto& item_named(Items& items, const std::string& kind, std::string_view name) {
  std::string names;
  for (auto& item : items) {
    if (item.name == name) return item;
    names += (names.empty() ? "" : ", ") + item.name;
  }
  throw Error(ErrorCode::unknown_name, "the scene has no " + kind + " \"" + std::string(name) +
                                           "\"; it has: " + (names.empty() ? "none" : names));
}

/// The item of a handle.
template <class Items>
auto& item_with(Items& items, const std::string& kind, std::uint64_t id) {
  const auto own = std::ranges::find(items, id, &Items::value_type::id);
  if (own != items.end()) return *own;
  throw Error(ErrorCode::unknown_name, "the scene no longer has the " + kind + " of this handle; Scene::" + kind +
                                           " gives handles of those it has");
}

}  // namespace phymul
