// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

#include <bit>
#include <cstdint>
#include <string_view>
#include <type_traits>

namespace phymul {

/// FNV-1a, fed a number at a time: structs may have gaps between their members.
class Fnv {
 public:
  template <class T>
  void add(const T& value) {
    if constexpr (std::is_same_v<T, double>) {
      mix(std::bit_cast<std::uint64_t>(value), 8);
    } else if constexpr (std::is_enum_v<T>) {
      mix(static_cast<std::uint64_t>(value), 4);
    } else if constexpr (std::is_integral_v<T>) {
      mix(static_cast<std::uint64_t>(value), sizeof(T));
    } else {
      for (const auto& part : value) add(part);
    }
  }
  void add(const Vec3& v) {
    for (int a = 0; a < 3; ++a) add(v[a]);
  }
  void add(const VecList& list) {
    add(std::uint64_t{list.size()});  // as wide on every system
    for (const Vec3& v : list) add(v);
  }
  /// One after the other.
  template <class First, class Second, class... More>
  void add(const First& first, const Second& second, const More&... more) {
    add(first);
    add(second);
    (add(more), ...);
  }
  void bytes(std::string_view text) {
    for (const char c : text) mix(static_cast<unsigned char>(c), 1);
  }
  std::uint64_t value() const { return value_; }

 private:
  void mix(std::uint64_t bits, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) value_ = (value_ ^ (bits >> 8 * k & 0xff)) * 0x100000001b3ull;
  }
  std::uint64_t value_ = 0xcbf29ce484222325ull;
};

}  // namespace phymul
