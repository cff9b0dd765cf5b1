// SPDX-License-Identifier: MIT
//
// A body whose cells tests remove or cut, and its tables against those of a body built anew. Walls that tests cut. A
// blade that goes into a slab.
#pragma once

#include <gtest/gtest.h>
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "bodies.h"
#include "wall_cases.h"

namespace phymul::test {

inline Model slab() {
  return make_tetrahedral_block({0.06, 0.04, 0.03}, 6, 4, 3, 0.25, 7);
}

inline std::vector<Index> cells_within(const Model& model, const Vec3& centre, double radius) {
  return model.cells_in([&](const Vec3& x) { return (x - centre).norm() < radius; });
}

inline SimulationOptions options_for(const std::string& backend) {
  SimulationOptions options;
  options.backend = backend;
  options.material = {5e3, 0.4, 1000.0};
  options.damping.rate = 10.0;
  return options;
}

/// The tables of the simulation's model as it is now, with the stabiliser that the body has.
inline TopologyTextures built_anew(const Simulation& sim) {
  return build_topology(sim.model(), {.stabiliser = sim.solver().topology().options.stabiliser});
}

/// Cuts, removals and returns in any order.
struct RandomEdits {
  Simulation& sim;
  CutSurface (*next_cut)(std::mt19937&, const Model&);
  const Model whole = sim.model();
  std::vector<Snapshot> kept{sim.snapshot()};
  std::mt19937 random{11};
  int edits = 0, cuts = 0, refused = 0;

  void make_one() {
    const auto count = static_cast<Index>(sim.model().cells.size());
    if (random() % 3 == 0) {
      const auto row = static_cast<Index>(random() % count);
      if (sim.model().cells[row].type != CellType::line) sim.remove_cells(std::vector<Index>{row});
    } else if (random() % 5 == 0) {
      sim.restore(kept[random() % kept.size()]);
    } else {
      try {
        cuts += sim.cut(next_cut(random, whole)) ? 1 : 0;
      } catch (const Error& error) {
        ASSERT_EQ(error.code(), ErrorCode::not_supported) << error.what();
        ++refused;
        sim.restore(kept.front());
      }
    }
    if (++edits % 7 == 0 && kept.size() < 20) kept.push_back(sim.snapshot());
  }
};

/// Largest difference of the elastic forces of two tables at random places, over the largest force.
inline double difference_of_forces(const TopologyTextures& a, const TopologyTextures& b, const Model& model,
                                   std::uint32_t seed = 5) {
  VecList x = random_positions(model, 0.2, seed), of_a(x.size()), of_b(x.size());
  elastic_forces(a, x, of_a);
  elastic_forces(b, x, of_b);
  double largest = 0.0, apart = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    largest = std::max(largest, of_b[i].norm());
    apart = std::max(apart, (of_a[i] - of_b[i]).norm());
  }
  return apart / largest;
}

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

/// A slab of 60 x 40 x 20 mm on its lower face, and a blade that goes into it along -x in the plane y = 20.5 mm, with
/// its edge along z.
struct Stroke {
  Simulation sim;
  ToolHandle blade;
  ToolPose pose;

  explicit Stroke(const std::string& backend, double toughness = 0.0, double lowest = 0.005, double young = 1e4,
                  int across = 9, Index spare = 600, int threads = 0, double friction = 0.0, int tick_budget = 0)
      : sim(with_spare_particles(
                make_tetrahedral_block({0.06, 0.04, 0.02}, across, across * 2 / 3, across / 3, 0.25, 7), spare),
            {.material = {young, 0.45, 1000.0},
             .backend = backend,
             .damping = {.rate = 20.0},
             .tick_budget = tick_budget,
             .solver = {.threads = threads}}),
        blade(sim.scene().fix("z0").add_tool(
            "scalpel",
            {.shape = Blade{.width = 0.025 - lowest, .toughness = toughness, .height = 0.01, .friction = friction},
             .pose = first(lowest)})),
        pose(first(lowest)) {}

  static ToolPose first(double lowest) {
    Mat3 axes;
    axes << 0, 0, 1, 0, 1, 0, 1, 0, 0;
    axes.col(1) = axes.col(2).cross(axes.col(0));
    return {.position = {0.062, 0.0205, 0.5 * (0.025 + lowest)}, .orientation = Quaternion(Eigen::Quaterniond(axes))};
  }

  StepReport go_on(double by, double seconds = 1e-3) {
    pose.position.x() -= by;
    blade.move_to(pose);
    return sim.advance(seconds);
  }
};

}  // namespace phymul::test
