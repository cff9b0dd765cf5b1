// SPDX-License-Identifier: MIT
//
// Walls of a body that is changed.
#include <algorithm>
#include <vector>

#include "body_edit.h"
#include "model/cell_geometry.h"
#include "wall_terms.h"

namespace phymul {
namespace {

/// What a removed triangle has.
WallTexel without_energy(const WallTexel& wall) {
  WallTexel none_left;
  std::ranges::copy_n(wall.vertex.begin(), 3, none_left.vertex.begin());
  none_left.tangent = {Vec3::UnitX(), Vec3::UnitY()};
  none_left.compliance = wall.compliance;
  return none_left;
}

/// N/m, or bounds on it: what a triangle adds to the own block of vertex v of its patch.
double own_stiffness_of(const WallTexel& wall, std::size_t v) {
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  Vec3 h = Vec3::Zero();
  for (std::size_t k = v == 0 ? 1 : v; k < (v == 0 ? 6 : v + 1); ++k) {
    g += Eigen::Vector2d(wall.gradient[k].data());
    h += Vec3(wall.hessian[k].data());
  }
  const auto& b = wall.bending;
  Mat3 bending;
  bending << b[0], b[5], b[4], b[5], b[1], b[3], b[4], b[3], b[2];
  // E / (1 - nu^2) over the shear modulus.
  const double plane = 2.0 * (2.0 + wall.compliance) / (1.0 + 2.0 * wall.compliance);
  return plane * wall.shear * g.squaredNorm() + h.dot(bending * h);
}

}  // namespace

/// The triangles that have one of these particles in their patch; the particles of these patches are added.
void BodyEdit::follow_walls(std::vector<Index>& particles) {
  std::vector<Index> walls;
  for (const Index i : particles) {
    for (const Index row : walls_of_[i]) {
      if (is_of_wall(model_, model_.cells[row])) walls.push_back(row);
    }
  }
  std::ranges::sort(walls);
  const auto again = std::ranges::unique(walls);
  walls.erase(again.begin(), again.end());
  for (const Index row : walls) {
    const auto add_patch = [&] {
      if (wall_at_[row] == none) return;
      for (const Index i : topology_.walls[wall_at_[row]].vertex) {
        if (i != none) particles.push_back(i);
      }
    };
    add_patch();
    write_wall(row);
    add_patch();
  }
}

double BodyEdit::own_stiffness_in_walls(Index particle) const {
  double sum = 0.0;
  each_wall_with(particle, [&](const WallTexel& wall, std::size_t v) { sum += own_stiffness_of(wall, v); });
  return sum;
}

/// Calls visit(wall, v) for each triangle of whose patch the particle is vertex v.
template <class Visit>
void BodyEdit::each_wall_with(Index particle, Visit visit) const {
  const auto visit_at = [&](Index row, std::size_t first, std::size_t last) {
    if (!is_of_wall(model_, model_.cells[row]) || wall_at_[row] == none) return;
    const WallTexel& wall = topology_.walls[wall_at_[row]];
    for (std::size_t v = first; v < last; ++v) {
      if (wall.vertex[v] == particle) visit(wall, v);
    }
  };
  for (const Index row : walls_of_[particle]) {
    visit_at(row, 0, 3);
    const Cell& cell = model_.cells[row];
    if (cell.type != CellType::triangle) continue;
    // Across the side that is opposite to the particle.
    const std::ptrdiff_t at = std::ranges::find(cell.particles, particle) - cell.particles.begin();
    for (const Index beside : walls_of_[cell.particles[(at + 1) % 3]]) {
      const std::vector<Index>& further = walls_of_[cell.particles[(at + 2) % 3]];
      if (beside != row && std::ranges::binary_search(further, beside)) visit_at(beside, 3, 6);
    }
  }
}

/// The constants of a triangle as it is now. One that is removed keeps a row whose energy is 0.
void BodyEdit::write_wall(Index row) {
  const bool there = is_wall(model_, model_.cells[row]);
  if (wall_at_[row] == none) {
    if (!there) return;
    if (free_walls_.empty()) {
      free_walls_.push_back(static_cast<Index>(topology_.walls.size()));
      topology_.walls.emplace_back();
    }
    wall_at_[row] = free_walls_.back();
    free_walls_.pop_back();
  }
  WallTexel& wall = topology_.walls[wall_at_[row]];
  wall = there ? wall_term(model_, row, walls_of_) : without_energy(wall);
}

void BodyEdit::free_wall(Index row) {
  const Index at = wall_at_[row];
  if (at == none) return;
  topology_.walls[at] = without_energy(topology_.walls[at]);
  free_walls_.push_back(at);
}

}  // namespace phymul
