// SPDX-License-Identifier: MIT
//
// The unstructured tetrahedral box. Every particle has a random rank. A lattice face is cut by the diagonal at its
// lowest-ranked vertex, so the two cells that share it agree; a cell is cut by joining its own lowest-ranked vertex to
// the triangles of the three faces that do not touch it (Dompierre, Labbe, Vallet, Camarero: "How to subdivide
// pyramids, prisms and hexahedra into tetrahedra", 1999, give the same rule for vertex numbers).
#include <phymul/error.h>
#include <phymul/shapes.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "base/decimal.h"
#include "cell_geometry.h"
#include "shape_builder.h"

namespace phymul {
namespace {

std::vector<std::uint32_t> random_ranks(Index count, Random& random) {
  std::vector<std::uint32_t> rank(static_cast<std::size_t>(count));
  std::iota(rank.begin(), rank.end(), 0u);
  for (std::size_t i = rank.size(); i > 1; --i) std::swap(rank[i - 1], rank[random.bits() % i]);
  return rank;
}

void cut_cell(Model& model, const std::array<Index, 8>& cell, const std::vector<std::uint32_t>& rank) {
  const auto lower = [&](Index a, Index b) { return rank[a] < rank[b]; };
  const Index apex = *std::min_element(cell.begin(), cell.end(), lower);
  for (const CellFace& face : cell_faces(CellType::hexahedron)) {
    std::array<Index, 4> ring;
    for (int v = 0; v < 4; ++v) ring[v] = cell[face[v]];
    if (std::find(ring.begin(), ring.end(), apex) != ring.end()) continue;
    std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end(), lower), ring.end());
    // Seen from inside the cell the face runs the other way round: the apex is on the positive side of (a, c, b).
    add_cell(model, CellType::tetrahedron, {ring[0], ring[2], ring[1], apex});
    add_cell(model, CellType::tetrahedron, {ring[0], ring[3], ring[2], apex});
  }
}

/// Random displacement of every particle: surface particles slide in their side, edge and corner ones less.
VecList random_moves(const Lattice& lattice, const Vec3& spacing, double jitter, Random& random) {
  VecList moves;
  for (int k = 0; k <= lattice.nz; ++k) {
    for (int j = 0; j <= lattice.ny; ++j) {
      for (int i = 0; i <= lattice.nx; ++i) {
        Vec3 move = jitter * random.in_ball(3).cwiseProduct(spacing);
        if (i == 0 || i == lattice.nx) move.x() = 0.0;
        if (j == 0 || j == lattice.ny) move.y() = 0.0;
        if (k == 0 || k == lattice.nz) move.z() = 0.0;
        moves.push_back(move);
      }
    }
  }
  return moves;
}

/// Adds the moves to the rest places; where a tetrahedron would keep less than `share` of its volume, its particles'
/// moves are halved until none does. Ends because the lattice itself is a solution.
void move_particles(Model& model, VecList moves, double share) {
  const VecList lattice = model.rest;
  const auto volume_of = [&](const Cell& cell) { return signed_volume(cell.type, cell.particles, model.rest); };
  const double least = share * volume_of(model.cells.front());
  for (bool thin = true; thin;) {
    for (std::size_t i = 0; i < moves.size(); ++i) model.rest[i] = lattice[i] + moves[i];
    std::vector<char> halve(moves.size(), 0);
    thin = false;
    for (const Cell& cell : model.cells) {
      if (volume_of(cell) >= least) continue;
      thin = true;
      for (const Index i : cell.particles) halve[i] = 1;
    }
    for (std::size_t i = 0; i < moves.size(); ++i) {
      if (halve[i]) moves[i] *= 0.5;
    }
  }
}

}  // namespace

Model make_tetrahedral_block(const Vec3& size, int nx, int ny, int nz, double jitter, std::uint32_t seed,
                             double least) {
  constexpr const char* what = "make_tetrahedral_block";
  if (nz < 1) throw Error(std::string(what) + ": expected nz of at least 1, got " + std::to_string(nz));
  if (!(jitter >= 0.0 && jitter < 0.5)) {
    throw Error(std::string(what) + ": expected a jitter from 0 to below 0.5 spacings, got " + to_decimal(jitter));
  }
  if (!(least > 0.0 && least <= 0.5)) {
    throw Error(std::string(what) + ": expected a least volume above 0 and up to 0.5, got " + to_decimal(least));
  }
  const Lattice lattice = make_lattice(what, size, nx, ny, nz, 26);
  Model model = named_model("tetrahedral block");
  place_lattice(model, lattice, size);
  Random random(seed);
  const std::vector<std::uint32_t> rank = random_ranks(model.particle_count(), random);
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) cut_cell(model, lattice.cell(i, j, k), rank);
    }
  }
  const Vec3 spacing(size.x() / nx, size.y() / ny, size.z() / nz);
  move_particles(model, random_moves(lattice, spacing, jitter, random), least);
  add_side_groups(model, lattice);
  return finished(std::move(model));
}

}  // namespace phymul
