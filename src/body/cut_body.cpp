// SPDX-License-Identifier: MIT
//
// Cuts of bodies that no simulation has.
#include <phymul/body.h>
#include <phymul/error.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cut_places.h"
#include "model/cell_cutter.h"
#include "model/cell_geometry.h"

namespace phymul {
namespace {

void append_particles(Model& model, std::size_t count) {
  const std::size_t particles = model.rest.size() + count;
  model.rest.resize(particles, Vec3(model.rest.front()));
  model.mass.resize(particles, 0.0);
  model.stiffness.resize(particles, 0.0);
  const Index* const none = nullptr;
  for (std::size_t k = 0; k < count; ++k) model.neighbours.push_row(none, none);
  if (count > 0) model.extras = nullptr;
}

}  // namespace

Model with_spare_particles(Model model, Index count) {
  validate(model);
  if (count < 0) throw Error("with_spare_particles: expected a number of 0 or more, got " + std::to_string(count));
  if (std::ranges::none_of(model.cells, [&](const Cell& cell) { return cell.share > 0.0 && is_tissue(model, cell); })) {
    throw Error(ErrorCode::not_supported, "with_spare_particles: expected a body of cells, got one without");
  }
  append_particles(model, static_cast<std::size_t>(count));
  return model;
}

Model cut_body(Model model, const CutSurface& cut, std::vector<Index>* copies) {
  validate(model);
  std::vector<std::vector<Index>> cells_of(model.rest.size());
  std::vector<Index> cells;
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    if (model.cells[row].share == 0.0 || !is_tissue(model, model.cells[row])) continue;
    cells.push_back(row);
    for (const Index i : model.cells[row].particles) cells_of[i].push_back(row);
  }
  if (cells.empty()) throw Error("cut_body: expected a body of tetrahedra or a wall, got none");
  const CutPlaces places(model, cells, cut, "cut_body");
  const std::vector<Index> spare = spare_particles_of(model);
  const CutBody body{.model = model,
                     .cells_of = cells_of,
                     .mass = model.mass,
                     .mass_of_corner =
                         [&](Index row) {
                           const Cell& cell = model.cells[row];
                           const double density = cell.material < 0 ? 1.0 : model.materials[cell.material].density;
                           return density * tissue_volume(model, cell) / static_cast<double>(cell.particles.size());
                         },
                     .spare =
                         [&](std::size_t k) {
                           return k < spare.size() ? spare[k]
                                                   : static_cast<Index>(model.rest.size() + k - spare.size());
                         }};
  const BodyCut found = cut_cells(body, places.cut());
  if (copies) copies->clear();
  if (found.empty()) {
    model.notes.emplace_back("cut_body: the surface parts no cell; the body is as it was");
    return model;
  }
  append_particles(model, found.copies.size() - std::min(found.copies.size(), spare.size()));
  make_cut(found, model);
  for (const BodyCut::Mass& mass : found.masses) model.mass[mass.particle] = mass.after;
  if (copies) {
    for (const BodyCut::Copy& copy : found.copies) copies->push_back(copy.of);
  }
  model.neighbours = neighbours_from_cells(model.cells, model.particle_count());
  model.extras = nullptr;
  validate(model);
  return model;
}

CutSurface cut_plane(const Vec3& point, const Vec3& normal) {
  const double length = normal.norm();
  if (!(length > 0.0) || !std::isfinite(length) || !point.allFinite()) {
    throw Error("cut_plane: expected a finite point and a normal that is not zero");
  }
  const Vec3 unit = normal / length;
  return {.distance = [point, unit](const Vec3& x) { return unit.dot(x - point); }, .front = {}};
}

}  // namespace phymul
