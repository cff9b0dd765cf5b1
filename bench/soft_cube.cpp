// SPDX-License-Identifier: MIT
#include "soft_cube.h"

#include <phymul/error.h>

#include <array>
#include <cmath>

#include "stopwatch.h"

namespace phymul::bench {
namespace {

// Corners of a lattice cell as bits x, y, z; the cut of cells with an even sum of places, and its mirror image.
constexpr std::array<std::array<int, 4>, 5> even_cut{
    {{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 1, 4, 7}, {6, 4, 2, 7}, {1, 2, 4, 7}}};
constexpr std::array<std::array<int, 4>, 5> odd_cut{
    {{1, 0, 5, 3}, {2, 0, 3, 6}, {4, 0, 6, 5}, {7, 3, 5, 6}, {0, 3, 6, 5}}};

}  // namespace

Model make_soft_cube(int particles_a_side) {
  const int n = particles_a_side - 1;
  Model cube = make_block(Vec3::Constant(cube_side), n, n, n);
  cube.cells.clear();
  cube.components.clear();
  const auto particle = [&](int i, int j, int k) { return (k * (n + 1) + j) * (n + 1) + i; };
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        for (const std::array<int, 4>& corners : (i + j + k) % 2 == 0 ? even_cut : odd_cut) {
          Cell& cell = cube.cells.emplace_back();
          for (const int c : corners) cell.particles.push_back(particle(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)));
          if (cell_volume(cube, cell) < 0.0) std::swap(cell.particles[2], cell.particles[3]);
        }
      }
    }
  }
  std::vector<Index> held;
  for (Index i = 0; i < cube.particle_count(); ++i) {
    if (cube.rest[i].x() == 0.0) held.push_back(i);
  }
  cube.add_group("held", std::move(held));
  cube.neighbours = neighbours_from_cells(cube.cells, cube.particle_count());
  set_material(cube, {cube_young, 0.0, cube_density});  // for the masses
  cube.materials.clear();
  for (Cell& cell : cube.cells) cell.material = -1;
  cube.stiffness.assign(cube.rest.size(), cube_young * cube_side / n);
  return cube;
}

SoftCubeRun run_soft_cube(const Model& cube, bool with_volume, const std::string& backend, int steps) {
  SoftCubeRun run;
  TopologyOptions topology;
  topology.law = Law::springs;
  topology.volume_law = VolumeLaw::quadratic;
  topology.volume_stiffness = with_volume ? cube_bulk : 0.0;
  SolverOptions options;
  options.on_unstable = UnstableStep::allow;
  try {
    Scene scene(cube);
    scene.fix("held").gravity({0, -cube_gravity, 0});
    const auto solver = make_solver(backend, cube, scene, topology, options);
    run.device = solver->device();
    const double dt = cube_time / steps;
    State state = rest_state(cube);
    for (Vec3& v : state.velocity) v = Vec3(0, cube_gravity * dt / 2, 0);
    for (const Index i : cube.group("held")) state.velocity[i].setZero();
    solver->reset(state);
    solver->read(state);
    const double cpu = processor_seconds();
    const Stopwatch wall;
    const StepReport report = solver->step(steps, dt);
    solver->read(state);
    run.wall = wall.seconds();
    run.cpu = processor_seconds() - cpu;
    run.steps = report.steps;
    run.position = state.position;
    if (!report.ok()) {
      run.status = report.beyond_limit ? "beyond_limit" : "not_finite";
      run.message = report.message();
    }
  } catch (const Error& error) {
    run.status = "refused";
    run.message = error.what();
  }
  return run;
}

double relative_error(const Model& cube, const VecList& position, const VecList& reference) {
  double off = 0.0, size = 0.0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    off += (position[i] - reference[i]).squaredNorm();
    size += (reference[i] - cube.rest[i]).squaredNorm();
  }
  return std::sqrt(off / size);
}

}  // namespace phymul::bench
