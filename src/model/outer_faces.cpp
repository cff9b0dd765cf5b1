// SPDX-License-Identifier: MIT
#include "outer_faces.h"

#include <phymul/error.h>
#include <phymul/surface.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "cell_geometry.h"
#include "cut_cells.h"

namespace phymul {
namespace {

std::size_t hash_of(const FaceKey& key) {
  constexpr std::uint64_t odd = 0x9e3779b97f4a7c15;  // 2^64 over the golden ratio
  const std::uint64_t mixed = (key.high * odd ^ key.low) * odd;
  return static_cast<std::size_t>(mixed ^ mixed >> 32);
}

}  // namespace

void OuterFaces::follow(const Model& model) {
  std::vector<Index> all(std::max(known_.size(), model.cells.size()));
  std::iota(all.begin(), all.end(), 0);
  follow(model, all);
}

void OuterFaces::follow(const Model& model, std::span<const Index> cells) {
  const std::size_t count = model.cells.size(), most = std::max(count, known_.size());
  known_.resize(most, none());
  next_.resize(most * most_faces, -1);
  face_of_.resize(next_.size(), -1);
  for (const Index row : cells) {
    const Cell* const cell = static_cast<std::size_t>(row) < count ? &model.cells[row] : nullptr;
    const bool solid = cell != nullptr && is_solid(model.dimension, *cell), cut = solid && !cell->cuts.empty();
    const auto at = std::ranges::lower_bound(cut_cells_, row);
    const bool was_cut = at != cut_cells_.end() && *at == row;
    if (cut && !was_cut) cut_cells_.insert(at, row);
    if (was_cut && !cut) cut_cells_.erase(at);
    for (Index place = row * most_faces; cut != was_cut && place < (row + 1) * most_faces; ++place) {
      if (face_of_[place] >= 0) mark(face_of_[place]);
    }
    const auto corners = solid ? std::span(cell->particles) : std::span<const Index>();
    if (std::ranges::equal(corners, particles_of(row))) continue;
    take_out(row);
    std::ranges::copy(corners, known_[row].begin());
    if (solid) put_in(model.dimension, *cell, row);
  }
  known_.resize(count);
  next_.resize(count * most_faces);
  face_of_.resize(next_.size());
  const auto first_of = [&](const FaceKey& key) { return std::ranges::lower_bound(outer_, key, {}, &Outer::key); };
  for (const Index row : changed_) {
    if (faces_[row].outer) first_of(faces_[row].key)->stale = true;
  }
  std::erase_if(outer_, [](const Outer& own) { return own.stale; });
  const auto kept = static_cast<std::ptrdiff_t>(outer_.size());
  std::vector<Index> places;
  for (const Index row : changed_) {
    Face& face = faces_[row];
    face.changed = false;
    places_of(row, places);
    face.outer = is_outer(model, places);
    if (!face.outer) continue;
    const Index cell = places[0] / most_faces;
    const bool is_cut = !model.cells[cell].cuts.empty();
    outer_.push_back({face.key, ring_at(model, places[0]), row, cell, is_cut, places.size() > 1});
  }
  changed_.clear();
  std::ranges::sort(outer_.begin() + kept, outer_.end(), {}, &Outer::key);
  std::ranges::inplace_merge(outer_, outer_.begin() + kept, {}, &Outer::key);
}

Index OuterFaces::row_of(const FaceKey& key) {
  if (2 * faces_.size() >= table_.size()) grow();
  const std::size_t mask = table_.size() - 1;
  std::size_t at = hash_of(key) & mask;
  for (; table_[at] >= 0; at = (at + 1) & mask) {
    if (faces_[table_[at]].key == key) return table_[at];
  }
  table_[at] = static_cast<Index>(faces_.size());
  faces_.push_back({.key = key});
  return table_[at];
}

void OuterFaces::grow() {
  table_.assign(std::max<std::size_t>(64, 2 * table_.size()), -1);
  const std::size_t mask = table_.size() - 1;
  for (std::size_t row = 0; row < faces_.size(); ++row) {
    std::size_t at = hash_of(faces_[row].key) & mask;
    while (table_[at] >= 0) at = (at + 1) & mask;
    table_[at] = static_cast<Index>(row);
  }
}

void OuterFaces::take_out(Index cell) {
  known_[cell] = none();
  for (Index place = cell * most_faces; place < (cell + 1) * most_faces; ++place) {
    const Index face = std::exchange(face_of_[place], -1);
    if (face < 0) continue;
    Index* link = &faces_[face].first;
    while (*link != place) link = &next_[*link];
    *link = std::exchange(next_[place], -1);
    mark(face);
  }
}

void OuterFaces::put_in(int dimension, const Cell& cell, Index row) {
  Index place = row * most_faces;
  each_face(dimension, cell, [&](const std::array<Index, 4>& ring) {
    const Index face = row_of(FaceKey(ring));
    face_of_[place] = face;
    next_[place] = std::exchange(faces_[face].first, place);
    mark(face);
    ++place;
  });
}

void OuterFaces::mark(Index face) {
  if (!std::exchange(faces_[face].changed, true)) changed_.push_back(face);
}

void OuterFaces::places_of(Index face, std::vector<Index>& places) const {
  places.clear();
  for (Index place = faces_[face].first; place >= 0; place = next_[place]) places.push_back(place);
  std::ranges::sort(places);
}

bool OuterFaces::is_outer(const Model& model, const std::vector<Index>& places) const {
  if (places.size() < 2) return !places.empty();
  const auto cell = [&](Index place) -> const Cell& { return model.cells[place / most_faces]; };
  const Vec3 centre = cell_centre(cell(places[0]), model.rest);
  return !cell(places[0]).cuts.empty() &&
         std::ranges::all_of(places, [&](Index place) { return cell_centre(cell(place), model.rest) == centre; });
}

namespace {

bool all_chosen(const std::array<Index, 4>& ring, std::span<const char> chosen) {
  return std::all_of(ring.begin(), ring.end(), [&](Index i) { return i < 0 || chosen[i]; });
}

Facet made_facet(const Model& model, const std::array<Index, 4>& ring, bool inside_out) {
  Facet facet;
  std::copy_if(ring.begin(), ring.end(), std::back_inserter(facet.particles), [](Index i) { return i >= 0; });
  if (facet.particles.size() == 2) {
    // A counter-clockwise boundary has the outside on its right.
    const Vec3 along = model.rest[ring[1]] - model.rest[ring[0]];
    facet.area = Vec3(along.y(), -along.x(), 0.0);
  } else {
    facet.area = area_vector(facet.particles, model.rest);
  }
  if (inside_out) facet.area = -facet.area;
  return facet;
}

Vec3 area_of(const std::array<Index, 3>& t, std::span<const Vec3> x) {
  return 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
}

/// A ring of three or four particles as one or two triangles.
void append_ring(const std::vector<Index>& ring, std::vector<std::array<Index, 3>>& triangles) {
  for (std::size_t k = 2; k < ring.size(); ++k) triangles.push_back({ring[0], ring[k - 1], ring[k]});
}

std::vector<std::array<Index, 3>> plane_triangles(const Model& model) {
  std::vector<std::array<Index, 3>> triangles;
  for (const Cell& cell : model.cells) {
    if (cell.share == 0.0 || (cell.type != CellType::triangle && cell.type != CellType::quad)) continue;
    const std::size_t first = triangles.size();
    append_ring(cell.particles, triangles);
    double area = 0.0;
    for (std::size_t t = first; t < triangles.size(); ++t) area += area_of(triangles[t], model.rest).z();
    if (area >= 0.0) continue;
    for (std::size_t t = first; t < triangles.size(); ++t) std::swap(triangles[t][1], triangles[t][2]);
  }
  return triangles;
}

}  // namespace

std::vector<Facet> surface_facets(const Model& model, std::span<const char> chosen) {
  if (!is_made_of_cells(model)) return explicit_facets(model, chosen);
  const OuterFaces outer(model);
  std::vector<Facet> facets = facets_of_cells(model, chosen, outer);
  std::ranges::move(facets_of_walls(model, chosen, walls_beside_cells(model, outer)), std::back_inserter(facets));
  return facets;
}

std::vector<Index> walls_beside_cells(const Model& model, const OuterFaces& outer) {
  std::vector<Index> rows;
  if (!has_walls(model)) return rows;
  std::vector<FaceKey> known;  // in order
  outer.each(model, [&](std::span<const OuterFace> faces) { known.emplace_back(faces[0].ring); });
  for (Index row = 0; row < static_cast<Index>(model.cells.size()); ++row) {
    const Cell& cell = model.cells[row];
    if (!is_wall(model, cell)) continue;
    const FaceKey own({cell.particles[0], cell.particles[1], cell.particles[2], -1});
    if (!std::ranges::binary_search(known, own)) rows.push_back(row);
  }
  return rows;
}

std::vector<Facet> facets_of_walls(const Model& model, std::span<const char> chosen, std::span<const Index> walls) {
  std::vector<Facet> facets;
  for (const Index row : walls) {
    const Cell& cell = model.cells[row];
    const std::array<Index, 4> ring{cell.particles[0], cell.particles[1], cell.particles[2], -1};
    if (!all_chosen(ring, chosen)) continue;
    facets.push_back(made_facet(model, ring, false));
    facets.back().area *= cell.share;
  }
  return facets;
}

std::vector<Facet> explicit_facets(const Model& model, std::span<const char> chosen) {
  std::vector<Facet> facets;
  for (const Cell& cell : model.cells) {
    const bool facet_type = model.dimension == 2 ? cell.type == CellType::line
                                                 : cell.type == CellType::triangle || cell.type == CellType::quad;
    if (!facet_type || cell.share == 0.0) continue;
    std::array<Index, 4> ring{-1, -1, -1, -1};
    std::copy(cell.particles.begin(), cell.particles.end(), ring.begin());
    if (!all_chosen(ring, chosen)) continue;
    facets.push_back(made_facet(model, ring, false));
    facets.back().area *= cell.share;
  }
  return facets;
}

std::vector<Facet> facets_of_cells(const Model& model, std::span<const char> chosen, const OuterFaces& outer) {
  std::vector<Facet> facets;
  std::vector<FaceCut> cuts;
  const auto share_of = [&](const OuterFace& face) {
    if (!face.is_cut) return 1.0;
    cuts.clear();
    add_cuts_of_face(face.cell->particles, face.cell->cuts, {face.ring[0], face.ring[1], face.ring[2]}, cuts);
    return has_tissue(cuts) ? face_share(cuts) : 0.0;
  };
  outer.each(model, [&](std::span<const OuterFace> faces) {
    if (!all_chosen(faces[0].ring, chosen)) return;
    double share = 0.0;
    for (const OuterFace& face : faces) share += share_of(face);
    if (share == 0.0) return;  // beyond a cut
    const bool inside_out = signed_measure(model.dimension, *faces[0].cell, model.rest) < 0.0;
    facets.push_back(made_facet(model, faces[0].ring, inside_out));
    if (share < 1.0) facets.back().area *= share;
  });
  return facets;
}

Vec3 ring_area(std::span<const Index> ring, std::span<const Vec3> position) {
  Vec3 area = Vec3::Zero();
  for (std::size_t k = 2; k < ring.size(); ++k) area += area_of({ring[0], ring[k - 1], ring[k]}, position);
  return area;
}

std::vector<std::array<Index, 3>> outward_triangles(const Model& model) {
  std::vector<std::array<Index, 3>> triangles;
  const std::vector<char> all(model.rest.size(), 1);
  for (Facet& facet :
       is_made_of_cells(model) ? facets_of_cells(model, all, OuterFaces(model)) : explicit_facets(model, all)) {
    // A facet has the winding of its cell, which may be inside out, and an area that points outward all the same.
    if (ring_area(facet.particles, model.rest).dot(facet.area) < 0.0) std::ranges::reverse(facet.particles);
    append_ring(facet.particles, triangles);
  }
  return triangles;
}

std::vector<std::array<Index, 3>> surface_triangles(const Model& model) {
  validate(model);
  return model.dimension == 2 ? plane_triangles(model) : outward_triangles(model);
}

void surface_normals(std::span<const std::array<Index, 3>> triangles, std::span<const Vec3> position, VecList& normal) {
  const auto count = static_cast<Index>(position.size());
  normal.assign(position.size(), Vec3::Zero());
  for (const std::array<Index, 3>& triangle : triangles) {
    for (const Index i : triangle) {
      if (i >= 0 && i < count) continue;
      throw Error("surface_normals: expected triangles of particles 0 to " + std::to_string(count - 1) + ", got " +
                  std::to_string(i) + "; are triangles and positions of one model?");
    }
    const Vec3 area = area_of(triangle, position);
    for (const Index i : triangle) normal[i] += area;
  }
  for (Vec3& n : normal) n.stableNormalize();
}

Index pick_particle(const Model& model, std::span<const Vec3> position, const PickRay& ray) {
  if (position.size() != model.mass.size()) {
    throw Error("pick_particle: expected " + std::to_string(model.mass.size()) + " positions, got " +
                std::to_string(position.size()));
  }
  const double length = ray.direction.stableNorm();
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw Error("pick_particle: expected a ray with a finite direction that is not zero");
  }
  const Vec3 along = ray.direction / length;
  Index nearest = -1;
  double least = 0.0;
  for (std::size_t i = 0; i < position.size(); ++i) {
    if (model.mass[i] == 0.0) continue;
    const Vec3 to = position[i] - ray.origin;
    const double way = to.dot(along);
    if (!(way >= 0.0) || (nearest >= 0 && way >= least)) continue;
    if (!((to - way * along).norm() <= ray.reach + ray.widening * way)) continue;
    nearest = static_cast<Index>(i);
    least = way;
  }
  return nearest;
}

}  // namespace phymul
