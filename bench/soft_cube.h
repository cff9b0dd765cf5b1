// SPDX-License-Identifier: MIT
//
// The workload on which other engines were measured (bench/reference/peers/README.md): a cube of side 0.1 m with n^3
// particles, five tetrahedra a cell in the alternating pattern, face x = 0 held, gravity along -y, no damping, 0.1 s.
// Springs on every tetrahedron edge, k = E h; and the same with a volume energy of 50 kPa a tetrahedron.
#pragma once

#include <phymul/phymul.h>

#include <string>

namespace phymul::bench {

inline constexpr double cube_side = 0.1;        // m
inline constexpr double cube_young = 10e3;      // Pa
inline constexpr double cube_bulk = 50e3;       // Pa
inline constexpr double cube_density = 1000.0;  // kg/m^3
inline constexpr double cube_gravity = 9.81;    // m/s^2
inline constexpr double cube_time = 0.1;        // s

/// Group "held": the face x = 0. Neighbours are tetrahedron edges; stiffness and masses as above; no material.
Model make_soft_cube(int particles_a_side);

struct SoftCubeRun {
  std::string status = "ok", message;
  VecList position;  ///< m, at cube_time
  int steps = 0;
  double wall = 0.0, cpu = 0.0;  ///< s, of the stepping alone
  std::string device;
};

/// By this library. The first velocity is that of half a step before the start, so that the scheme is of order 2.
SoftCubeRun run_soft_cube(const Model& cube, bool with_volume, const std::string& backend, int steps);

/// By Bullet's implicit springs, which have no such volume energy. Empty status "not_built" without Bullet.
SoftCubeRun run_soft_cube_in_bullet(const Model& cube, int steps);

/// |x - x_ref| over |x_ref - rest|, all particles.
double relative_error(const Model& cube, const VecList& position, const VecList& reference);

}  // namespace phymul::bench
