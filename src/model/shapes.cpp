// SPDX-License-Identifier: MIT
#include <phymul/error.h>
#include <phymul/shapes.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "base/decimal.h"
#include "cell_geometry.h"
#include "shape_builder.h"

namespace phymul {
namespace {

void require_count(const char* what, const char* name, int value, int least) {
  if (value >= least) return;
  throw Error(std::string(what) + ": expected " + name + " of at least " + std::to_string(least) + ", got " +
              std::to_string(value));
}

void require_countable(const char* what, double particles, int entries_per_particle) {
  if (particles * entries_per_particle <= std::numeric_limits<Index>::max()) return;
  throw Error(std::string(what) + ": expected fewer than 2^31 entries in its lists, got about " +
              to_decimal(particles * entries_per_particle) + "; ask for fewer cells");
}

// The unstructured tetrahedral box. Every particle has a random rank. A lattice face is cut by the diagonal at its
// lowest-ranked vertex, so the two cells that share it agree; a cell is cut by joining its own lowest-ranked vertex to
// the triangles of the three faces that do not touch it (Dompierre, Labbe, Vallet, Camarero: "How to subdivide
// pyramids, prisms and hexahedra into tetrahedra", 1999, give the same rule for vertex numbers).

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

void require_length(const char* what, const char* name, double value) {
  if (value > 0.0 && std::isfinite(value)) return;
  throw Error(std::string(what) + ": expected a positive, finite " + name + " in m, got " + to_decimal(value));
}

Lattice make_lattice(const char* what, const Vec3& size, int nx, int ny, int nz, int entries_per_particle) {
  require_length(what, "size along x", size.x());
  require_length(what, "size along y", size.y());
  if (nz > 0) require_length(what, "size along z", size.z());
  require_count(what, "nx", nx, 1);
  require_count(what, "ny", ny, 1);
  require_countable(what, (nx + 1.0) * (ny + 1.0) * (nz + 1.0), entries_per_particle);
  return {nx, ny, nz};
}

void place_lattice(Model& model, const Lattice& lattice, const Vec3& size) {
  for (int k = 0; k <= lattice.nz; ++k) {
    for (int j = 0; j <= lattice.ny; ++j) {
      for (int i = 0; i <= lattice.nx; ++i) {
        const double z = lattice.nz == 0 ? 0.0 : size.z() * k / lattice.nz;
        model.rest.emplace_back(size.x() * i / lattice.nx, size.y() * j / lattice.ny, z);
      }
    }
  }
}

void add_side_groups(Model& model, const Lattice& lattice) {
  std::array<std::vector<Index>, 6> side;
  for (int k = 0; k <= lattice.nz; ++k) {
    for (int j = 0; j <= lattice.ny; ++j) {
      for (int i = 0; i <= lattice.nx; ++i) {
        const Index p = lattice.particle(i, j, k);
        if (i == 0) side[0].push_back(p);
        if (i == lattice.nx) side[1].push_back(p);
        if (j == 0) side[2].push_back(p);
        if (j == lattice.ny) side[3].push_back(p);
        if (k == 0) side[4].push_back(p);
        if (k == lattice.nz) side[5].push_back(p);
      }
    }
  }
  constexpr std::array<const char*, 6> names{"x0", "x1", "y0", "y1", "z0", "z1"};
  const std::size_t sides = model.dimension == 3 ? 6 : 4;
  for (std::size_t s = 0; s < sides; ++s) model.add_group(names[s], std::move(side[s]));
}

Model named_model(std::string name) {
  Model model;
  model.name = std::move(name);
  const Component root{.name = "Exclusive Components", .structural = false};
  const Component elements{.name = "Elements", .parent = 0};
  model.components = {root, elements};
  return model;
}

void add_cell(Model& model, CellType type, std::vector<Index> particles) {
  model.components.back().cells.push_back(static_cast<Index>(model.cells.size()));
  model.cells.push_back({.type = type, .particles = std::move(particles)});
}

Model finished(Model model) {
  model.mass.assign(model.rest.size(), 1.0);
  model.stiffness.assign(model.rest.size(), 1.0);
  if (model.neighbours.rows() == 0) model.neighbours = neighbours_from_cells(model.cells, model.particle_count());
  validate(model);
  return model;
}

Vec3 Random::in_ball(int dimension) {
  while (true) {
    // y first: bodies of a seed stay as GCC made them when a call's arguments, in an order of its choice, drew both.
    const double y = 2.0 * unit() - 1.0, x = 2.0 * unit() - 1.0;
    Vec3 v(x, y, dimension == 3 ? 2.0 * unit() - 1.0 : 0.0);
    if (v.squaredNorm() <= 1.0) return v;
  }
}

Model make_tetrahedron(double edge) {
  require_length("make_tetrahedron", "edge", edge);
  Model model = named_model("tetrahedron");
  model.rest = {Vec3(0, 0, 0), Vec3(edge, 0, 0), Vec3(edge / 2, edge * std::sqrt(3.0) / 2, 0),
                Vec3(edge / 2, edge * std::sqrt(3.0) / 6, edge * std::sqrt(2.0 / 3.0))};
  add_cell(model, CellType::tetrahedron, {0, 1, 2, 3});
  model.add_group("base", {0, 1, 2}).add_group("apex", {3});
  return finished(std::move(model));
}

Model make_block(const Vec3& size, int nx, int ny, int nz, int valence) {
  // A lattice neighbour (dx, dy, dz) in {-1, 0, 1}^3 has one to three components that are not 0: face, edge, corner.
  const bool edges = valence == 18 || valence == 26, corners = valence == 14 || valence == 26;
  if (valence != 6 && !edges && !corners) {
    throw Error("make_block: expected a valence of 6, 14, 18 or 26, got " + std::to_string(valence));
  }
  require_count("make_block", "nz", nz, 1);
  const Lattice lattice = make_lattice("make_block", size, nx, ny, nz, valence);
  Model model = named_model("block");
  place_lattice(model, lattice, size);
  const auto linked = [&](int dx, int dy, int dz) {
    const int order = dx * dx + dy * dy + dz * dz;
    return order == 1 || (order == 2 && edges) || (order == 3 && corners);
  };
  const auto push_neighbours = [&](int i, int j, int k) {
    std::vector<Index> row;
    for (int dz = -(k > 0); dz <= (k < nz); ++dz) {
      for (int dy = -(j > 0); dy <= (j < ny); ++dy) {
        for (int dx = -(i > 0); dx <= (i < nx); ++dx) {
          if (linked(dx, dy, dz)) row.push_back(lattice.particle(i + dx, j + dy, k + dz));
        }
      }
    }
    model.neighbours.push_row(row.begin(), row.end());
  };
  for (Index p = 0; p < model.particle_count(); ++p) {
    const int i = p % (nx + 1), j = p / (nx + 1) % (ny + 1), k = p / (nx + 1) / (ny + 1);
    push_neighbours(i, j, k);
    if (i == nx || j == ny || k == nz) continue;
    const std::array<Index, 8> cell = lattice.cell(i, j, k);
    add_cell(model, CellType::hexahedron, {cell.begin(), cell.end()});
  }
  add_side_groups(model, lattice);
  return finished(std::move(model));
}

Model make_strip(double width, double height, int nx, int ny, bool diagonals) {
  const Vec3 size(width, height, 0.0);
  const Lattice lattice = make_lattice("make_strip", size, nx, ny, 0, 8);
  Model model = named_model("strip");
  model.dimension = 2;
  place_lattice(model, lattice, size);
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      const auto at = [&](int di, int dj) { return lattice.particle(i + di, j + dj, 0); };
      add_cell(model, CellType::quad, {at(0, 0), at(1, 0), at(1, 1), at(0, 1)});
    }
  }
  if (diagonals) {
    // All pairs of a quad are what all pairs of a tetrahedron over its vertices are.
    std::vector<Cell> pairs = model.cells;
    for (Cell& cell : pairs) cell.type = CellType::tetrahedron;
    model.neighbours = neighbours_from_cells(pairs, model.particle_count());
  }
  add_side_groups(model, lattice);
  return finished(std::move(model));
}

