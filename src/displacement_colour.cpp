// SPDX-License-Identifier: MIT
#include <phymul/display.h>

#include <algorithm>
#include <array>

namespace phymul {

Colour displacement_colour(double share) {
  static constexpr std::array<std::array<double, 3>, 17> table{{{0.267, 0.005, 0.329},
                                                                {0.282, 0.095, 0.417},
                                                                {0.279, 0.175, 0.483},
                                                                {0.263, 0.247, 0.522},
                                                                {0.230, 0.322, 0.546},
                                                                {0.199, 0.388, 0.555},
                                                                {0.172, 0.449, 0.558},
                                                                {0.149, 0.508, 0.557},
                                                                {0.128, 0.567, 0.551},
                                                                {0.122, 0.633, 0.530},
                                                                {0.158, 0.684, 0.502},
                                                                {0.246, 0.739, 0.452},
                                                                {0.369, 0.789, 0.383},
                                                                {0.516, 0.831, 0.294},
                                                                {0.678, 0.864, 0.190},
                                                                {0.846, 0.887, 0.100},
                                                                {0.993, 0.906, 0.144}}};
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(table.size() - 1);
  const auto row = std::min(static_cast<std::size_t>(place), table.size() - 2);
  const double t = place - static_cast<double>(row);
  Colour colour{0.0, 0.0, 0.0, 1.0};
  for (std::size_t k = 0; k < 3; ++k) colour[k] = table[row][k] + t * (table[row + 1][k] - table[row][k]);
  return colour;
}

}  // namespace phymul
