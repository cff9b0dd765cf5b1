// SPDX-License-Identifier: MIT
#include "outer_faces.h"

#include <algorithm>
#include <numeric>

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

}  // namespace phymul
