// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

struct Rgb {
  double red, green, blue;  ///< in [0, 1]
};

/// Viridis (Smith and van der Walt, 2015, CC0), at 17 places: even steps look even, also to the colour-blind and in
/// grey print. `share` in [0, 1].
inline Rgb viridis(double share) {
  static constexpr std::array<Rgb, 17> table{{{0.267, 0.005, 0.329},
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
  const auto mix = [t](double a, double b) { return a + t * (b - a); };
  const Rgb &a = table[row], &b = table[row + 1];
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}
