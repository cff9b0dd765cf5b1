// SPDX-License-Identifier: MIT
//
// What searches for rest need of a body of which certain coordinates are imposed, whatever its state, loads and terms
// are: its forces, and tangent, grids and paths, which take longer to make than a search takes. Rigid motions of bodies
// that nothing resists and nothing drives. Without stress in the body the tangent resists none of them, and in the
// search for its rest rounding would move it along them by many times its deformation.
#pragma once

#include <phymul/bodies.h>
#include <phymul/load_frame.h>
#include <phymul/topology_textures.h>
#include <phymul/types.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "grid_level.h"
#include "multigrid.h"
#include "rest_term.h"

namespace phymul {

/// A curved path through the states of a body in place of a straight one. Where parts of a body turn, as in bending, a
/// straight step along the linear solution stretches them. Here each domain turns by the rotation that the solution
/// asks of it, and is strained by the rest of it; the displacement that fits these gradients best is found on a grid
/// (modal warping: M. Choi and H. Ko, IEEE Trans. Vis. Comput. Graph. 11 (2005) 91-101; rotation-strain coordinates:
/// J. Huang et al., Proc. SCA 2011, 37-45).
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

/// Where a search for rest may begin after others of the same body: what the last ones changed is combined so that it
/// would end the most of the forces that are there now (P. F. Fischer, Comput. Methods Appl. Mech. Eng. 163 (1998)
/// 193-204, for linear systems).
class RestChanges {
 public:
  /// A search changed what it sought by `way` and ended the force `force`, N. Forgets changes of ways of another
  /// size, as with other tools.
  void add(const Eigen::VectorXd& way, const Eigen::VectorXd& force);
  void clear() { changes_.clear(); }
  /// To `way` what would end the most of `lacks`, N; false if nothing would.
  bool find(const Eigen::VectorXd& lacks, Eigen::VectorXd& way) const;

 private:
  struct Change {
    Eigen::VectorXd way, force;
  };
  std::vector<Change> changes_;  // the newest first
};

/// Refers to the tables, which must not change.
class RestBody {
 public:
  /// `fixed`: as LoadFrame::fixed. Throws Error for tables beyond the range of single precision.
  RestBody(const TopologyTextures& topology, std::span<const std::uint8_t> fixed);
  RestBody(const RestBody&) = delete;
  RestBody& operator=(const RestBody&) = delete;

  std::span<const Mat3> diagonal() const { return diagonal_; }  ///< [N] N/m, diagonal_at_rest()

  /// Adds elastic forces at x, [N] m, to `force`, [N] N; and the mean gradients there, of all domains.
  void add_forces(const VecList& x, std::span<Vec3> force, std::vector<Mat3>& gradients);
  /// Mean gradients of a displacement, [3 N] m.
  void find_gradients(const Eigen::VectorXd& displacement, std::vector<Mat3>& gradients);

 private:
  friend class RestSearch;
  const TopologyTextures& topology_;
  std::vector<Mat3> diagonal_;
  std::unique_ptr<Tangent> tangent_;
  Multigrid grid_;
  TurningPath path_;
  VecList of_domains_;  // displacements of their particles, side by side: sums over neighbours read them many times

  // Of searches that predict:
  RestChanges changes_;
  std::vector<Mat3> turned_at_;  // mean gradients that grid_ is turned to; empty: to none
};

/// N, on particle i of so much mass, kg.
inline Vec3 load_on(std::span<const double> mass, const LoadFrame& loads, std::size_t i) {
  const Vec3 weight = mass[i] * loads.gravity;
  return loads.force.empty() ? weight : Vec3(weight + loads.force[i]);
}

/// J: elastic, less the work of the loads from the rest shape on.
double potential_energy(const TopologyTextures& topology, const LoadFrame& loads, RestTerms terms,
                        const VecList& position);

/// Displaces a particle at x by shift + turn x (x - centre), about 1 at most.
struct RigidMotion {
  Vec3 centre{0, 0, 0};                ///< m
  Vec3 shift{0, 0, 0}, turn{0, 0, 0};  ///< of length 1 together, if lengths are in sizes of the body

  Vec3 at(const Vec3& x) const { return shift + turn.cross(x - centre); }
};

/// The rigid motions of these particles at `position`, [N] m, that displace none along an imposed coordinate: at most
/// six, linearly independent. `fixed` [N]: as LoadFrame::fixed; may be empty.
std::vector<RigidMotion> free_motions(std::span<const Index> particles, std::span<const Vec3> position,
                                      std::span<const std::uint8_t> fixed);

class IdleMotions {
 public:
  /// `loose`: the bodies that have free_motions(). Keeps references.
  IdleMotions(std::span<const ConnectedBody> loose, const LoadFrame& loads, RestTerms terms)
      : loose_(loose), loads_(loads), terms_(terms) {}

  /// Those at `position`, [N] m, where the terms are linearised. `free` [3 N]: 1, or 0 where a coordinate is imposed.
  /// `residual` [3 N], N: its part along an idle motion is at most `idle`.
  void find(std::span<const Vec3> position, const Eigen::VectorXd& free, const Eigen::VectorXd& residual, double idle);
  void remove(Eigen::VectorXd& v) const;  ///< their part of v, [3 N]

 private:
  struct OfBody {
    std::span<const Index> particles;
    Eigen::MatrixXd along;  // [3 particles, motions], orthonormal
  };
  Eigen::MatrixXd unresisted(const ConnectedBody& body, std::span<const Vec3> position,
                             const Eigen::VectorXd& free) const;

  std::span<const ConnectedBody> loose_;
  const LoadFrame& loads_;
  RestTerms terms_;
  std::vector<OfBody> idle_;
};

}  // namespace phymul
