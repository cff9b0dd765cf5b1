// SPDX-License-Identifier: MIT
#include <phymul/display.h>

#include <algorithm>
#include <array>

namespace phymul {

/// At equal distances in CIELAB, along lightness 92 to 26, hue 190 to 320 degrees, chroma 5 to 60.
Colour displacement_colour(double share) {
  static constexpr std::array<std::array<double, 3>, 17> table{{{0.867, 0.922, 0.916},
                                                                {0.761, 0.893, 0.891},
                                                                {0.650, 0.849, 0.868},
                                                                {0.542, 0.800, 0.852},
                                                                {0.442, 0.750, 0.841},
                                                                {0.351, 0.699, 0.831},
                                                                {0.272, 0.647, 0.820},
                                                                {0.212, 0.596, 0.807},
                                                                {0.180, 0.545, 0.790},
                                                                {0.182, 0.494, 0.768},
                                                                {0.208, 0.443, 0.741},
                                                                {0.244, 0.392, 0.709},
                                                                {0.281, 0.341, 0.671},
                                                                {0.315, 0.288, 0.628},
                                                                {0.344, 0.234, 0.581},
                                                                {0.367, 0.175, 0.530},
                                                                {0.385, 0.104, 0.475}}};
  // Not clamp(): a share that is not a number, as 0 / 0 of a body at rest, counts as 0.
  const double place = (share > 0.0 ? std::min(share, 1.0) : 0.0) * static_cast<double>(table.size() - 1);
  const auto row = std::min(static_cast<std::size_t>(place), table.size() - 2);
  const double t = place - static_cast<double>(row);
  Colour colour{0.0, 0.0, 0.0, 1.0};
  for (std::size_t k = 0; k < 3; ++k) colour[k] = table[row][k] + t * (table[row + 1][k] - table[row][k]);
  return colour;
}

}  // namespace phymul
