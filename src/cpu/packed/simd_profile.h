// SPDX-License-Identifier: MIT
//
// What a profile tells apart in the steps of the SIMD backend: kinds of kernels, and the work beside them.
#pragma once

#include <array>

#include "packed_body.h"
#include "solver/profile.h"

namespace phymul::cpu {

enum class Work {
  loads,
  gathering,
  bases,
  enumerated_bases,
  springs,
  volumes,
  walls,
  averaged_stresses,
  averaged_forces,
  waiting,
  move,
  tools,
  contacts,  // and kept volumes
  checks
};

/// Laps of the calling thread, whose kernels stand for those of the others. Without a profile it asks no clock.
class WorkLaps {
 public:
  WorkLaps(Profile* profile, const PackedBody& body);

  void begin() { laps_ = Laps(profile_); }
  /// A piece of work of this kind is done; its step is counted by end_step().
  void end(Work work) {
    if (profile_) laps_.end(row_of(work), 0);
  }
  /// Every kind of work that the body has ran once; that of tools and of contacts where there are any.
  void end_step(bool tools, bool contacts);

 private:
  static constexpr int kinds = 14;
  int row_of(Work work) const { return rows_[static_cast<std::size_t>(work)]; }

  Profile* profile_;
  Laps laps_{nullptr};
  std::array<int, kinds> rows_{};
  std::array<bool, kinds> runs_{};
};

}  // namespace phymul::cpu
