// SPDX-License-Identifier: MIT
#include "outer_faces.h"

#include <algorithm>

namespace phymul {
namespace {

std::size_t hash_of(const FaceKey& key) {
  constexpr std::uint64_t odd = 0x9e3779b97f4a7c15;  // 2^64 over the golden ratio
  const std::uint64_t mixed = (key.high * odd ^ key.low) * odd;
  return static_cast<std::size_t>(mixed ^ mixed >> 32);
}

}  // namespace

void OuterFaces::follow(const Model& model) {
  const auto count = static_cast<Index>(model.cells.size());
  for (auto row = static_cast<Index>(known_.size()); row-- > count;) take_out(row);
  known_.resize(model.cells.size(), none());
  next_.resize(model.cells.size() * most_faces, -1);
  face_of_.resize(next_.size(), -1);
  cut_cells_.clear();
  for (Index row = 0; row < count; ++row) {
    const Cell& cell = model.cells[row];
    if (!cell.cuts.empty() && is_solid(model.dimension, cell)) cut_cells_.push_back(row);
    const auto corners = is_solid(model.dimension, cell) ? std::span(cell.particles) : std::span<const Index>();
    const bool complete = corners.size() == known_[row].size() || known_[row][corners.size()] < 0;
    if (complete && std::equal(corners.begin(), corners.end(), known_[row].begin())) continue;
    take_out(row);
    std::ranges::copy(corners, known_[row].begin());
    if (!corners.empty()) put_in(model.dimension, cell, row);
  }
  std::vector<Index> places;
  bool same = true;
  for (const Index row : changed_) {
    Face& face = faces_[row];
    face.changed = false;
    const bool outer = is_outer(model, row, places);
    if (outer && !face.outer) outer_.push_back(row);
    same = same && outer == face.outer;
    face.outer = outer;
  }
  changed_.clear();
  if (same) return;
  std::erase_if(outer_, [&](Index row) { return !faces_[row].outer; });
  std::ranges::sort(outer_, {}, [&](Index row) { return faces_[row].key; });
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

bool OuterFaces::is_outer(const Model& model, Index face, std::vector<Index>& places) const {
  places_of(face, places);
  if (places.size() < 2) return !places.empty();
  const auto cell = [&](Index place) -> const Cell& { return model.cells[place / most_faces]; };
  const Vec3 centre = cell_centre(cell(places[0]), model.rest);
  return !cell(places[0]).cuts.empty() &&
         std::ranges::all_of(places, [&](Index place) { return cell_centre(cell(place), model.rest) == centre; });
}

}  // namespace phymul
