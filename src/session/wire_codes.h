// SPDX-License-Identifier: MIT
//
// Enumerators in files are their numbers, which cut_files_test.cpp holds: they never change, and a new enumerator is
// the last. The kinds of inputs (phymul::Input) that the library itself makes.
#pragma once

#include <phymul/fluid.h>
#include <phymul/load.h>
#include <phymul/thread.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

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

namespace phymul::input_kind {

inline constexpr std::string_view step = "step";            ///< n (i32), dt (f64)
inline constexpr std::string_view to_rest = "rest";         ///< the same
inline constexpr std::string_view to_rest_damped = "rstd";  ///< the same, damping rate and factor (f64)
inline constexpr std::string_view restore = "rset";         ///< a snapshot; of a reset, a plain state's
inline constexpr std::string_view scene = "scne";           ///< scene_bytes.h
inline constexpr std::string_view pose = "pose";            ///< a tool's name, whether it is placed (u8), the pose
inline constexpr std::string_view grasp = "grsp";       ///< a tool's name, whether it grasps (u8), the distance (f64)
inline constexpr std::string_view checkpoint = "chck";  ///< fingerprint of the snapshot (u64), time (f64)
inline constexpr std::string_view removed = "cell";     ///< rows of the cells that are removed from then on (i32 each)
inline constexpr std::string_view cut = "cuts";         ///< how many cuts stay (u64), those after them (scene_bytes.h)
inline constexpr std::string_view thread = "thrd";      ///< a thread's name, ThreadChange (u8), what changed
inline constexpr std::string_view later = "late";  ///< a snapshot with Snapshot::Start::cut_later alone, at the end

inline constexpr std::array all{step,  to_rest,    to_rest_damped, restore, scene,  pose,
                                grasp, checkpoint, removed,        cut,     thread, later};

enum class ThreadChange : std::uint8_t { control, adds, removes };

inline bool is_own(std::string_view kind) {
  return std::find(all.begin(), all.end(), kind) != all.end();
}

}  // namespace phymul::input_kind
