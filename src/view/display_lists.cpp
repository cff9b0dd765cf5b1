// SPDX-License-Identifier: MIT
#include "display_lists.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "model/surface_facets.h"

namespace phymul {
namespace {

using Face = std::array<Index, 4>;

int corners_of(const Face& face) {
  return face[3] < 0 ? 3 : 4;
}

Face face_of(const std::vector<Index>& particles) {
  Face face{-1, -1, -1, -1};
  std::copy_n(particles.begin(), std::min<std::size_t>(particles.size(), 4), face.begin());
  return face;
}

/// surface_facets keeps the winding of the cell, and says by the area which side is outside.
void wind_outward(Face& face, const Vec3& normal, const Vec3& outward) {
  if (normal.dot(outward) < 0.0) std::swap(face[0], face[2]);
}

Vec3 normal_of(const Face& face, const VecList& x) {
  const Vec3 normal = face[3] < 0 ? Vec3((x[face[1]] - x[face[0]]).cross(x[face[2]] - x[face[0]]))
                                  : Vec3((x[face[2]] - x[face[0]]).cross(x[face[3]] - x[face[1]]));
  return normal.stableNormalized();
}

std::vector<Face> faces_of(const Model& model) {
  std::vector<Face> faces;
  if (model.dimension == 2) {
    for (const Cell& cell : model.cells) {
      if (cell.share > 0.0 && (cell.type == CellType::triangle || cell.type == CellType::quad))
        faces.push_back(face_of(cell.particles));
    }
    return faces;
  }
  for (const Facet& facet : surface_facets(model, std::vector<char>(model.rest.size(), 1))) {
    faces.push_back(face_of(facet.particles));
    wind_outward(faces.back(), normal_of(faces.back(), model.rest), facet.area);
  }
  return faces;
}

std::vector<SurfaceEdge> edges_of(const std::vector<Face>& faces, const VecList& rest) {
  struct Side {
    std::array<Index, 2> ends;
    std::size_t face;
  };
  std::vector<Side> sides;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const int n = corners_of(faces[f]);
    for (int k = 0; k < n; ++k) {
      const auto [a, b] =
          std::minmax(faces[f][static_cast<std::size_t>(k)], faces[f][static_cast<std::size_t>((k + 1) % n)]);
      sides.push_back({{a, b}, f});
    }
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.ends < b.ends; });
  std::vector<SurfaceEdge> edges;
  for (std::size_t from = 0, to = 0; from < sides.size(); from = to) {
    for (to = from + 1; to < sides.size() && sides[to].ends == sides[from].ends;) ++to;
    const Vec3 first = normal_of(faces[sides[from].face], rest);
    const Vec3 second = to == from + 1 ? Vec3(-first) : normal_of(faces[sides[to - 1].face], rest);
    edges.push_back({sides[from].ends, {first, second}});
  }
  return edges;
}

std::vector<std::array<Index, 2>> links_of(const RaggedList& neighbours) {
  std::vector<std::array<Index, 2>> links;
  for (Index i = 0; i < neighbours.rows(); ++i) {
    for (const Index* j = neighbours.begin(i); j != neighbours.end(i); ++j) {
      links.push_back({std::min(i, *j), std::max(i, *j)});
    }
  }
  // A file may name a neighbour on one side only.
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  return links;
}

}  // namespace

DisplayLists display_lists(const Model& model) {
  DisplayLists lists;
  lists.faces = faces_of(model);
  lists.edges = edges_of(lists.faces, model.rest);
  lists.links = links_of(model.neighbours);
  return lists;
}

}  // namespace phymul
