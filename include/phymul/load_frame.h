// SPDX-License-Identifier: MIT
//
// What the loads of a scene mean to a backend: values of one instant, or constant vectors with factors that change.
// Only authors of backends need this header (backend.h).
#pragma once

#include <phymul/types.h>

#include <cstdint>
#include <vector>

namespace phymul {

/// Scene::evaluate(): all loads at one instant. Vectors are empty if nothing of their kind acts.
struct LoadFrame {
  Vec3 gravity{0, 0, 0};            ///< m/s^2, on every particle
  VecList force;                    ///< [N] N, or empty
  std::vector<std::uint8_t> fixed;  ///< [N] or empty: bit a is set if coordinate a is imposed
  VecList target;                   ///< [N] m, or empty: the imposed coordinates
};

/// Scene::modes(): all loads as sums of constant vectors times factors. Only the factors change with time: row m is
/// value[m] of Scene::mode_values(). A device needs nothing else in a step. Lists are empty if nothing of their kind
/// acts.
struct LoadModes {
  struct Part {
    Index mode = 0;
    Vec3 vector{0, 0, 0};
  };
  int count = 0;                     ///< number of factors
  std::vector<std::uint8_t> fixed;   ///< [N] or empty: as LoadFrame::fixed
  std::vector<Index> target_offset;  ///< [N + 1] or empty: target rows of particle i
  std::vector<Part> target;          ///< m: imposed displacement from rest = sum of value[mode] * vector
  std::vector<Index> force_offset;   ///< [N + 1] or empty: force rows of particle i
  std::vector<Part> force;           ///< N: force = sum of value[mode] * vector
  Vec3 gravity{0, 0, 0};             ///< m/s^2, on every particle
  std::vector<Part> acceleration;    ///< m/s^2, on every particle in addition: sum of value[mode] * vector
};

}  // namespace phymul
