// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/surface.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "outer_faces.h"

namespace phymul {
namespace {

using Barycentric = Eigen::Vector4d;  // barycentric coordinates in a tetrahedron

/// In a face of a tetrahedron or in a section of it: at most 4 corners, and one more for each of three cuts.
class Polygon {
 public:
  static constexpr std::size_t most = 16;
  void push_back(const Barycentric& at) {
    if (count_ < most) corners_[count_++] = at;  // more are rounding's, of a polygon as thin as that
  }
  std::size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }
  Barycentric& operator[](std::size_t k) { return corners_[k]; }
  const Barycentric& operator[](std::size_t k) const { return corners_[k]; }
  auto begin() { return corners_.begin(); }
  auto begin() const { return corners_.begin(); }
  auto end() { return corners_.begin() + static_cast<std::ptrdiff_t>(count_); }
  auto end() const { return corners_.begin() + static_cast<std::ptrdiff_t>(count_); }

 private:
  std::array<Barycentric, most> corners_;
  std::size_t count_ = 0;
};

/// Of the body's spacing, in weights: vertices that differ by less are one.
constexpr double one_vertex = 1e-6;

Barycentric values(const CellCut& cut) {
  return {cut[0], cut[1], cut[2], cut[3]};
}

/// Sutherland and Hodgman's clipping: what is above 0.
void clip(const CellCut& cut, Polygon& polygon) {
  Polygon clipped;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Barycentric &from = polygon[k], &to = polygon[(k + 1) % polygon.size()];
    const double here = values(cut).dot(from), there = values(cut).dot(to);
    if (here >= 0.0) clipped.push_back(from);
    if (here * there < 0.0) clipped.push_back(from + here / (here - there) * (to - from));
  }
  polygon = clipped;
}

/// Where a cut crosses the whole cell, in order around it; nothing where it only lies on a face.
Polygon section(const CellCut& cut) {
  Polygon found;
  for (Eigen::Index a = 0; a < 4; ++a) {
    const double at_a = cut[static_cast<std::size_t>(a)];
    if (at_a == 0.0) found.push_back(Barycentric::Unit(a));
    for (Eigen::Index b = 0; b < a; ++b) {
      const double at_b = cut[static_cast<std::size_t>(b)];
      if (at_a * at_b >= 0.0) continue;
      found.push_back(at_a / (at_a - at_b) * Barycentric::Unit(b) + at_b / (at_b - at_a) * Barycentric::Unit(a));
    }
  }
  const bool parts = std::ranges::any_of(cut, [](double v) { return v > 0.0; }) &&
                     std::ranges::any_of(cut, [](double v) { return v < 0.0; });
  if (!parts || found.size() < 3) return {};
  // Two points of a quadrilateral are neighbours where they share a face: have a coordinate 0 in common.
  if (found.size() == 4) {
    const auto share = [&](std::size_t i, std::size_t j) {
      return ((found[i].array() == 0.0) && (found[j].array() == 0.0)).any();
    };
    if (!share(0, 1)) std::swap(found[1], found[2]);
    if (!share(1, 2)) std::swap(found[2], found[3]);
  }
  return found;
}

class TissueSurfaceBuilder {
 public:
  explicit TissueSurfaceBuilder(const Model& model)
      : model_(model), of_particle_(model.rest.size(), -1), last_with_(model.rest.size(), -1) {}

  TissueSurface build(const OuterFaces& outer) {
    outer.each(model_, [&](std::span<const OuterFace> faces) {
      for (const OuterFace& face : faces) add_face(face);
    });
    const std::vector<Index> walls = walls_beside_cells(model_, outer);
    auto next = walls.begin();
    const auto add_walls_before = [&](Index row) {
      for (; next != walls.end() && *next < row; ++next) {
        const Cell& cell = model_.cells[*next];
        add_face({&cell, {cell.particles[0], cell.particles[1], cell.particles[2], -1}, !cell.cuts.empty()});
      }
    };
    for (const Index row : outer.cut_cells()) {
      add_walls_before(row);
      add_cuts(model_.cells[row]);
    }
    add_walls_before(static_cast<Index>(model_.cells.size()));
    return std::move(surface_);
  }

 private:
  using Key = std::array<std::pair<Index, std::int64_t>, 4>;
  struct Known {
    Key key{};           // of those that are no particles
    Index earlier = -1;  // vertex with the same first particle
  };

  void add_face(const OuterFace& own) {
    if (!own.is_cut) {  // as of all cells but tetrahedra
      std::array<Index, 4> corners{};
      std::size_t count = 0;
      for (const Index i : own.ring) {
        if (i >= 0) corners[count++] = vertex(i);
      }
      add_fan(std::span(corners).first(count), false);
      return;
    }
    const Cell& cell = *own.cell;
    Polygon face;
    for (std::size_t k = 0; k < 3; ++k) {
      face.push_back(Barycentric::Unit(std::ranges::find(cell.particles, own.ring[k]) - cell.particles.begin()));
    }
    for (const CellCut& cut : cell.cuts) clip(cut, face);
    add(cell, face, false);
  }