Model make_cylinder(double radius, double length, int rings, int sectors, int discs) {
  constexpr const char* what = "make_cylinder";
  require_length(what, "radius", radius);
  require_length(what, "length", length);
  require_count(what, "rings", rings, 1);
  require_count(what, "sectors", sectors, 3);
  require_count(what, "discs", discs, 2);
  require_countable(what, (1.0 + double{1} * rings * sectors) * discs, std::max(8, sectors));
  const Index per_disc = 1 + rings * sectors;
  const auto particle = [&](int disc, int ring, int sector) {
    return disc * per_disc + (ring == 0 ? 0 : 1 + (ring - 1) * sectors + sector % sectors);
  };
  Model model = named_model("regular cylinder");
  std::vector<Index> bottom, top, side;
  for (int disc = 0; disc < discs; ++disc) {
    const double z = length * disc / (discs - 1);
    for (Index p = 0; p < per_disc; ++p) {
      const int ring = p == 0 ? 0 : 1 + (p - 1) / sectors;
      const double r = radius * ring / rings, angle = 2.0 * std::numbers::pi * ((p + sectors - 1) % sectors) / sectors;
      const Index row = disc * per_disc + p;
      model.rest.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
      if (disc == 0) bottom.push_back(row);
      if (disc == discs - 1) top.push_back(row);
      if (ring == rings) side.push_back(row);
    }
  }
  for (int d = 0; d + 1 < discs; ++d) {
    for (int s = 0; s < sectors; ++s) {
      add_cell(model, CellType::wedge,
               {particle(d, 0, 0), particle(d, 1, s), particle(d, 1, s + 1), particle(d + 1, 0, 0),
                particle(d + 1, 1, s), particle(d + 1, 1, s + 1)});
      for (int r = 1; r < rings; ++r) {
        add_cell(model, CellType::hexahedron,
                 {particle(d, r, s), particle(d, r + 1, s), particle(d, r + 1, s + 1), particle(d, r, s + 1),
                  particle(d + 1, r, s), particle(d + 1, r + 1, s), particle(d + 1, r + 1, s + 1),
                  particle(d + 1, r, s + 1)});
      }
    }
  }
  model.add_group("bottom", std::move(bottom)).add_group("top", std::move(top)).add_group("side", std::move(side));
  return finished(std::move(model));
}

void jitter(Model& model, double amount, std::uint32_t seed) {
  if (!(amount >= 0.0) || !std::isfinite(amount)) {
    throw Error("jitter: expected a finite amount of 0 or more spacings, got " + to_decimal(amount));
  }
  const double length = amount * mean_spacing(model);
  Random random(seed);
  for (Vec3& x : model.rest) x += length * random.in_ball(model.dimension);
}

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
