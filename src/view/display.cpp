// SPDX-License-Identifier: MIT
#include <phymul/display.h>
#include <phymul/error.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "display_lists.h"
#include "model/outer_faces.h"
#include "solver/gl_module.h"

namespace phymul {
namespace {

std::unique_ptr<Display> make(const Model& model, const Solver* solver, std::shared_ptr<const VisibleSkin> skin,
                              const GlOptions& gl) {
  validate(model);
#ifdef PHYMUL_HAS_GL
  return load_gl_module().make_display(model, solver, std::move(skin), gl);
#else
  (void)solver, (void)skin, (void)gl;
  throw Error(ErrorCode::not_supported, "this build of phymul draws nothing: it was made without GL (PHYMUL_WITH_GL)");
#endif
}

}  // namespace

std::unique_ptr<Display> make_display(const Solver& solver, const GlOptions& gl) {
  return make(solver.model(), &solver, nullptr, gl);
}

std::unique_ptr<Display> make_display(const Solver& solver, const Skin& skin,
                                      std::span<const std::array<Index, 3>> triangles, const GlOptions& gl) {
  if (skin.size() == 0) throw Error(ErrorCode::invalid_argument, "make_display: expected a skin with points, got none");
  if (!skin.is_bound_to(solver.model())) {
    throw Error(ErrorCode::invalid_argument,
                "make_display: expected a skin bound to the solver's body, got one of another body; bind its points to "
                "Solver::model()");
  }
  Model surface;
  surface.rest = skin.deform(solver.model().rest);
  for (const std::array<Index, 3>& triangle : triangles) {
    for (const Index point : triangle) {
      if (point >= 0 && point < surface.particle_count()) continue;
      throw Error(ErrorCode::invalid_argument, "make_display: a triangle of point " + std::to_string(point) +
                                                   " of a skin of " + std::to_string(skin.size()) + " points");
    }
    surface.cells.push_back({.type = CellType::triangle, .particles = {triangle.begin(), triangle.end()}});
  }
  surface.neighbours = neighbours_from_cells(surface.cells, surface.particle_count());
  return make(solver.model(), &solver, std::make_shared<VisibleSkin>(skin, std::move(surface)), gl);
}

std::unique_ptr<Display> make_display(const Model& model, const GlOptions& gl) {
  return make(model, nullptr, nullptr, gl);
}

/// At equal distances in CIELAB, along lightness 92 to 26, hue 190 to 320 degrees, chroma 5 to 60.
Colour displacement_colour(double share) {
  static constexpr std::array<std::array<double, 3>, 17> table{{{0.867, 0.922, 0.916},
                                                                {0.761, 0.893, 0.891},
                                                                {0.650, 0.849, 0.868},
                                                                {0.542, 0.800, 0.852},
                                                                {0.442, 0.750, 0.841},
                                                                {0.351, 0.699, 0.831},
                                                                {0.272, 0.647, 0.820},
                                                                {0.212, 0.596, 0.807},
                                                                {0.180, 0.545, 0.790},
                                                                {0.182, 0.494, 0.768},
                                                                {0.208, 0.443, 0.741},
                                                                {0.244, 0.392, 0.709},
                                                                {0.281, 0.341, 0.671},
                                                                {0.315, 0.288, 0.628},
                                                                {0.344, 0.234, 0.581},
                                                                {0.367, 0.175, 0.530},
                                                                {0.385, 0.104, 0.475}}};
  // Not clamp(): a share that is not a number, as 0 / 0 of a body at rest, counts as 0.
  const double place = (share > 0.0 ? std::min(share, 1.0) : 0.0) * static_cast<double>(table.size() - 1);
  const auto row = std::min(static_cast<std::size_t>(place), table.size() - 2);
  const double t = place - static_cast<double>(row);
  Colour colour{0.0, 0.0, 0.0, 1.0};
  for (std::size_t k = 0; k < 3; ++k) colour[k] = table[row][k] + t * (table[row + 1][k] - table[row][k]);
  return colour;
}

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