  void add_cuts(const Cell& cell) {
    for (std::size_t k = 0; k < cell.cuts.size(); ++k) {
      Polygon face = section(cell.cuts[k]);
      if (face.empty()) continue;
      // Outward: to where the cut's function is negative.
      const auto place = [&](const Barycentric& at) {
        Vec3 x = Vec3::Zero();
        for (std::size_t v = 0; v < 4; ++v) x += at[static_cast<Eigen::Index>(v)] * model_.rest[cell.particles[v]];
        return x;
      };
      Eigen::Index inner = 0;
      values(cell.cuts[k]).maxCoeff(&inner);
      const Vec3 normal = (place(face[1]) - place(face[0])).cross(place(face[2]) - place(face[0]));
      if (normal.dot(place(Barycentric::Unit(inner)) - place(face[0])) > 0.0) std::ranges::reverse(face);
      for (std::size_t other = 0; other < cell.cuts.size(); ++other) {
        if (other != k) clip(cell.cuts[other], face);
      }
      add(cell, face, true);
    }
  }

  void add(const Cell& cell, const Polygon& polygon, bool of_cut) {
    std::array<Index, Polygon::most> corners{};
    std::size_t count = 0;
    for (const Barycentric& at : polygon) {
      const Index made = vertex(cell, at);
      if (count == 0 || (corners[count - 1] != made && corners[0] != made)) corners[count++] = made;
    }
    add_fan(std::span(corners).first(count), of_cut);
  }

  void add_fan(std::span<const Index> corners, bool of_cut) {
    for (std::size_t k = 2; k < corners.size(); ++k) {
      surface_.triangles.push_back({corners[0], corners[k - 1], corners[k]});
      surface_.of_cut.push_back(static_cast<char>(of_cut));
    }
  }

  Index add_vertex(const TissueVertex& made, const Known& known) {
    surface_.vertices.push_back(made);
    known_.push_back(known);
    return static_cast<Index>(known_.size() - 1);
  }

  Index vertex(Index particle) {
    Index& known = of_particle_[particle];
    if (known < 0) known = add_vertex({{particle, -1, -1, -1}, {1.0}}, {});
    return known;
  }

  Index vertex(const Cell& cell, const Barycentric& at) {
    std::array<std::pair<Index, double>, 4> weights;
    weights.fill({-1, 0.0});
    std::size_t count = 0;
    for (std::size_t v = 0; v < 4; ++v) {
      const double weight = at[static_cast<Eigen::Index>(v)];
      if (std::abs(weight) > one_vertex) weights[count++] = {cell.particles[v], weight};
    }
    if (count == 1) return vertex(weights[0].first);
    std::sort(weights.begin(), weights.begin() + count);
    Key key;
    for (std::size_t k = 0; k < 4; ++k) key[k] = {weights[k].first, std::llround(weights[k].second / one_vertex)};
    Index& last = last_with_[weights[0].first];
    for (Index known = last; known >= 0; known = known_[known].earlier) {
      if (known_[known].key == key) return known;
    }
    TissueVertex made;
    for (std::size_t k = 0; k < 4; ++k) std::tie(made.particles[k], made.weights[k]) = weights[k];
    return last = add_vertex(made, {key, last});
  }

  const Model& model_;
  TissueSurface surface_;
  std::vector<Index> of_particle_;  // [N] vertices that are particles; -1: not yet
  std::vector<Index> last_with_;    // [N] of the others, the last one of which this is the first particle; -1: none yet
  std::vector<Known> known_;        // [vertices]
};

}  // namespace

TissueSurface tissue_surface_of(const Model& model, const OuterFaces& outer) {
  return TissueSurfaceBuilder(model).build(outer);
}

TissueSurface tissue_surface(const Model& model) {
  validate(model);
  if (model.dimension == 2) throw Error("tissue_surface: expected a body in three dimensions");
  return tissue_surface_of(model, OuterFaces(model));
}

bool has_cuts(const Model& model) {
  return std::ranges::any_of(model.cells, [](const Cell& cell) { return cell.share > 0.0 && !cell.cuts.empty(); });
}

VecList TissueSurface::at(std::span<const Vec3> position) const {
  VecList places;
  places.reserve(vertices.size());
  for (const TissueVertex& vertex : vertices) {
    Vec3& x = places.emplace_back(Vec3::Zero());
    for (std::size_t k = 0; k < 4 && vertex.particles[k] >= 0; ++k)
      x += vertex.weights[k] * position[vertex.particles[k]];
  }
  return places;
}

}  // namespace phymul
