// SPDX-License-Identifier: MIT
//
// Plates and shells of known deflection. Each returns the relative error of a displacement under a small load.
#pragma once

#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <Eigen/Sparse>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <span>

#include "bodies.h"
#include "elastic/force_wall.h"

namespace phymul::test {

/// Triangles over a grid of (nu + 1) x (nv + 1) points of the unit square, at `place`, cut along their shorter
/// diagonal. Unstructured with a `jitter` above 0: inner points of every other row stand between those of the next, and
/// each is moved by up to so many cells. `closed`: u = 1 is u = 0.
inline Surface grid_surface(int nu, int nv, double jitter, const std::function<Vec3(double, double)>& place,
                            bool closed = false, unsigned seed = 5) {
  std::mt19937 bits(seed);
  const auto move = [&] { return jitter * (2.0 * static_cast<double>(bits()) / 4294967296.0 - 1.0); };
  Surface surface;
  const int columns = closed ? nu : nu + 1;
  for (int j = 0; j <= nv; ++j) {
    for (int i = 0; i < columns; ++i) {
      const bool inner = (closed || (i > 0 && i < nu)) && j > 0 && j < nv;
      const bool between = inner && jitter > 0.0 && j % 2 == 1;
      const double u = !between ? i : closed ? i + 0.5 : (i - 0.5) * nu / (nu - 1.0);
      const double du = inner ? move() : 0.0, dv = inner ? move() : 0.0;
      surface.vertices.push_back(place((u + du) / nu, (j + dv) / nv));
    }
  }
  const auto at = [&](int i, int j) { return static_cast<Index>(j * columns + i % columns); };
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nu; ++i) {
      const Index a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      const auto length = [&](Index p, Index q) { return (surface.vertices[p] - surface.vertices[q]).norm(); };
      const bool along_ac = length(a, c) * (1.0 - 1e-9) <= length(b, d);
      if (along_ac) surface.triangles.insert(surface.triangles.end(), {{a, b, c}, {a, c, d}});
      if (!along_ac) surface.triangles.insert(surface.triangles.end(), {{a, b, d}, {b, c, d}});
    }
  }
  return surface;
}

/// A disc of `rings` rings of 6, 12, 18 ... points around a centre.
inline Surface disc_surface(double radius, int rings, double jitter, unsigned seed = 5) {
  std::mt19937 bits(seed);
  const auto move = [&] { return jitter * radius / rings * (2.0 * static_cast<double>(bits()) / 4294967296.0 - 1.0); };
  Surface surface;
  surface.vertices.push_back(Vec3::Zero());
  for (int r = 1; r <= rings; ++r) {
    for (int k = 0; k < 6 * r; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / (6.0 * r), at = radius * r / rings;
      const Vec3 moved = r < rings ? Vec3(move(), move(), 0.0) : Vec3(Vec3::Zero());
      surface.vertices.push_back(Vec3(at * std::cos(angle), at * std::sin(angle), 0.0) + moved);
    }
  }
  const auto at = [](int r, int k) { return static_cast<Index>(r == 0 ? 0 : 1 + 3 * r * (r - 1) + k % (6 * r)); };
  for (int r = 1; r <= rings; ++r) {
    for (int sector = 0; sector < 6; ++sector) {
      for (int k = 0; k < r; ++k) {
        const int outer = sector * r + k, inner = sector * (r - 1) + k;
        surface.triangles.push_back({at(r - 1, inner), at(r, outer), at(r, outer + 1)});
        if (k + 1 < r) surface.triangles.push_back({at(r - 1, inner), at(r, outer + 1), at(r - 1, inner + 1)});
      }
    }
  }
  return surface;
}

/// A sphere by dividing an octahedron's sides into n.
inline Surface sphere_surface(double radius, int n) {
  Surface surface;
  std::map<std::array<int, 3>, Index> row;
  const auto vertex = [&](int x, int y, int z) {
    const auto [at, fresh] = row.try_emplace({x, y, z}, static_cast<Index>(surface.vertices.size()));
    if (fresh) surface.vertices.push_back(radius * Vec3(x, y, z).normalized());
    return at->second;
  };
  for (int octant = 0; octant < 8; ++octant) {
    const int sx = octant & 1 ? -1 : 1, sy = octant & 2 ? -1 : 1, sz = octant & 4 ? -1 : 1;
    const bool turned = sx * sy * sz < 0;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        const auto at = [&](int a, int b) { return vertex(sx * a, sy * b, sz * (n - a - b)); };
        std::array<Index, 3> t{at(i, j), at(i + 1, j), at(i, j + 1)};
        if (turned) std::swap(t[1], t[2]);
        surface.triangles.push_back(t);
        if (i + j + 2 > n) continue;
        t = {at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
        if (turned) std::swap(t[1], t[2]);
        surface.triangles.push_back(t);
      }
    }
  }
  return surface;
}

inline Model wall_of(const Surface& surface, double young, double poisson, double thickness) {
  return make_wall(surface,
                   {.material = {.young = young, .poisson = poisson, .density = 1000.0, .thickness = thickness}});
}

