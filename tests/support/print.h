// SPDX-License-Identifier: MIT
//
// What GoogleTest prints of phymul's values where a comparison fails: numbers to the last bit instead of raw bytes.
// Long lists are shown by their first rows and a hash of all bits, which says whether they differ.
#pragma once

#include <phymul/phymul.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <iomanip>
#include <ostream>
#include <sstream>

// Where GoogleTest looks for it: as containers vectors would be printed by six digits.
namespace Eigen {

inline void PrintTo(const Vector3d& v, std::ostream* out) {
  *out << std::setprecision(17) << '(' << v.x() << ' ' << v.y() << ' ' << v.z() << ')';
}

}  // namespace Eigen

namespace phymul {

namespace test {

/// A list of vectors as a few rows and the hash of all bits (FNV-1a over 64-bit words).
inline std::string brief(const VecList& list) {
  constexpr std::size_t shown = 3;
  std::uint64_t hash = 14695981039346656037u;
  for (const Vec3& v : list) {
    for (int a = 0; a < 3; ++a) hash = (hash ^ std::bit_cast<std::uint64_t>(double{v[a]})) * 1099511628211u;
  }
  std::ostringstream out;
  out << std::setprecision(17) << '[' << list.size() << "] #" << std::hex << hash << std::dec;
  for (std::size_t i = 0; i < std::min(shown, list.size()); ++i) PrintTo(list[i], &(out << ' '));
  if (list.size() > shown) out << " ...";
  return out.str();
}

}  // namespace test

inline void PrintTo(const ToolPose& pose, std::ostream* out) {
  const Quaternion& q = pose.orientation;
  *out << std::setprecision(17) << "at ";
  PrintTo(pose.position, out);
  *out << ", turned (w x y z) (" << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z() << "), velocity ";
  PrintTo(pose.velocity, out);
  PrintTo(pose.spin, &(*out << ", spin "));
}

inline void PrintTo(const ToolState& tool, std::ostream* out) {
  *out << '"' << tool.name << "\" ";
  PrintTo(tool.pose, out);
  *out << (tool.placed ? ", placed" : "") << ", holds " << test::brief(tool.held_at) << ", hole of "
       << tool.needle.hole.size() << (tool.needle.punctured ? ", punctured" : "")
       << (tool.needle.through ? ", through" : "") << ", slip " << tool.needle.slip;
}

inline void PrintTo(const State& state, std::ostream* out) {
  *out << std::setprecision(17) << "time " << state.time << "\n  position " << test::brief(state.position)
       << "\n  velocity " << test::brief(state.velocity);
  for (const ToolState& tool : state.tools) {
    *out << "\n  tool ";
    PrintTo(tool, out);
  }
}

inline void PrintTo(const Snapshot& snapshot, std::ostream* out) {
  PrintTo(snapshot.state, out);
  *out << "\n  last dt " << snapshot.last_dt << ", steps at rest " << snapshot.steps_at_rest << "\n  displacement "
       << test::brief(snapshot.displacement);
  for (const Snapshot::Part& part : snapshot.parts)
    *out << "\n  part " << part.name << " [" << part.bytes.size() << ']';
}

inline void PrintTo(const StepReport& report, std::ostream* out) {
  *out << std::setprecision(17) << report.message() << " {status " << static_cast<int>(report.status) << ", steps "
       << report.steps << ", time " << report.time << ", residual " << report.residual << ", max speed "
       << report.max_speed << (report.at_rest ? ", at rest" : "") << '}';
}

}  // namespace phymul
