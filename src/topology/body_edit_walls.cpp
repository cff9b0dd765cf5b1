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

/// Whose terms are which.
void BodyEdit::find_walls() {
  const std::vector<WallTexel>& walls = topology_.walls;
  std::size_t next = 0;
  for (Index row = 0; row < static_cast<Index>(model_.cells.size()); ++row) {
    const Cell& cell = model_.cells[row];
    const auto is_its_own = [&](const WallTexel& wall) {
      return std::equal(cell.particles.begin(), cell.particles.end(), wall.vertex.begin());
    };
    walls_at_.emplace_back();
    while (is_wall(model_, cell) && next < walls.size() && is_its_own(walls[next])) {
      walls_at_.back().push_back(static_cast<Index>(next++));
    }
  }
}

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
      for (const Index term : walls_at_[row]) {
        for (const Index i : topology_.walls[term].vertex) {
          if (i != none) particles.push_back(i);
        }
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
    for (const Index term : walls_at_[row]) {
      const WallTexel& wall = topology_.walls[term];
      for (std::size_t v = first; v < last; ++v) {
        if (wall.vertex[v] == particle) visit(wall, v);
      }
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

/// The terms of a triangle as it is now. Rows that it no longer needs stay its own; their energy is 0.
void BodyEdit::write_wall(Index row) {
  std::vector<WallTexel> now;
  if (is_wall(model_, model_.cells[row])) now = wall_terms_of(model_, row, walls_of_);
  std::vector<Index>& terms = walls_at_[row];
  while (terms.size() < now.size()) {
    if (free_walls_.empty()) {
      free_walls_.push_back(static_cast<Index>(topology_.walls.size()));
      topology_.walls.emplace_back();
    }
    terms.push_back(free_walls_.back());
    free_walls_.pop_back();
  }
  for (std::size_t k = 0; k < terms.size(); ++k) {
    WallTexel& wall = topology_.walls[terms[k]];
    wall = k < now.size() ? now[k] : without_energy(wall);
  }
}

void BodyEdit::free_walls(std::span<const Index> terms) {
  for (std::size_t k = terms.size(); k-- > 0;) {
    topology_.walls[terms[k]] = without_energy(topology_.walls[terms[k]]);
    free_walls_.push_back(terms[k]);
  }
}

}  // namespace phymul
