// SPDX-License-Identifier: MIT
#include "grid_level.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <utility>

#include "base/box_tree.h"
#include "elastic/energy_density.h"
#include "elastic/rotation.h"

namespace phymul {
namespace {

/// Penalty on what the mean of a cell leaves out, in shear moduli: as of hexahedra (TopologyOptions::stabiliser). A
/// part of it is that of the whole cell, whatever it holds, so that no motion of its nodes is free.
constexpr double spread_of_parts = 0.4, spread_of_cell = 0.1;
/// Stiffness that holds the grid at held particles, in shear modulus times the size of a particle's volume.
constexpr double hold = 10.0;
/// Of the diagonal, for bodies that nothing holds.
constexpr double regularisation = 1e-9;
/// In cells: a particle this near to a plane between two belongs to both.
constexpr double on_plane = 1e-6;

using Gradient = Eigen::Matrix<double, 8, 3>;
using ByCorners = Eigen::Matrix<double, 8, 8>;
using ByAxis = std::array<ByCorners, 3>;

double side(int corner, int axis) {
  return (corner >> axis & 1) != 0 ? 1.0 : 0.0;
}

/// Values of the trilinear functions at t in [0, 1]^3.
std::array<double, 8> weights_at(const Vec3& t) {
  std::array<double, 8> weight;
  for (int a = 0; a < 8; ++a) {
    weight[a] = 1.0;
    for (int axis = 0; axis < 3; ++axis) weight[a] *= side(a, axis) > 0.0 ? t[axis] : 1.0 - t[axis];
  }
  return weight;
}

Gradient gradients_at(const Vec3& t, const Vec3& spacing) {
  Gradient gradient;
  for (int a = 0; a < 8; ++a) {
    for (int axis = 0; axis < 3; ++axis) {
      double value = (side(a, axis) > 0.0 ? 1.0 : -1.0) / spacing[axis];
      for (int other = 0; other < 3; ++other) {
        if (other != axis) value *= side(a, other) > 0.0 ? t[other] : 1.0 - t[other];
      }
      gradient(a, axis) = value;
    }
  }
  return gradient;
}

/// grad N_a . grad N_b.
ByCorners products(const Gradient& gradient) {
  return gradient * gradient.transpose();
}

/// Mean over a cell of grad N_a . grad N_b, less the product of their means.
ByCorners spread_over_cell(const Vec3& spacing) {
  ByCorners spread = -products(gradients_at(Vec3::Constant(0.5), spacing));
  for (int corner = 0; corner < 8; ++corner) {  // Gauss points
    Vec3 t;
    for (int axis = 0; axis < 3; ++axis) t[axis] = 0.5 + (side(corner, axis) - 0.5) / std::sqrt(3.0);
    spread += 0.125 * products(gradients_at(t, spacing));
  }
  return spread;
}

/// The one of `all` that `row` names, a new one of zeros if it names none.
ByAxis& block_of(Index& row, std::vector<ByAxis>& all) {
  if (row == none) {
    row = static_cast<Index>(all.size());
    all.emplace_back().fill(ByCorners::Zero());
  }
  return all[row];
}

/// What `held`, N/m by axis, at t in [0, 1]^3 is for the nodes.
void add_held(const Vec3& t, const Vec3& held, ByAxis& sum) {
  const std::array<double, 8> weight = weights_at(t);
  const Eigen::Map<const Eigen::Matrix<double, 8, 1>> w(weight.data());
  for (int axis = 0; axis < 3; ++axis) sum[axis] += held[axis] * w * w.transpose();
}

}  // namespace

GridShape GridShape::over(std::span<const Vec3> points, double spacing) {
  const Eigen::AlignedBox3d box = bounding_box(points);
  // Tables are of the whole box: one much larger than what is in it gets larger cells.
  const double most = std::min(1e9, 1e6 + 64.0 * static_cast<double>(points.size()));
  while (((box.sizes() / spacing).array() + 2.0).prod() > most) spacing *= 1.25;
  GridShape shape{.origin = box.min()};
  for (int axis = 0; axis < 3; ++axis) {
    const double size = box.sizes()[axis];
    shape.cells[axis] = std::max(1, static_cast<Index>(std::lround(size / spacing)));
    shape.spacing[axis] = size > 0.0 ? size / shape.cells[axis] : spacing;
  }
  std::ranges::stable_sort(shape.slow_to_fast, std::greater(), [&](int axis) { return shape.cells[axis]; });
  return shape;
}

GridShape GridShape::coarser() const {
  GridShape shape{.origin = origin, .spacing = 2.0 * spacing, .slow_to_fast = slow_to_fast};
  for (int axis = 0; axis < 3; ++axis) shape.cells[axis] = (cells[axis] + 1) / 2;
  return shape;
}

std::size_t GridShape::row_of(const std::array<Index, 3>& at, Index more) const {
  std::size_t row = 0;
  for (const int axis : slow_to_fast) row = row * static_cast<std::size_t>(cells[axis] + more) + at[axis];
  return row;
}

std::size_t GridShape::rows(Index more) const {
  std::size_t rows = 1;
  for (const Index count : cells) rows *= static_cast<std::size_t>(count + more);
  return rows;
}

/// Cells and nodes get numbers in the order of their rows.
void GridLevel::number_cells() {
  shape_.for_each_place(0, [&](const std::array<Index, 3>& at) {
    if (cell_of_[shape_.row_of(at, 0)] == none) return;
    for (int a = 0; a < 8; ++a) node_of_[shape_.row_of(corner_at(at, a), 1)] = 0;
  });
  shape_.for_each_place(1, [&](const std::array<Index, 3>& at) {
    Index& node = node_of_[shape_.row_of(at, 1)];
    if (node == none) return;
    node = static_cast<Index>(node_place_.size());
    node_place_.push_back(shape_.origin + shape_.spacing.cwiseProduct(Vec3(at[0], at[1], at[2])));
  });
  shape_.for_each_place(0, [&](const std::array<Index, 3>& at) {
    Index& known = cell_of_[shape_.row_of(at, 0)];
    if (known == none) return;
    known = static_cast<Index>(cells_.size());
    Cell& cell = cells_.emplace_back();
    for (int a = 0; a < 8; ++a) cell.node[a] = node_of_[shape_.row_of(corner_at(at, a), 1)];
  });
}

/// Domains in cells, by rows of the table of cells.
void GridLevel::share_out(const TopologyTextures& topology) {
  for (Index d = 0; d < static_cast<Index>(topology.domains.size()); ++d) {
    const DomainTexel& domain = topology.domains[d];
    if (domain.link_count == 0) continue;  // its cells were removed
    const Vec3 t = (topology.rest[domain.particle] - shape_.origin).cwiseQuotient(shape_.spacing);
    std::array<std::array<Index, 2>, 3> range;
    double share = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto clamped = [&](double value) {
        return std::clamp(static_cast<Index>(std::floor(value)), Index{0}, shape_.cells[axis] - 1);
      };
      range[axis] = {clamped(t[axis] - on_plane), clamped(t[axis] + on_plane)};
      if (range[axis][0] != range[axis][1]) share *= 0.5;
    }
    std::array<Index, 3> at;
    for (at[2] = range[2][0]; at[2] <= range[2][1]; ++at[2]) {
      for (at[1] = range[1][0]; at[1] <= range[1][1]; ++at[1]) {
        for (at[0] = range[0][0]; at[0] <= range[0][1]; ++at[0]) {
          const std::size_t row = shape_.row_of(at, 0);
          cell_of_[row] = 0;
          parts_.push_back({static_cast<Index>(row), d, share / domain.inverse_volume});
        }
      }
    }
  }
}

