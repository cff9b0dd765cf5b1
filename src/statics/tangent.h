// SPDX-License-Identifier: MIT
//
// The tangent stiffness K = -df/dx of a body of Law::particle_averaged, as an operator.
#pragma once

#include <phymul/topology_textures.h>

#include <Eigen/Core>
#include <memory>
#include <span>

namespace phymul {

class Tangent {
 public:
  virtual ~Tangent() = default;
  /// Linearises about a state: [domains] mean displacement gradients H = F - I; none: rest, as in the beginning.
  virtual void linearise(std::span<const Mat3> gradients) = 0;
  /// result = K d, [3 N], m and N; to single precision, relative to the largest numbers around a particle.
  virtual void apply(const Eigen::VectorXd& d, Eigen::VectorXd& result) = 0;
  /// The same, both [N]; the largest numbers should be near 1. Fourth numbers of 0 stay 0.
  virtual void apply(std::span<const Eigen::Vector4f> d, std::span<Eigen::Vector4f> result) = 0;
};

/// By the vector kernels of the backend "cpu" (src/cpu/packed/packed_tangent.cpp), on one thread. `topology` must
/// outlive the result. Throws Error for tables beyond the range of single precision.
std::unique_ptr<Tangent> make_tangent(const TopologyTextures& topology);

}  // namespace phymul
