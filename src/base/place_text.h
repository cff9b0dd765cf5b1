// SPDX-License-Identifier: MIT
#pragma once

#include <phymul/types.h>

#include <cstdio>
#include <string>

namespace phymul {

/// Six digits at most.
inline std::string length_text(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

/// "(0.01, 0.02, 0.03) m".
inline std::string place_text(const Vec3& x) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g) m", x.x(), x.y(), x.z());
  return text;
}

}  // namespace phymul