/// Forces at x are the slope of the energy, by differences of `h`, m, at these particles.
inline void expect_slope_of_energy(const TopologyTextures& tables, const VecList& x, double h,
                                   std::span<const std::size_t> particles) {
  const VecList force = forces_at(tables, x);
  for (const std::size_t i : particles) {
    for (int axis = 0; axis < 3; ++axis) {
      VecList up = x, down = x;
      up[i][axis] += h;
      down[i][axis] -= h;
      const double slope = (elastic_energy(tables, up) - elastic_energy(tables, down)) / (2.0 * h);
      EXPECT_NEAR(force[i][axis], -slope, 2e-5 * largest_norm(force)) << "particle " << i << ", axis " << axis;
    }
  }
}

/// Newton's method for walls alone.
class WallRest {
 public:
  /// `fixed`: [N] bit a: coordinate a is held.
  WallRest(const TopologyTextures& topology, std::vector<std::uint8_t> fixed)
      : t_(topology), fixed_(std::move(fixed)), x(topology.rest), force(x.size(), Vec3::Zero()) {}

  /// One step of Newton's method under `force`; returns the largest displacement of it, m.
  double step() {
    const auto n = static_cast<Eigen::Index>(3 * x.size());
    std::vector<Eigen::Triplet<double>> entries;
    VecList residual = force;
    for (const WallTexel& w : t_.walls) wall_energy(w, t_.rest, x, residual);
    for (const WallTexel& w : t_.walls) add_tangent(w, entries);
    Eigen::VectorXd r(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const bool held = fixed_[static_cast<std::size_t>(k / 3)] >> (k % 3) & 1;
      r[k] = held ? 0.0 : residual[static_cast<std::size_t>(k / 3)][k % 3];
      if (held) entries.emplace_back(k, k, 1.0);
    }
    Eigen::SparseMatrix<double> K(n, n);
    K.setFromTriplets(entries.begin(), entries.end());
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(K);
    const Eigen::VectorXd d = factors.solve(r);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += d.segment<3>(3 * static_cast<Eigen::Index>(i));
    return d.cwiseAbs().maxCoeff();
  }

  /// Until a step moves no particle by more than `tolerance`, m. Returns whether it came so far.
  bool rest(double tolerance, int most = 40) {
    for (int k = 0; k < most; ++k) {
      const double moved = step();
      if (!std::isfinite(moved)) return false;
      if (moved < tolerance) return true;
    }
    return false;
  }

 private:
  void add_tangent(const WallTexel& w, std::vector<Eigen::Triplet<double>>& entries) {
    WallTexel own = w;
    VecList rest(6, Vec3::Zero()), at(6, Vec3::Zero());
    double size = 0.0;
    for (std::size_t k = 0; k < 6; ++k) {
      if (w.vertex[k] == none) continue;
      own.vertex[k] = static_cast<Index>(k);
      rest[k] = t_.rest[w.vertex[k]];
      at[k] = x[w.vertex[k]];
      size = std::max(size, (rest[k] - rest[0]).norm());
    }
    const double h = 1e-6 * size;
    Eigen::Matrix<double, 18, 18> K;
    for (int c = 0; c < 18; ++c) {
      VecList plus(6, Vec3::Zero()), minus = plus, moved = at;
      moved[static_cast<std::size_t>(c / 3)][c % 3] += h;
      wall_energy(own, rest, moved, plus);
      moved[static_cast<std::size_t>(c / 3)][c % 3] -= 2.0 * h;
      wall_energy(own, rest, moved, minus);
      for (int r = 0; r < 18; ++r) {
        K(r, c) =
            (minus[static_cast<std::size_t>(r / 3)][r % 3] - plus[static_cast<std::size_t>(r / 3)][r % 3]) / (2.0 * h);
      }
    }
    for (int r = 0; r < 18; ++r) {
      for (int c = 0; c < 18; ++c) {
        const Index i = w.vertex[static_cast<std::size_t>(r / 3)], j = w.vertex[static_cast<std::size_t>(c / 3)];
        if (i == none || j == none || fixed_[i] >> (r % 3) & 1 || fixed_[j] >> (c % 3) & 1) continue;
        entries.emplace_back(3 * i + r % 3, 3 * j + c % 3, 0.5 * (K(r, c) + K(c, r)));
      }
    }
  }

  const TopologyTextures& t_;
  std::vector<std::uint8_t> fixed_;

 public:
  VecList x;      ///< m
  VecList force;  ///< N, of loads
};

/// Pressure on the triangles of a wall as it is at x, N.
inline void add_pressure(const Model& model, std::span<const Vec3> x, double pressure, std::span<Vec3> force) {
  for (const Cell& cell : model.cells) {
    if (cell.type != CellType::triangle) continue;
    const auto& p = cell.particles;
    const Vec3 share = pressure / 6.0 * (x[p[1]] - x[p[0]]).cross(x[p[2]] - x[p[0]]);
    for (const Index i : p) force[i] += share;
  }
}

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
