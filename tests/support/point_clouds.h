// SPDX-License-Identifier: MIT
//
// Bodies of points, without cells: lattices, points thrown into a box at random, and on its surface too.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "bodies.h"

namespace phymul::test {

/// Of the cantilevers, m.
inline const Vec3 beam(0.2, 0.05, 0.05);

inline double share(std::mt19937& bits) {
  return 0.5 * (uniform(bits) + 1.0);
}

inline Vec3 random_place(const Vec3& size, std::mt19937& bits) {
  const double z = share(bits), y = share(bits), x = share(bits);
  return size.cwiseProduct(Vec3(x, y, z));
}

/// Throws darts until there are `count` points or `misses` in a row come closer than `apart` to one before. `free`:
/// axes along which the places differ from `base`.
inline void throw_darts(VecList& places, const Vec3& base, const std::array<bool, 3>& free, const Vec3& size,
                        double apart, std::size_t count, std::mt19937& bits) {
  constexpr int misses = 4000;
  for (int missed = 0; missed < misses && places.size() < count; ++missed) {
    Vec3 place = random_place(size, bits);
    for (int a = 0; a < 3; ++a) place[a] = free[a] ? place[a] : base[a];
    const auto is_near = [&](const Vec3& p) { return (p - place).norm() < apart; };
    if (std::ranges::any_of(places, is_near)) continue;
    places.push_back(place);
    missed = 0;
  }
}

inline Model body_of(const VecList& places, const Vec3& size) {
  Model model;
  model.rest = places;
  model.mass.assign(places.size(), 1.0);
  model.stiffness.assign(places.size(), 1.0);
  model.neighbours.offset.assign(places.size() + 1, 0);
  for (int a = 0; a < 3; ++a) {
    std::vector<Index> low, high;
    for (Index i = 0; i < model.particle_count(); ++i) {
      if (places[i][a] < 1e-9) low.push_back(i);
      if (places[i][a] > size[a] - 1e-9) high.push_back(i);
    }
    if (!low.empty()) model.add_group(std::string(1, "xyz"[a]) + "0", low);
    if (!high.empty()) model.add_group(std::string(1, "xyz"[a]) + "1", high);
  }
  return model;
}

/// Corners, then points on edges, then on sides, then inside, none closer than `apart`: 1,000 at most.
inline Model sampled_box(const Vec3& size, double apart, std::uint32_t seed) {
  std::mt19937 bits(seed);
  VecList places;
  const auto corner = [&](int k) {
    return Vec3((k & 1) != 0 ? size.x() : 0.0, (k & 2) != 0 ? size.y() : 0.0, (k & 4) != 0 ? size.z() : 0.0);
  };
  for (int k = 0; k < 8; ++k) places.push_back(corner(k));
  for (int axes = 1; axes <= 3; ++axes) {
    for (int mask = 1; mask < 8; ++mask) {
      const std::array<bool, 3> free{(mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0};
      if (free[0] + free[1] + free[2] != axes) continue;
      for (int k = 0; k < 8; ++k) {
        if ((k & mask) == 0) throw_darts(places, corner(k), free, size, apart, 1000, bits);
      }
    }
  }
  return body_of(places, size);
}

/// Points of a lattice `across` cells high; those inside moved at random by up to `amount` spacings, those on the
/// surface along it.
inline Model jittered_lattice(const Vec3& size, int across, double amount) {
  const double h = size.z() / across;
  const auto cells = [&](int axis) { return static_cast<int>(std::lround(size[axis] / h)); };
  VecList places = make_block(size, cells(0), cells(1), cells(2)).rest;
  std::mt19937 bits(1);
  for (Vec3& p : places) {
    const Vec3 move = amount * h * random_vector(bits, 3);
    for (int a = 0; a < 3; ++a) p[a] += p[a] > 1e-9 && p[a] < size[a] - 1e-9 ? move[a] : 0.0;
  }
  return body_of(places, size);
}

inline Model uniform_cloud(const Vec3& size) {
  std::mt19937 bits(4);
  VecList places;
  for (int k = 0; k < 1000; ++k) places.push_back(random_place(size, bits));
  return body_of(places, size);
}

inline Model blue_cloud(const Vec3& size) {
  std::mt19937 bits(3);
  VecList places;
  throw_darts(places, Vec3::Zero(), {true, true, true}, size, 0.0068, 1000, bits);
  return body_of(places, size);
}

/// All of beam size or near it.
inline std::vector<Body> clouds() {
  std::vector<Body> all{{"lattice", jittered_lattice(beam, 4, 0.0)},
                        {"jittered 0.2 h", jittered_lattice(beam, 4, 0.2)},
                        {"jittered 0.35 h", jittered_lattice(beam, 4, 0.35)},
                        {"sampled, surface too", sampled_box(beam, 0.0075, 1)},
                        {"random, apart", blue_cloud(beam)},
                        {"random", uniform_cloud(beam)},
                        {"cylinder's neighbours", without_cells(cylinder_275())}};
  for (Body& body : all) body.model = with_material(body.model);
  return all;
}

}  // namespace phymul::test
