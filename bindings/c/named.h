// SPDX-License-Identifier: MIT
//
// What a simulation of the C interface has under numbers, and the constants of it that are 0 by default.
#pragma once

#include <algorithm>

#include "handles.h"

namespace phymul::c {

/// The name of a tool, joint or thread by its number. Throws Error, with the known numbers.
template <class Rows>
const std::string& name_of(const Rows& rows, uint64_t id, const char* what) {
  std::string known;
  for (const auto& row : rows) {
    if (row.id == id) return row.name;
    known += (known.empty() ? "" : ", ") + std::to_string(row.id);
  }
  throw Error(ErrorCode::unknown_name, std::string("the simulation has no ") + what + " of the number " +
                                           std::to_string(id) +
                                           (known.empty() ? "; it has none" : "; it has: " + known));
}

inline Scene& scene_of(phymul_simulation* sim) {
  return need(sim, "a simulation").simulation.scene();
}

ToolHandle tool_of(phymul_simulation* sim, uint64_t tool);
ToolPose pose_of(const phymul_pose* given);
Anchor anchor_of(phymul_simulation* sim, const phymul_anchor* given);

/// A number of a struct in C, and where it goes in C++.
template <class From, class To>
struct Constant {
  double From::*from;
  double To::*to;
};

/// Numbers that are 0 keep the default of C++; where that is not 0, those below 0 are 0. NULL: the defaults.
template <class From, class To, std::size_t count>
To constants_of(const From* given, const Constant<From, To> (&table)[count], const char* what) {
  To result{};
  if (!given) return result;
  const From from = options_of(given, what);
  for (const auto& row : table)
    if (from.*row.from != 0.0) result.*row.to = result.*row.to != 0.0 ? std::max(from.*row.from, 0.0) : from.*row.from;
  return result;
}

}  // namespace phymul::c
