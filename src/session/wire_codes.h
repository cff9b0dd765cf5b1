// SPDX-License-Identifier: MIT
//
// Enumerators in files are their numbers, which wire_codes_test.cpp holds: they never change, and a new enumerator is
// the last.
#pragma once

#include <phymul/fluid.h>
#include <phymul/load.h>
#include <phymul/thread.h>

#include <string>

#include "base/checked_file.h"
#include "interaction/distance_to_shape.h"

namespace phymul {

constexpr int codes_of(LoadType) {
  return static_cast<int>(LoadType::acceleration) + 1;
}
constexpr int codes_of(Axis) {
  return static_cast<int>(Axis::driven) + 1;
}
/// Of files alone: a needle that is an arc, or resists where it comes out.
inline constexpr auto arc_needle = static_cast<ShapeKind>(static_cast<int>(ShapeKind::blade) + 1);
/// Of files alone: a blade that is an arc or has sides.
inline constexpr auto curved_blade = static_cast<ShapeKind>(static_cast<int>(arc_needle) + 1);
constexpr int codes_of(ShapeKind) {
  return static_cast<int>(curved_blade) + 1;
}
/// Of files alone, added to a ToolContact: of a tool with suction.
inline constexpr int with_suction = static_cast<int>(ToolContact::surface) + 1;
constexpr int codes_of(ToolContact) {
  return 2 * with_suction;
}
/// Of files alone, added to a FluidLaw: of a fluid that opens into another volume.
inline constexpr int into_another = static_cast<int>(FluidLaw::curve) + 1;
constexpr int codes_of(FluidLaw) {
  return 2 * into_another;
}
constexpr int codes_of(TipHold) {
  return static_cast<int>(TipHold::clamped) + 1;
}

template <class Enum>
void code(ByteWriter& out, Enum value, const char*) {
  out.u8(static_cast<std::uint8_t>(value));
}

/// Throws Error for a number of no enumerator.
template <class Enum>
void code(ByteReader& in, Enum& value, const char* what) {
  const std::uint8_t number = in.u8(what);
  value = static_cast<Enum>(number);
  if (number < codes_of(value)) return;
  in.fail(std::string("expected ") + what + ", a number below " + std::to_string(codes_of(value)) + ", got " +
          std::to_string(number) + "; the file is damaged, or of a newer version of phymul");
}

}  // namespace phymul
