// SPDX-License-Identifier: MIT
//
// The stiffness K = -df/dx of Law::particle_averaged at rest, where it is known without differences of forces.
#pragma once

#include <phymul/topology_textures.h>

#include <Eigen/Core>
#include <vector>

namespace phymul {

/// K of a body whose elasticity is that law alone. Keeps a reference to the tables.
class AveragedStiffness {
 public:
  /// True if the body has domains and no other elastic term.
  static bool is_all_of(const TopologyTextures& topology);

  explicit AveragedStiffness(const TopologyTextures& topology);

  /// result = K u. Shapes [3 N], m and N; u has no z in 2-D.
  void apply(const Eigen::VectorXd& u, Eigen::VectorXd& result);
  /// The same on the calling thread alone; allocates nothing if `result` has its size.
  void apply_alone(const Eigen::VectorXd& u, Eigen::VectorXd& result) const {
    apply(0, static_cast<Index>(topology_.domains.size()), u, result);
  }

 private:
  Mat3 stress(Index d, const Eigen::VectorXd& u) const;
  void apply(Index first, Index last, const Eigen::VectorXd& u, Eigen::VectorXd& result) const;

  const TopologyTextures& topology_;
  std::vector<Index> particle_;  // [D], nearer together than in the tables
  Eigen::VectorXd other_;        // what the second half of the domains adds
};

}  // namespace phymul
