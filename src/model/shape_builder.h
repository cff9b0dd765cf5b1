// SPDX-License-Identifier: MIT
//
// What the shape builders share.
#pragma once

#include <phymul/model.h>

#include <array>
#include <cstdint>
#include <random>
#include <string>

namespace phymul {

/// Numbering of the particles of a box lattice of cells, x fastest.
struct Lattice {
  int nx = 0, ny = 0, nz = 0;  ///< cells along each axis

  Index particle(int i, int j, int k) const { return i + (nx + 1) * (j + (ny + 1) * k); }
  /// Ring below, ring above, as a hexahedron has them.
  std::array<Index, 8> cell(int i, int j, int k) const {
    return {particle(i, j, k),     particle(i + 1, j, k),     particle(i + 1, j + 1, k),     particle(i, j + 1, k),
            particle(i, j, k + 1), particle(i + 1, j, k + 1), particle(i + 1, j + 1, k + 1), particle(i, j + 1, k + 1)};
  }
};

/// Checks the arguments of a box builder named `what`, so that no index of a body with `entries_per_particle` list
/// entries leaves 32 bits. Throws Error.
Lattice make_lattice(const char* what, const Vec3& size, int nx, int ny, int nz, int entries_per_particle);

/// Throws Error unless `value` is positive and finite.
void require_length(const char* what, const char* name, double value);

/// Rest places of a lattice over a box at the origin.
void place_lattice(Model& model, const Lattice& lattice, const Vec3& size);

/// Groups "x0" ... "z1": the particles on the six sides (four in 2-D).
void add_side_groups(Model& model, const Lattice& lattice);

/// Appends a cell to the model and to its last component.
void add_cell(Model& model, CellType type, std::vector<Index> particles);

/// An empty model with the components that hold cells, as a file's would be.
Model named_model(std::string name);

/// Unit mass and stiffness, neighbours from the cells where there are none yet, then validate.
Model finished(Model model);

/// Uniform numbers that are the same on every platform (std::uniform_real_distribution's are not).
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  std::uint32_t bits() { return static_cast<std::uint32_t>(engine_()); }
  double unit() { return bits() * 0x1p-32; }  ///< in [0, 1)
  Vec3 in_ball(int dimension);                ///< uniform in the unit ball; 2: in the unit disc of the plane z = 0

 private:
  std::mt19937 engine_;
};

}  // namespace phymul