GridLevel::GridLevel(const TopologyTextures& topology, std::span<const std::uint8_t> fixed, const GridShape& shape)
    : shape_(shape) {
  cell_of_.assign(shape.rows(0), none);
  node_of_.assign(shape.rows(1), none);
  share_out(topology);
  number_cells();
  for (Part& part : parts_) {
    part.cell = cell_of_[part.cell];
    Cell& cell = cells_[part.cell];
    const DomainTexel& domain = topology.domains[part.domain];
    Mat3 unit = Mat3::Zero();
    unit(0, 1) = 1.0;
    const EnergyConstants& energy = topology.energy_of(part.domain);
    const double shear = stress_near_rest<double>(topology.options.strain_energy, energy, unit)(0, 1);
    unit.setZero();
    unit(0, 0) = 1.0;
    const double lame = stress_near_rest<double>(topology.options.strain_energy, energy, unit)(1, 1);
    const Vec3 local = place_in(cell, topology.rest[domain.particle]);
    const Gradient gradient = gradients_at(local, shape.spacing);
    cell.volume += part.share;
    cell.shear += part.share * shear;
    cell.lame += part.share * lame;
    cell.gradient += part.share * gradient;
    cell.spread += part.share * shear * products(gradient);
    Vec3 held = Vec3::Zero();
    for (int axis = 0; axis < 3 && !fixed.empty(); ++axis) {
      if ((fixed[domain.particle] >> axis & 1) == 0) continue;
      held[axis] = hold * shear * part.share * std::cbrt(domain.inverse_volume * domain.inverse_volume);
    }
    if (!held.isZero(0.0)) add_held(local, held, block_of(cell.held, held_));
  }
  const ByCorners over_cell = spread_over_cell(shape.spacing);
  for (Cell& cell : cells_) {
    cell.gradient /= cell.volume;
    cell.spread = spread_of_parts * (cell.spread - cell.shear * products(cell.gradient)) +
                  spread_of_cell * cell.shear * over_cell;
    cell.shear /= cell.volume;
    cell.lame /= cell.volume;
  }
}

