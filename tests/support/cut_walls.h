// SPDX-License-Identifier: MIT
//
// Walls that tests cut.
#pragma once

#include <phymul/phymul.h>

#include <string>

#include "bodies.h"
#include "removable_body.h"
#include "wall_cases.h"

namespace phymul::test {

inline constexpr double sheet_side = 0.1;  // m
inline const Material film{.young = 20e3, .poisson = 0.4, .density = 1000.0, .thickness = 2e-3};

inline Surface square(int n, double jitter) {
  return grid_surface(n, n, jitter, [](double u, double v) { return Vec3(sheet_side * u, sheet_side * v, 0.0); });
}

inline Model sheet(int n = 8, double jitter = 0.2) {
  Model model = make_wall(square(n, jitter), {.material = film});
  model.add_group("x0", model.particles_in([](const Vec3& x) { return x.x() < 1e-9; }));
  return model;
}

inline Model slab_in_capsule() {
  Model model = with_material(slab(), {5e3, 0.4, 1000.0});
  add_capsule(model, {.young = 100e3, .poisson = 0.4, .density = 1100.0, .thickness = 0.5e-3},
              [](const Vec3& x) { return x.z() > 0.005; });
  return model;
}

/// A sheet with a fin of half its thickness along its middle.
inline Model tee() {
  Surface surface = square(8, 0.0);
  const auto flat = static_cast<Index>(surface.triangles.size());
  std::vector<Index> root, edge;
  for (Index i = 0; i < static_cast<Index>(surface.vertices.size()); ++i) {
    if (std::abs(surface.vertices[i].y() - 0.5 * sheet_side) < 1e-9) root.push_back(i);
  }
  for (const Index i : root) {
    edge.push_back(static_cast<Index>(surface.vertices.size()));
    surface.vertices.push_back(Vec3(surface.vertices[i] + Vec3(0, 0, 0.015)));
  }
  for (std::size_t k = 0; k + 1 < root.size(); ++k) {
    surface.triangles.push_back({root[k], root[k + 1], edge[k]});
    surface.triangles.push_back({root[k + 1], edge[k + 1], edge[k]});
  }
  Model model = make_wall(surface, {.material = film});
  model.add_group("fin", {});
  for (Index row = flat; row < static_cast<Index>(surface.triangles.size()); ++row) {
    model.components.back().cell_refs.push_back(row);
  }
  Material half = film;
  half.thickness *= 0.5;
  set_material(model, half, "fin");
  return model;
}

/// A block of tetrahedra with a fin on the upper ridge of its middle plane, on an edge of these alone.
inline Model block_with_fin() {
  Model model = with_material(make_tetrahedral_block({0.04, 0.02, 0.02}, 4, 2, 2, 0.0, 1), {5e3, 0.4, 1000.0});
  const std::vector<Index> ridge =
      model.particles_in([](const Vec3& x) { return std::abs(x.y() - 0.01) < 1e-9 && x.z() > 0.02 - 1e-9; });
  const auto before = static_cast<Index>(model.cells.size());
  std::vector<Index> top;
  for (const Index i : ridge) top.push_back(add_particle(model, Vec3(model.rest[i] + Vec3(0, 0, 0.01))));
  for (std::size_t k = 0; k + 1 < ridge.size(); ++k) {
    model.cells.push_back({.type = CellType::triangle, .particles = {ridge[k], ridge[k + 1], top[k]}});
    model.cells.push_back({.type = CellType::triangle, .particles = {ridge[k + 1], top[k + 1], top[k]}});
  }
  model.add_group("fin", {});
  for (Index row = before; row < static_cast<Index>(model.cells.size()); ++row) {
    model.components.back().cell_refs.push_back(row);
  }
  set_material(model, film, "fin");
  return model;
}

inline Model sphere() {
  return wall_of(sphere_surface(0.05, 5), 20e3, 0.4, 2e-3);
}

inline SimulationOptions without_material(const std::string& backend) {
  SimulationOptions options = options_for(backend);
  options.material = {};
  return options;
}

}  // namespace phymul::test
