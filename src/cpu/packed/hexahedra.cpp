// SPDX-License-Identifier: MIT
#include "hexahedra.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace phymul::cpu {
namespace {

static_assert(simd::simplex_constants == simplex_constant_count);

/// Constants are equal within this, relative to the greatest of their kind: lattice places are rounded in double.
constexpr double equal = 1e-9;
/// A shape must have many cells, else vectors of one shape are mostly idle; and a body of many shapes is no lattice, so
/// that the search for a cell's shape must not take long.
constexpr std::size_t least_cells = 128, most_shapes = 32;

using Constants = std::vector<double>;

/// The simplex of four particles, its terms put in the order of `vertex`.
std::optional<Index> simplex_row(const Simplices& simplices, const std::array<Index, 4>& vertex) {
  std::array<Index, 4> key = vertex;
  std::ranges::sort(key);
  const auto found = std::ranges::lower_bound(simplices.all, key, {}, &Simplex::vertex);
  if (found == simplices.all.end() || found->vertex != key) return std::nullopt;
  return static_cast<Index>(found - simplices.all.begin());
}

Simplex in_order(const Simplex& simplex, const std::array<Index, 4>& vertex) {
  Simplex ordered = simplex;
  ordered.vertex = vertex;
  for (int k = 0; k < 4; ++k) {
    ordered.base[k] = simplex.base[std::ranges::find(simplex.vertex, vertex[k]) - simplex.vertex.begin()];
  }
  return ordered;
}

struct Found {
  Index cell = none;
  std::array<Index, 8> simplex{};
  Constants constants;
};

std::optional<Found> hexahedron_of(const TopologyTextures& t, const Simplices& simplices, Index row) {
  const CellTexel& cell = t.cells[row];
  if (cell.vertex[7] == none) return std::nullopt;
  Found found;
  found.cell = row;
  for (int corner = 0; corner < 8; ++corner) {
    const auto& edge = simd::hexahedron_edges[corner];
    const std::array<Index, 4> vertex{cell.vertex[corner], cell.vertex[edge[0]], cell.vertex[edge[1]],
                                      cell.vertex[edge[2]]};
    const std::optional<Index> s = simplex_row(simplices, vertex);
    if (!s) return std::nullopt;
    found.simplex[corner] = *s;
    const auto constants = simplex_constants(t, in_order(simplices.all[*s], vertex));
    found.constants.insert(found.constants.end(), constants.begin(), constants.end());
  }
  for (int k = 1; k < 8; ++k) {
    for (int a = 0; a < 3; ++a) found.constants.push_back(cell.gradient[k][a]);
  }
  found.constants.push_back(cell.shape_stiffness);
  found.constants.push_back(cell.volume_stiffness);
  return found;
}

/// Edges and gradients are compared as vectors, lambda with 1, the rest number by number.
bool same_shape(const Constants& a, const Constants& b) {
  const auto near = [&](std::size_t k, double scale) { return std::abs(a[k] - b[k]) <= equal * scale; };
  const auto largest = [&](std::size_t first, std::size_t count) {
    double most = 0.0;
    for (std::size_t k = first; k < first + count; ++k) most = std::max(most, std::abs(a[k]));
    return most;
  };
  constexpr std::size_t gradients = 8 * simplex_constant_count;
  for (std::size_t k = 0; k < a.size(); ++k) {
    double scale = std::max(std::abs(a[k]), std::abs(b[k]));
    if (k < gradients) {
      const std::size_t column = k % simplex_constant_count;
      if (column < 9) scale = largest(k - column, 9);
      const bool lambda = column == 12 || column == 13 || column == 17 || column == 18 || column == 22 ||
                          column == 23 || (column >= 27 && column <= 29);
      if (lambda) scale = std::max(scale, 1.0);
    } else if (k < gradients + 21) {
      scale = largest(gradients, 21);
    }
    if (!near(k, scale)) return false;
  }
  return true;
}

}  // namespace

Hexahedra find_hexahedra(const TopologyTextures& t, const Simplices& simplices) {
  Hexahedra result;
  result.simplex_taken.assign(simplices.all.size(), false);
  result.cell_taken.assign(t.cells.size(), false);
  if (simplices.all.empty() || t.cells.size() < least_cells) return result;
  struct Candidate {
    Index cell;
    std::array<Index, 8> simplex;
    std::size_t shape;
  };
  std::vector<Candidate> candidates;
  std::vector<Constants> shapes;
  std::vector<std::size_t> cells_of;
  for (std::size_t row = 0; row < t.cells.size(); ++row) {
    const std::optional<Found> found = hexahedron_of(t, simplices, static_cast<Index>(row));
    if (!found) continue;
    auto shape = std::ranges::find_if(shapes, [&](const Constants& s) { return same_shape(s, found->constants); });
    if (shape == shapes.end()) {
      if (shapes.size() == most_shapes) continue;
      shapes.push_back(found->constants);
      cells_of.push_back(0);
      shape = shapes.end() - 1;
    }
    const auto number = static_cast<std::size_t>(shape - shapes.begin());
    ++cells_of[number];
    candidates.push_back({static_cast<Index>(row), found->simplex, number});
  }
  std::vector<int> kept(shapes.size(), -1);
  for (std::size_t shape = 0; shape < shapes.size(); ++shape) {
    if (cells_of[shape] < least_cells) continue;
    kept[shape] = static_cast<int>(result.shapes.size());
    result.shapes.push_back(shapes[shape]);
  }
  for (const Candidate& c : candidates) {
    const bool shared = std::ranges::any_of(c.simplex, [&](Index s) { return result.simplex_taken[s]; });
    if (kept[c.shape] < 0 || shared) continue;
    result.all.push_back({t.cells[c.cell].vertex, kept[c.shape]});
    result.cell_taken[c.cell] = true;
    for (const Index s : c.simplex) result.simplex_taken[s] = true;
  }
  return result;
}

}  // namespace phymul::cpu
