// SPDX-License-Identifier: MIT
//
// Tables of the cell types (edges, faces, corners) and the measures that follow from them. Numbers in the tables are
// places in Cell::particles; vertex order as Cell documents it. The share of space of each particle of a body that has
// no cells: of its Voronoi cell the part within the convex hull of its neighbours (point_neighbours) and itself. On the
// surface that hull ends at the particle; so a lattice with particles on its sides has half a cell there, a quarter on
// its edges.
#pragma once

#include <phymul/model.h>

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace phymul {

using CellEdge = std::array<int, 2>;
/// Counter-clockwise seen from outside the cell; -1 in the last place: a triangle.
using CellFace = std::array<int, 4>;
/// A vertex and its three edge neighbours, of positive volume in a well-shaped, rightly wound cell.
using CellCorner = std::array<int, 4>;

/// Edges of lines, triangles, quads and volume cells; empty for the other types.
std::span<const CellEdge> cell_edges(CellType type);

/// Outward faces of a volume cell; empty for the other types.
std::span<const CellFace> cell_faces(CellType type);

/// Corner tetrahedra of a volume cell, one per vertex, row v at vertex v; a pyramid's apex has four edges and no row.
std::span<const CellCorner> cell_corners(CellType type);

/// The permutation of vertices that turns a mirrored cell (negative volume or, for triangles and quads, area) round:
/// new place k takes old place result[k]. Empty for types without a winding.
std::span<const int> cell_reversal(CellType type);

/// Signed volume of the volume cell at these positions, m^3; 0 for other types. Exact for the trilinear map: a bilinear
/// face sweeps the mean of the volumes that its two diagonal cuts sweep.
double signed_volume(CellType type, std::span<const Index> particles, std::span<const Vec3> position);

/// Area vector (normal times area) of a triangle or quad, m^2; for a bilinear quad the integral of its normal.
Vec3 area_vector(std::span<const Index> particles, std::span<const Vec3> position);

/// What a cell contributes to the body: Cell::share times the signed volume of a volume cell in 3-D, or the area along
/// +z of a triangle or quad in 2-D (m^2: volume per metre of thickness); 0 otherwise.
double signed_measure(int dimension, const Cell& cell, std::span<const Vec3> position);

/// True for the cells that signed_measure measures, where they are not removed.
bool is_solid(int dimension, CellType type);
inline bool is_solid(int dimension, const Cell& cell) {
  return cell.share > 0.0 && is_solid(dimension, cell.type);
}

/// True for the triangles of walls (Law::walls), removed ones included.
inline bool is_of_wall(const Model& model, const Cell& cell) {
  return model.dimension == 3 && cell.type == CellType::triangle && cell.material >= 0 &&
         static_cast<std::size_t>(cell.material) < model.materials.size() &&
         model.materials[cell.material].thickness > 0.0;
}
inline bool is_wall(const Model& model, const Cell& cell) {
  return cell.share > 0.0 && is_of_wall(model, cell);
}

/// Whether it fills space or is of a wall, removed cells included: what cuts part.
inline bool is_tissue(const Model& model, const Cell& cell) {
  return is_solid(model.dimension, cell.type) || is_of_wall(model, cell);
}

/// m^3 (m^2 in 2-D) of the tissue in such a cell, walls by their thickness; negative if it is inside out.
double tissue_volume(const Model& model, const Cell& cell);

/// m, of a body in 3-D with these rows of tissue: the cube root of the volume per particle of its cells in space; of a
/// wall alone the root of its area per particle.
double tissue_spacing(const Model& model, std::span<const Index> rows);

/// Whether a cell that is_solid(), removed ones included, is in the model.
bool is_made_of_cells(const Model& model);

/// Particles of a face of a 3-D cell, or of an edge of a 2-D cell, in order around it. A triangle fills the last entry
/// with -1, an edge the last two.
inline std::array<Index, 4> face_particles(int dimension, const Cell& cell, std::size_t number) {
  const std::vector<Index>& own = cell.particles;
  if (dimension != 3) {
    const CellEdge& edge = cell_edges(cell.type)[number];
    return {own[edge[0]], own[edge[1]], -1, -1};
  }
  const CellFace& face = cell_faces(cell.type)[number];
  return {own[face[0]], own[face[1]], own[face[2]], face[3] < 0 ? -1 : own[face[3]]};
}

/// Calls visit(face_particles()) for each face, or edge.
template <class Visit>
void each_face(int dimension, const Cell& cell, Visit visit) {
  const std::size_t count = dimension == 3 ? cell_faces(cell.type).size() : cell_edges(cell.type).size();
  for (std::size_t number = 0; number < count; ++number) visit(face_particles(dimension, cell, number));
}

/// Mean of its vertices, m.
inline Vec3 cell_centre(const Cell& cell, std::span<const Vec3> position) {
  Vec3 sum = Vec3::Zero();
  for (const Index i : cell.particles) sum += position[i];
  return sum / static_cast<double>(cell.particles.size());
}

/// Names a cell in messages: "cell 2 (HEXAHEDRON, file index 7) \"name\"", by its row.
std::string cell_label(const Model& model, std::size_t row);

/// Moments about the particle. In 2-D of a layer one metre thick, without its thickness.
struct PointCell {
  double volume = 0.0;         ///< m^3
  Vec3 first = Vec3::Zero();   ///< integral of r, m^4
  Mat3 second = Mat3::Zero();  ///< integral of r r^T, m^5
};

/// The model's neighbours, and where they are few (less than 14, in 2-D 8) the neighbours' neighbours too; in
/// increasing order. The six of a lattice span an octahedron, which is less than the lattice's cell.
RaggedList point_neighbours(const Model& model);

/// By quadrature over directions: the volume of a cube is 0.1 % off. Of order neighbours^3 for each particle.
std::vector<PointCell> point_cells(const Model& model, const RaggedList& neighbours);

/// True for a model with particles only: no cells that fill space.
bool is_body_of_points(const Model& model);

}  // namespace phymul
