// SPDX-License-Identifier: MIT
//
// A coarse level of statics: a regular grid of trilinear cells over the rest shape, of which only those cells count
// that hold material. Each has one mean displacement gradient and the energy of its material there, and a penalty on
// what the mean leaves out, as Law::particle_averaged has for particles; so it bends and changes its volume as softly
// as the body. The cells turn with the body (corotational elements: C. Felippa and B. Haugen, Comput. Methods Appl.
// Mech. Engrg. 194 (2005) 2285-2335).
#pragma once

#include <phymul/topology_textures.h>
#include <phymul/types.h>

#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "block_matrix.h"

namespace phymul {

/// The box that all grids of statics share, and the cells of one of them. Places of cells and of nodes have rows in
/// tables of the whole grid, the longest axis slowest: neighbours have close rows then.
struct GridShape {
  Vec3 origin{0, 0, 0}, spacing{0, 0, 0};  ///< m
  std::array<Index, 3> cells{1, 1, 1};
  std::array<int, 3> slow_to_fast{2, 1, 0};  ///< the axes, the longest first

  /// Cells of about `spacing`, m, over the box of the points.
  static GridShape over(std::span<const Vec3> points, double spacing);
  GridShape coarser() const;  ///< twice the spacing; beyond the box where a number of cells is odd

  /// Of cells, or with `more` = 1 of nodes.
  std::size_t row_of(const std::array<Index, 3>& at, Index more) const;
  std::size_t rows(Index more) const;
  /// Calls visit(at) by rows.
  template <class Visit>
  void for_each_place(Index more, const Visit& visit) const {
    const auto [slow, middle, fast] = slow_to_fast;
    std::array<Index, 3> at;
    for (at[slow] = 0; at[slow] < cells[slow] + more; ++at[slow]) {
      for (at[middle] = 0; at[middle] < cells[middle] + more; ++at[middle]) {
        for (at[fast] = 0; at[fast] < cells[fast] + more; ++at[fast]) visit(at);
      }
    }
  }
};

/// The place of a cell's corner `a`, whose bits are its sides along the axes.
inline std::array<Index, 3> corner_at(std::array<Index, 3> cell, int a) {
  for (int axis = 0; axis < 3; ++axis) cell[axis] += a >> axis & 1;
  return cell;
}

/// Nodes around a place and their weights, which sum to 1.
struct GridPlace {
  std::array<Index, 8> node;
  std::array<float, 8> weight;
};

class GridLevel {
 public:
  /// `fixed` [N]: as LoadFrame::fixed. Without terms.
  GridLevel(const TopologyTextures& topology, std::span<const std::uint8_t> fixed, const GridShape& shape);

  /// From the next assemble() on with terms of these blocks, RestTerm::add_diagonal(), as if all ended at the world.
  void add_terms(const TopologyTextures& topology, std::span<const Mat3> blocks);
  void remove_terms();
  /// The stiffness of cells that have turned: `gradients` as Tangent::linearise. Rows are nodes.
  void assemble(std::span<const Mat3> gradients, BlockMatrix& stiffness) const;
  /// The same as a dense matrix, [3 nodes, 3 nodes], of which only the lower triangle is set.
  Eigen::MatrixXd dense_stiffness(std::span<const Mat3> gradients) const;
  BlockMatrix empty_stiffness();  ///< what assemble() takes

  /// Of the problem: find the displacement along an axis whose gradients are, in the mean, given ones, 0 where
  /// particles are held. The lower triangle, [nodes, nodes].
  Eigen::SparseMatrix<double> laplacian(int axis) const;
  /// Its right-hand side, [3 nodes], for [domains] gradients.
  void sources(std::span<const Mat3> gradients, Eigen::VectorXd& b) const;

  Index nodes() const { return static_cast<Index>(node_place_.size()); }
  GridPlace place_of(const Vec3& point) const;  ///< nodes that are not there have weight 0
  const Vec3& node_place(Index node) const { return node_place_[node]; }

 private:
  using ByAxis = std::array<Eigen::Matrix<double, 8, 8>, 3>;
  struct Cell {
    std::array<Index, 8> node;
    std::array<Index, 64> entry;     // of the matrix of assemble()
    double volume = 0.0;             // m^3, of its material
    double shear = 0.0, lame = 0.0;  // Pa, means
    /// Mean of the gradients of the nodes' functions, 1/m.
    Eigen::Matrix<double, 8, 3> gradient = Eigen::Matrix<double, 8, 3>::Zero();
    /// N/m, what the mean leaves out.
    Eigen::Matrix<double, 8, 8> spread = Eigen::Matrix<double, 8, 8>::Zero();
    Index held = none, terms = none;  // in held_ and terms_
  };
  struct Part {  // of a domain in a cell
    Index cell, domain;
    double share;
  };

  /// Calls visit(cell, a, b, block) for the corners a and b of all cells.
  template <class Visit>
  void for_each_block(std::span<const Mat3> gradients, const Visit& visit) const;
  void share_out(const TopologyTextures& topology);
  void number_cells();
  /// In [0, 1]^3.
  Vec3 place_in(const Cell& cell, const Vec3& point) const {
    return (point - node_place_[cell.node[0]]).cwiseQuotient(shape_.spacing);
  }

  GridShape shape_;
  std::vector<Index> node_of_, cell_of_;  // by GridShape::row_of(); none
  std::vector<Vec3> node_place_;
  std::vector<Cell> cells_;
  std::vector<Part> parts_;
  std::vector<ByAxis> held_, terms_;  // N/m, of particles that are held, and of terms
};

}  // namespace phymul
