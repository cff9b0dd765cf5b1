// SPDX-License-Identifier: MIT
//
// A curved path through the states of a body in place of a straight one. Where parts of a body turn, as in bending, a
// straight step along the linear solution stretches them. Here each domain turns by the rotation that the solution asks
// of it, and is strained by the rest of it; the displacement that fits these gradients best is found on a grid
// (modal warping: M. Choi and H. Ko, IEEE Trans. Vis. Comput. Graph. 11 (2005) 91-101; rotation-strain coordinates:
// J. Huang et al., Proc. SCA 2011, 37-45).
#pragma once

#include <Eigen/SparseCholesky>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "grid_level.h"

namespace phymul {

class TurningPath {
 public:
  /// `level` must outlive it.
  TurningPath(const TopologyTextures& topology, const GridLevel& level);

  /// From a state with mean gradients `at` along a part `share` of the displacement d, [3 N], whose mean gradients are
  /// `change`: `added` is what makes it follow the curve, of second order in d.
  void bend(std::span<const Mat3> at, std::span<const Mat3> change, double share, Eigen::VectorXd& added);

 private:
  const GridLevel& level_;
  std::vector<GridPlace> places_;  // of particles
  std::vector<Mat3> missing_;
  /// By axis; null: the same as that of the axis before.
  std::array<std::unique_ptr<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>>, 3> solvers_;
};

}  // namespace phymul
