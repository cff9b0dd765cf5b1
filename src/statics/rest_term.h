// SPDX-License-Identifier: MIT
//
// What acts on a body at rest besides its material and the loads: springs between particles and the world. Joints and
// tools are such terms.
//
// The tangent stiffness K = -df/dx of a body of Law::particle_averaged, as an operator.
#pragma once

#include <phymul/topology_textures.h>
#include <phymul/types.h>

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

namespace phymul {

class RestTerm {
 public:
  virtual ~RestTerm() = default;

  /// Sets to 1, in [N], the particles that the term may hold.
  virtual void mark_held(std::span<char> particles) const = 0;
  /// Adds forces at positions [N], m, to `force` [N], N.
  virtual void add_forces(std::span<const Vec3> position, std::span<Vec3> force) const = 0;
  virtual double energy(std::span<const Vec3> position) const = 0;  ///< J
  /// N^2: the sum of squares of the forces from outside the body.
  virtual double squared_support(std::span<const Vec3> position) const = 0;

  virtual void linearise(std::span<const Vec3> position) = 0;
  /// result += K d, [3 N] N and m, K as of the last linearise(), symmetric and not negative.
  virtual void add_product(const Eigen::VectorXd& d, Eigen::VectorXd& result) const = 0;
  /// Adds the blocks of the diagonal of that K to [N], N/m.
  virtual void add_diagonal(std::span<Mat3> blocks) const = 0;

  /// N^2: by how much the forces miss the law that the term approaches by raise().
  virtual double squared_miss(std::span<const Vec3>) const { return 0.0; }
  /// Takes the forces at these positions as the next estimate of those of the law; changes energy and forces.
  virtual void raise(std::span<const Vec3>) {}
  /// Those estimates, N, as many from search to search.
  virtual void append_estimates(std::vector<double>&) const {}
  /// Takes the first ones back, as near as the law allows, and returns the others.
  virtual std::span<const double> take_estimates(std::span<const double> all) { return all; }
};

using RestTerms = std::span<RestTerm* const>;

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
