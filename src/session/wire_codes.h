// SPDX-License-Identifier: MIT
//
// Numbers that stand for enumerators in files. They never change; a new enumerator gets a new number.
#pragma once

#include <phymul/load.h>

#include <array>
#include <cstdint>
#include <string>

#include "base/checked_file.h"

namespace phymul {

template <class Value>
struct WireCode {
  Value value;
  std::uint8_t code;
};
// Clang deduces this by itself from version 17 on.
template <class Value>
WireCode(Value, int) -> WireCode<Value>;

inline constexpr std::array load_type_codes{
    WireCode{LoadType::translation, 0}, WireCode{LoadType::rotation, 1},     WireCode{LoadType::force, 2},
    WireCode{LoadType::pressure, 3},    WireCode{LoadType::acceleration, 4},
};

inline constexpr std::array axis_codes{
    WireCode{Axis::free, 0},
    WireCode{Axis::held, 1},
    WireCode{Axis::driven, 2},
};

template <class Table, class Value>
void put_code(ByteWriter& out, const Table& table, Value value) {
  for (const auto& row : table) {
    if (row.value == value) return out.u8(row.code);
  }
}

/// Throws Error for a number that no row has.
template <class Table>
auto take_code(ByteReader& in, const Table& table, const char* what) {
  const std::uint8_t code = in.u8(what);
  for (const auto& row : table) {
    if (row.code == code) return row.value;
  }
  in.fail(std::string("expected ") + what + ", a number below " + std::to_string(table.size()) + ", got " +
          std::to_string(code) + "; the file is damaged, or of a newer version of phymul");
}

}  // namespace phymul
