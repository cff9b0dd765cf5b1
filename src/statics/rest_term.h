// SPDX-License-Identifier: MIT
//
// What acts on a body at rest besides its material and the loads: springs between particles and the world. Joints and
// tools are such terms.
#pragma once

#include <phymul/types.h>

#include <Eigen/Core>
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

}  // namespace phymul
