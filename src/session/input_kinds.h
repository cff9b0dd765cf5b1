// SPDX-License-Identifier: MIT
//
// The kinds of inputs (phymul::Input) that the library itself makes.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

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
inline constexpr std::string_view cut = "cuts";         ///< how many cuts stay (u64), those after them (cut_bytes.h)
inline constexpr std::string_view thread = "thrd";      ///< a thread's name, ThreadChange (u8), what changed
inline constexpr std::string_view later = "late";  ///< a snapshot with Snapshot::Start::cut_later alone, at the end

inline constexpr std::array all{step,  to_rest,    to_rest_damped, restore, scene,  pose,
                                grasp, checkpoint, removed,        cut,     thread, later};

enum class ThreadChange : std::uint8_t { control, adds, removes };

inline bool is_own(std::string_view kind) {
  return std::find(all.begin(), all.end(), kind) != all.end();
}

}  // namespace phymul::input_kind
