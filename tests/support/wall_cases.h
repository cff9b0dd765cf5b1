// SPDX-License-Identifier: MIT
//
// Plates and shells of known deflection. Each returns the relative error of a displacement under a small load.
#pragma once

#include <cstdint>
#include <numbers>

#include "walls.h"

namespace phymul::test {

inline double degrees(double angle) {
  return angle * std::numbers::pi / 180.0;
}

/// Bits of the coordinates that are held at particle X.
using Held = std::function<int(const Vec3&)>;

inline std::vector<std::uint8_t> held_of(const Model& model, const Held& held) {
  std::vector<std::uint8_t> fixed;
  for (const Vec3& X : model.rest) fixed.push_back(static_cast<std::uint8_t>(held(X)));
  return fixed;
}

inline std::size_t particle_at(const Model& model, const Vec3& place) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    if ((model.rest[i] - place).norm() < (model.rest[best] - place).norm()) best = i;
  }
  return best;
}

/// Circular plate of 1 + 3 n (n + 1) particles under pressure: w = p a^4 / (64 D) clamped, times (5 + nu) / (1 + nu) on
/// a hinge (Timoshenko and Woinowsky-Krieger 1959, ch. 3).
inline double circular_plate(int rings, double jitter, bool clamped) {
  constexpr double E = 1e6, nu = 0.3, t = 1e-3, a = 0.1, p = 1e-3, D = E * t * t * t / 12.0 / (1.0 - nu * nu);
  Model model = wall_of(disc_surface(a, rings, jitter), E, nu, t);
  if (clamped) clamp_edges(model, [](const Vec3&) { return true; });
  const TopologyTextures tables = build_topology(model);
  WallRest plate(tables, held_of(model, [](const Vec3& X) { return X.norm() > a * (1.0 - 1e-9) ? 7 : 0; }));
  add_pressure(model, model.rest, p, plate.force);
  plate.step();
  return plate.x[0].z() * 64.0 * D / (p * a * a * a * a) / (clamped ? 1.0 : (5.0 + nu) / (1.0 + nu)) - 1.0;
}

/// A quarter, of (n + 1)^2 particles, of the Scordelis-Lo roof under its weight: 0.3024 at the middle of its free edge
/// (Belytschko et al., CMAME 51 (1985) 221).
inline double scordelis_lo_roof(int n, double jitter) {
  constexpr double E = 4.32e8, t = 0.25, R = 25.0, L = 25.0;
  const double angle = degrees(40.0);
  Model model = wall_of(
      grid_surface(n, n, jitter,
                   [&](double u, double v) { return Vec3(L * u, R * std::sin(angle * v), R * std::cos(angle * v)); }),
      E, 0.0, t);
  clamp_edges(model, [](const Vec3& X) { return X.x() < 1e-6 || X.y() < 1e-6; });
  const TopologyTextures tables = build_topology(model);
  WallRest roof(tables, held_of(model, [](const Vec3& X) {
                  return (X.x() < 1e-6 ? 1 : 0) | (X.y() < 1e-6 ? 2 : 0) | (X.x() > L - 1e-6 ? 6 : 0);
                }));
  for (const WallTexel& wall : tables.walls) {
    const Vec3 &a = model.rest[wall.vertex[0]], &b = model.rest[wall.vertex[1]], &c = model.rest[wall.vertex[2]];
    for (std::size_t k = 0; k < 3; ++k) roof.force[wall.vertex[k]].z() -= 90.0 * (b - a).cross(c - a).norm() / 6.0;
  }
  roof.step();
  const std::size_t middle = particle_at(model, {0.0, R * std::sin(angle), R * std::cos(angle)});
  return (model.rest[middle].z() - roof.x[middle].z()) / 0.3024 - 1.0;
}

/// An eighth of the pinched cylinder with end diaphragms: 1.8248e-5 under a unit load (Belytschko et al. 1985).
inline double pinched_cylinder(int n, double jitter) {
  constexpr double E = 3e6, nu = 0.3, t = 3.0, R = 300.0, L = 300.0;
  Model model = wall_of(grid_surface(n, n, jitter,
                                     [](double u, double v) {
                                       const double angle = degrees(90.0 * v);
                                       return Vec3(L * u, R * std::sin(angle), R * std::cos(angle));
                                     }),
                        E, nu, t);
  clamp_edges(model, [](const Vec3& X) { return X.x() < 1e-6 || X.y() < 1e-6 || X.z() < 1e-6; });
  const TopologyTextures tables = build_topology(model);
  WallRest cylinder(tables, held_of(model, [](const Vec3& X) {
                      return (X.x() < 1e-6 ? 1 : 0) | (X.y() < 1e-6 ? 2 : 0) | (X.z() < 1e-6 ? 4 : 0) |
                             (X.x() > L - 1e-6 ? 6 : 0);
                    }));
  const std::size_t top = particle_at(model, {0.0, 0.0, R});
  cylinder.force[top].z() = -0.25;
  cylinder.step();
  return (R - cylinder.x[top].z()) / 1.8248e-5 - 1.0;
}

/// A quarter of the hemisphere with an 18 degree hole under unit loads: 0.0940 (MacNeal and Harder 1985).
inline double hemisphere_with_hole(int n, double jitter) {
  constexpr double E = 6.825e7, nu = 0.3, t = 0.04, R = 10.0, load = 1e-3;
  Model model = wall_of(grid_surface(n, n, jitter,
                                     [](double u, double v) {
                                       const double lon = degrees(90.0 * u), lat = degrees(72.0 * v);
                                       return Vec3(R * std::cos(lat) * std::cos(lon), R * std::cos(lat) * std::sin(lon),
                                                   R * std::sin(lat));
                                     }),
                        E, nu, t);
  clamp_edges(model, [](const Vec3& X) { return X.x() < 1e-3 || X.y() < 1e-3; });
  const TopologyTextures tables = build_topology(model);
  WallRest shell(tables, held_of(model, [](const Vec3& X) {
                   return (X.x() < 1e-6 ? 1 : 0) | (X.y() < 1e-6 ? 2 : 0) | (X.x() > R - 1e-6 ? 4 : 0);
                 }));
  const std::size_t pulled = particle_at(model, {R, 0.0, 0.0}), pushed = particle_at(model, {0.0, R, 0.0});
  shell.force[pulled].x() = load;
  shell.force[pushed].y() = -load;
  shell.step();
  return (shell.x[pulled].x() - R) / load / 0.0940 - 1.0;
}

}  // namespace phymul::test