void GridLevel::remove_terms() {
  terms_.clear();
  for (Cell& cell : cells_) cell.terms = none;
}

void GridLevel::add_terms(const TopologyTextures& topology, std::span<const Mat3> blocks) {
  remove_terms();
  std::vector<Index> first(blocks.size(), none);  // of a particle's domains that are left
  for (const Part& part : parts_) {
    const DomainTexel& domain = topology.domains[part.domain];
    Index& own = first[domain.particle];
    if (own == none) own = part.domain;
    if (own != part.domain || blocks[domain.particle].isZero(0.0)) continue;
    Cell& cell = cells_[part.cell];
    const Vec3 local = place_in(cell, topology.rest[domain.particle]);
    const double share = part.share * domain.inverse_volume;
    add_held(local, share * blocks[domain.particle].diagonal(), block_of(cell.terms, terms_));
  }
}

BlockMatrix GridLevel::empty_stiffness() {
  // Bits of a row: its neighbours, as many as 27, in the order of their numbers.
  const auto bit_of = [&](int a, int b) {
    int bit = 0;
    for (const int axis : shape_.slow_to_fast) bit = 3 * bit + 1 + (b >> axis & 1) - (a >> axis & 1);
    return bit;
  };
  std::vector<std::uint32_t> neighbours(node_place_.size(), 0);
  for (const Cell& cell : cells_) {
    for (int k = 0; k < 64; ++k) neighbours[cell.node[k / 8]] |= 1u << bit_of(k / 8, k % 8);
  }
  std::vector<Index> first{0};
  for (const std::uint32_t bits : neighbours) first.push_back(first.back() + std::popcount(bits));
  std::vector<Index> column(static_cast<std::size_t>(first.back()));
  for (Cell& cell : cells_) {
    for (int k = 0; k < 64; ++k) {
      const Index row = cell.node[k / 8];
      cell.entry[k] = first[row] + std::popcount(neighbours[row] & ((1u << bit_of(k / 8, k % 8)) - 1));
      column[cell.entry[k]] = cell.node[k % 8];
    }
  }
  return BlockMatrix(std::move(first), std::move(column));
}

