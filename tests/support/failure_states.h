// SPDX-License-Identifier: MIT
//
// States no tissue is in, from which a body should find back to its rest shape: a cube flattened, mirrored, scattered.
#pragma once

#include <functional>
#include <random>
#include <vector>

#include "bodies.h"

namespace phymul::test {

/// Turns the rest shape of a cube [0, side]^3 with the given spacing, m, into the broken state.
struct FailureState {
  const char* name;
  std::function<void(VecList& position, double side, double spacing, std::mt19937& bits)> apply;
};

inline void shake(VecList& x, double amount, std::mt19937& bits) {
  for (Vec3& p : x) p += amount * random_vector(bits, 3);
}

/// Every particle through a map of the cube with side 1 and its middle at 0.
inline void map_unit_cube(VecList& x, double side, const std::function<Vec3(const Vec3&)>& map) {
  const Vec3 middle = Vec3::Constant(side / 2);
  for (Vec3& p : x) p = middle + side * map((p - middle) / side);
}

/// Flattens along the last `axes` axes.
inline void flatten(VecList& x, double side, int axes) {
  map_unit_cube(x, side, [axes](Vec3 p) {
    p.tail(axes).setZero();
    return p;
  });
}

inline void scatter(VecList& x, double side, double reach, std::mt19937& bits) {
  map_unit_cube(x, side, [&](const Vec3&) { return Vec3(reach * random_vector(bits, 3)); });
}

inline const std::vector<FailureState>& failure_states() {
  using Bits = std::mt19937;
  constexpr double turn = 6.283185307179586;
  static const std::vector<FailureState> all{
      {"flat", [](VecList& x, double side, double, Bits&) { flatten(x, side, 1); }},
      {"flat, noise", [](VecList& x, double side, double h, Bits& b) { flatten(x, side, 1), shake(x, 1e-3 * h, b); }},
      {"line, noise", [](VecList& x, double side, double h, Bits& b) { flatten(x, side, 2), shake(x, 1e-3 * h, b); }},
      {"point, noise", [](VecList& x, double side, double h, Bits& b) { flatten(x, side, 3), shake(x, 1e-3 * h, b); }},
      {"mirrored", [](VecList& x, double side, double,
                      Bits&) { map_unit_cube(x, side, [](const Vec3& p) { return Vec3(-p.x(), p.y(), p.z()); }); }},
      {"random", [](VecList& x, double side, double, Bits& b) { scatter(x, side, 0.5, b); }},
      {"random, 3x", [](VecList& x, double side, double, Bits& b) { scatter(x, side, 1.5, b); }},
      {"stretched 10x",
       [](VecList& x, double side, double, Bits&) {
         map_unit_cube(x, side, [](const Vec3& p) { return Vec3(p.x(), p.y(), 10 * p.z()); });
       }},
      {"squashed", [](VecList& x, double side, double,
                      Bits&) { map_unit_cube(x, side, [](const Vec3& p) { return Vec3(p.x(), p.y(), p.z() / 10); }); }},
      {"twisted",
       [](VecList& x, double side, double, Bits&) {
         map_unit_cube(x, side, [](const Vec3& p) { return Vec3(Eigen::AngleAxisd(turn * p.z(), Vec3::UnitZ()) * p); });
       }},
      {"inside out",
       [](VecList& x, double side, double, Bits&) {
         map_unit_cube(x, side, [](const Vec3& p) { return Vec3(p.x(), p.y(), -std::abs(p.z())); });
       }},
      {"pulled 10 sides", [](VecList& x, double side, double, Bits&) { x.back().x() += 10 * side; }},
      {"swapped",
       [](VecList& x, double, double, Bits& b) {
         for (int k = 0; k < 6; ++k) std::swap(x[b() % x.size()], x[b() % x.size()]);
       }},
      {"noise 0.8 h", [](VecList& x, double, double h, Bits& b) { shake(x, 0.8 * h, b); }}};
  return all;
}

}  // namespace phymul::test
