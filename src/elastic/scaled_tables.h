// SPDX-License-Identifier: MIT
//
// The stiffness of a body over its masses, M^-1/2 K M^-1/2, as an operator, and Lanczos iteration with it. K = -df/dx
// by central differences of the elastic forces along a direction, or, at rest, from the tables of
// Law::particle_averaged. Source: Golub & Van Loan, Matrix Computations, ch. 10.
//
// The stiffness K = -df/dx of Law::particle_averaged at rest, where it is known without differences of forces.
//
// Tables of a body whose materials are stiffer or softer than the model says (Scene::scale_stiffness).
#pragma once

#include <phymul/elasticity.h>
#include <phymul/topology_textures.h>

#include <Eigen/Core>
#include <optional>
#include <span>
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

/// Eigenvalues nearer to 0 than this share of the largest are those of rigid motion, on either side of 0 by rounding.
inline constexpr double rigid_motion = 1e-6;

/// Ritz values are taken when their residuals are below this share of the largest; eigenvalues are then nearer than
/// that.
inline constexpr double ritz_accuracy = 1e-3;

/// Free coordinates only. Keeps references to what it is made from.
class ScaledStiffness {
 public:
  ScaledStiffness(const TopologyTextures& topology, std::span<const Vec3> position,
                  std::span<const std::uint8_t> fixed);

  double spacing() const { return spacing_; }  ///< m, mean between neighbours
  /// Of unit length, the same on every machine, without the coordinates that are fixed; zero where all are.
  Eigen::VectorXd start_vector() const;
  void apply(const Eigen::VectorXd& q, Eigen::VectorXd& result);

 private:
  struct Side {
    VecList moved, force;
    void resize(std::size_t count) {
      moved.resize(count);
      force.resize(count);
    }
  };

  void apply_differences(const Eigen::VectorXd& direction, Eigen::VectorXd& result);
  void force_at(const Eigen::VectorXd& direction, double step, Side& side) const;

  const TopologyTextures& topology_;
  std::span<const Vec3> position_;
  double spacing_;
  Eigen::VectorXd scale_;
  std::optional<AveragedStiffness> at_rest_;
  Side plus_, minus_;  // empty where at_rest_ serves
};

/// What Lanczos iteration found.
struct Lanczos {
  Spectrum spectrum;  ///< `largest` and `most_negative`; `largest` infinite where it overflows
  std::vector<double> diagonal, off;
  Eigen::VectorXd top;  ///< of the eigenvector of the largest: coefficients of the vectors of the iteration
};
Lanczos lanczos(ScaledStiffness& A, const Eigen::VectorXd& start);

/// The eigenvector of the largest eigenvalue, of unit length: the vectors of the iteration made again and summed.
Eigen::VectorXd fastest_vibration(ScaledStiffness& A, const Eigen::VectorXd& start, const Lanczos& found);

class ScaledTables {
 public:
  /// The tables with all stiffnesses of each material times its factor [materials]; without factors the tables
  /// themselves. Valid until the next call. Copies the tables where it does so for the first time or after edits, and
  /// is to be given the same ones from then on.
  const TopologyTextures& of(const TopologyTextures& topology, std::span<const double> factors);

 private:
  std::optional<TopologyTextures> scaled_;
  std::vector<double> factors_;  // that scaled_ has
};

}  // namespace phymul