template <class Visit>
void GridLevel::for_each_block(std::span<const Mat3> gradients, const Visit& visit) const {
  std::vector<Mat3> turned(cells_.size(), Mat3::Zero());
  for (const Part& part : parts_) turned[part.cell] += part.share * (Mat3::Identity() + gradients[part.domain]);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const Cell& cell = cells_[c];
    const Gradient g = cell.gradient * polar_rotation(turned[c]).transpose();  // rows R g_a
    const ByCorners inner = products(g);
    for (int a = 0; a < 8; ++a) {
      const Vec3 ga = g.row(a);
      for (int b = 0; b < 8; ++b) {
        const Vec3 gb = g.row(b);
        Mat3 block = cell.volume * (cell.shear * gb * ga.transpose() + cell.lame * ga * gb.transpose());
        block.diagonal().array() += cell.volume * cell.shear * inner(a, b) + cell.spread(a, b);
        for (int axis = 0; axis < 3; ++axis) {
          if (cell.held != none) block(axis, axis) += held_[cell.held][axis](a, b);
          if (cell.terms != none) block(axis, axis) += terms_[cell.terms][axis](a, b);
        }
        if (a == b) block.diagonal() *= 1.0 + regularisation;
        visit(cell, a, b, block);
      }
    }
  }
}

void GridLevel::assemble(std::span<const Mat3> gradients, BlockMatrix& stiffness) const {
  stiffness.set_zero();
  for_each_block(gradients, [&](const Cell& cell, int a, int b, const Mat3& block) {
    stiffness.at(cell.entry[8 * a + b]) += block.cast<float>();
  });
  stiffness.invert_diagonal();
}

Eigen::MatrixXd GridLevel::dense_stiffness(std::span<const Mat3> gradients) const {
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(3 * nodes(), 3 * nodes());
  for_each_block(gradients, [&](const Cell& cell, int a, int b, const Mat3& block) {
    if (cell.node[a] >= cell.node[b]) stiffness.block<3, 3>(3 * cell.node[a], 3 * cell.node[b]) += block;
  });
  return stiffness;
}

Eigen::SparseMatrix<double> GridLevel::laplacian(int axis) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (const Cell& cell : cells_) {
    ByCorners values = cell.volume * products(cell.gradient) + cell.spread / cell.shear;
    if (cell.held != none) values += held_[cell.held][axis] / cell.shear;
    values.diagonal() *= 1.0 + regularisation;
    for (int a = 0; a < 8; ++a) {
      for (int b = 0; b < 8; ++b) {
        if (cell.node[a] >= cell.node[b]) entries.emplace_back(cell.node[a], cell.node[b], values(a, b));
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(nodes(), nodes());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

void GridLevel::sources(std::span<const Mat3> gradients, Eigen::VectorXd& b) const {
  std::vector<Mat3> sums(cells_.size(), Mat3::Zero());
  for (const Part& part : parts_) sums[part.cell] += part.share * gradients[part.domain];
  b = Eigen::VectorXd::Zero(3 * nodes());
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    for (int a = 0; a < 8; ++a) {
      b.segment<3>(3 * cells_[c].node[a]) += sums[c] * cells_[c].gradient.row(a).transpose();
    }
  }
}

GridPlace GridLevel::place_of(const Vec3& point) const {
  const Vec3 t = (point - shape_.origin).cwiseQuotient(shape_.spacing);
  std::array<Index, 3> at;
  for (int axis = 0; axis < 3; ++axis) {
    at[axis] = std::clamp(static_cast<Index>(std::floor(t[axis])), Index{0}, shape_.cells[axis] - 1);
  }
  GridPlace place{};
  std::array<double, 8> weight = weights_at(t - Vec3(at[0], at[1], at[2]));
  double sum = 0.0;
  for (int a = 0; a < 8; ++a) {
    const Index node = node_of_[shape_.row_of(corner_at(at, a), 1)];
    place.node[a] = std::max(node, Index{0});
    if (node == none) weight[a] = 0.0;
    sum += weight[a];
  }
  // No node: a particle far from all cells that are left, which is held.
  for (int a = 0; a < 8 && sum > 0.0; ++a) place.weight[a] = static_cast<float>(weight[a] / sum);
  return place;
}

}  // namespace phymul
