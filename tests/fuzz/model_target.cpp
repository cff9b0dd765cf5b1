// SPDX-License-Identifier: MIT
#include <phymul/check.h>
#include <phymul/monitor.h>
#include <phymul/solver.h>
#include <phymul/surface.h>
#include <phymul/topology_textures.h>

#include <memory>
#include <optional>

#include "fuzz_target.h"

namespace phymul::fuzz {
namespace {

Model any_model(Numbers& in) {
  Model model;
  model.dimension = in.below(8) == 0 ? 2 : 3;
  const int particles = in.between(0, 24);
  for (int k = 0; k < particles; ++k) {
    Vec3 place = 0.1 * in.point();
    if (model.dimension == 2) place.z() = 0.0;
    model.rest.push_back(place);
  }
  model.mass.assign(model.rest.size(), in.below(16) == 0 ? in.real() : 1.0);
  model.stiffness.assign(model.rest.size(), in.below(16) == 0 ? in.real() : 1.0);
  for (int cells = in.between(0, 20); cells > 0; --cells) {
    Cell cell;
    cell.type = static_cast<CellType>(in.between(0, 9));
    const int size = cell_size(cell.type) > 0 && in.below(32) > 0 ? cell_size(cell.type) : in.below(10);
    for (int k = 0; k < size; ++k) cell.particles.push_back(in.below(64) == 0 ? in.between(-1, 40) : in.below(25));
    model.cells.push_back(cell);
  }
  if (in.below(2) == 0) {
    model.neighbours = neighbours_from_cells(model.cells, model.particle_count());
  } else if (in.below(2) == 0) {
    model.neighbours = nearest_neighbours(model.rest, in.between(1, 8));
  } else {
    for (int k = 0; k < particles; ++k) {
      std::vector<Index> row;
      for (int size = in.below(9); size > 0; --size) row.push_back(in.below(26));
      model.neighbours.push_row(row.begin(), row.end());
    }
  }
  return model;
}

void simulate(const Model& model, const TopologyOptions& options) {
  std::optional<TopologyTextures> built;
  if (!accepts([&] { built = build_topology(model, options); })) return;
  const auto tables = std::make_shared<const TopologyTextures>(std::move(*built));
  for (const char* backend : {"reference", "cpu"}) {
    accepts([&] {
      Scene scene = Scene(model).gravity({0, 0, -9.81});
      const auto solver = make_solver(backend, tables, scene, {.threads = 1});
      const double limit = solver->stable_step();
      solver->step(3, limit > 0.0 && limit < 1.0 ? 0.5 * limit : 1e-3);
      require(is_finite(solver->read()), std::string(backend) + ": a state that is not finite");
    });
  }
}

}  // namespace

void model(std::string_view bytes) {
  Numbers in(bytes);
  Model any;
  if (!accepts([&] {
        any = any_model(in);
        validate(any);
      })) {
    return;
  }
  find_flaws(any);
  surface_triangles(any);
  volume(any, any.rest);
  if (!accepts([&] { check_mesh(any); })) return;
  check_model(any);
  if (in.below(2) == 0) {
    Material material{.young = 1e3, .poisson = 0.45 * in.real(), .density = 1000};
    if (in.below(4) == 0) material = {in.real(), in.real(), in.real(), in.real()};
    if (in.below(4) == 0) material.retardation_time = in.real();
    if (in.below(4) == 0) material.stiffening = {in.real(), in.real(), in.real(), in.real()};
    accepts([&] { set_material(any, material); });
    check_model(any);
  }
  TopologyOptions options;
  if (in.below(2) == 0) options.law = static_cast<Law>(in.below(2));
  options.reaction = static_cast<Reaction>(in.below(5));
  options.bases = static_cast<BaseSelection>(in.below(2));
  options.strain_energy = static_cast<StrainEnergy>(in.below(3));
  options.on_sparse = static_cast<SparseParticle>(in.below(2));
  if (in.below(4) == 0) options.volume_stiffness = in.real();
  simulate(any, options);
}

}  // namespace phymul::fuzz
