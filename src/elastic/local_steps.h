// SPDX-License-Identifier: MIT
//
// Local time steps (SolverOptions::max_substeps). Parts with small cells: fine_parts.h. Materials that need a shorter
// step than the others are advanced by substeps within each step, while the forces of the others stay as they are at
// its start:
//
// From x, with all forces f(x) and the stiffness K of the stiff materials at rest, turned as they are turned now, a
// step of Verlet's scheme takes the mean acceleration a = sum_k share_k a_k of
//   w_0 = w_-1 = 0,  m a_k = f(x) - K w_k,  w_k+1 = w_k + keep_k (w_k - w_k-1) + kick_k dt^2 a_k.
// The shares sum to 1 and K w sums to 0 over the particles, so linear momentum is conserved; where f is 0 all w are, so
// rest shapes are the same. w_p is a Chebyshev polynomial of dt^2 K / m, damped so far that a = Q f / m with Q between
// 0 and 1: the scheme is Verlet's with a larger mass for the vibrations of the stiff materials, so that small ones have
// no resonances. Imposed motions are imposed in the substeps too. Sources: Diaz and Grote, Energy conserving explicit
// local time stepping for second-order wave equations, SIAM J. Sci. Comput. 31, 2009; Grote, Michel and Sauter,
// Stabilized leapfrog based local time-stepping method for the wave equation, Math. Comp. 90, 2021. There K is the
// exact stiffness; here it is that at rest, because substeps with the forces themselves are no gradient, and undamped
// bodies gained energy.
#pragma once

#include <phymul/elasticity.h>
#include <phymul/state.h>

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "fine_parts.h"
#include "material_spectra.h"

namespace phymul {

/// One substep, as above.
struct Substep {
  double keep = 0.0, kick = 0.0, share = 1.0;
};
/// The coefficients of `count` >= 1 substeps.
std::vector<Substep> substeps_of(int count);
/// Largest dt^2 lambda that `count` substeps take, lambda the largest eigenvalue of K / m; 4 for one.
double substep_limit(int count);

/// T_p at the start of the polynomial: it is bounded by the inverse. For linear bodies 1.1 suffices; with less than 2
/// an undamped body bent by 2 % of its length gained energy (docs/decisions/2026-11-25-local-time-steps.md).
inline constexpr double polynomial_start = 2.5;
/// Of dt^2 Q K / m: stiff vibrations reach it in short steps too. The whole scheme's is at most this and, to be 4 at
/// the limit, (1 - most_of_substeps / 4) dt^2 LocalSteps::rate: measured on 136 random bodies.
inline constexpr double most_of_substeps = 2.0 * (1.0 + 1.0 / polynomial_start);

struct LocalSteps {
  PartOfBody stiff;               ///< without particles if no material has substeps
  FineParts fine;                 ///< of other particles, rows of the body
  std::vector<Index> particle;    ///< rows of the body: those of `stiff`, then of `fine`
  VecList rest;                   ///< m, by `particle`
  std::vector<double> mass;       ///< kg, likewise
  std::vector<bool> chosen;       ///< by row of Model::materials: in `stiff`
  std::vector<Substep> substeps;  ///< two or more; none if no material has them
  double share = 0.0;             ///< of all domains that are in `stiff`
  double soft_rate = 0.0;      ///< 1/s^2, largest eigenvalue of the others' stiffness over the masses, `fine` included
  double stiff_rate = 0.0;     ///< 1/s^2, of K / m
  double margin = 1.0;         ///< >= 1: the whole scheme's dt^2 lambda over that of its parts
  double margin_beside = 1.0;  ///< that where the others' factor is larger than that of `stiff`

  /// 1/s^2: a step is stable up to dt^2 times this = 4. `factors`: Scene::stiffness_factors.
  double rate(std::span<const double> factors = {}) const;
  /// The largest of the factors of `chosen`, by which K grows.
  double factor(std::span<const double> factors) const;
};

/// 1/s^2: the largest eigenvalue of the whole scheme at the step that its parts promise (LocalSteps::rate). The
/// scheme's operator is B = Q K over the masses, with the Q of fine parts and the polynomial Q(K_stiff) of the
/// substeps. Lanczos iteration finds its largest eigenvalue as that of K Q, which is symmetric in the inner product
/// x . Q y.
double largest_rate(const TopologyTextures& topology, const LocalSteps& steps);

/// The materials, the number of substeps, at most `most`, and the fine parts with which a second of physics costs
/// least. `whole`: of the body. Null if one step for all is about as cheap.
std::unique_ptr<const LocalSteps> choose_local_steps(const TopologyTextures& topology, const Spectrum& whole, int most);

/// What local steps change of the forces of a step. Rows are those of LocalSteps::particle.
class LocalForces {
 public:
  /// A particle of LocalSteps::stiff whose motion is imposed; of its accelerations `free` a is left.
  struct Held {
    std::size_t row;
    Mat3 free;
  };
  /// The substeps of LocalSteps::stiff in the coordinates of rest: to the sum of -share_k factor K w_k, [n] N, from f /
  /// m, [n] m/s^2.
  using Loop = std::function<void(std::span<const Vec3> still, std::span<const Held> held, double dt, double factor,
                                  std::span<Vec3> sum)>;

  /// Keeps a reference. Without `loop` it is run in double precision.
  explicit LocalForces(const LocalSteps& steps, Loop loop = {});

  /// [n] as LoadFrame::fixed, to be set before changes(); 7 for what tools hold, too. What is imposed is so in the
  /// substeps: else the forces on what is left are no longer the slope of an energy, and grow.
  std::span<std::int32_t> imposed() { return imposed_; }
  /// `x` [n] m; `acceleration` [n] m/s^2: by all forces but those of tools and contacts;
  /// `dt`, s; `factor`: LocalSteps::factor. Returns [n] N, to be added to the elastic forces; valid until the next
  /// call. Of the particles of LocalSteps::stiff alone if n is their number.
  std::span<const Vec3> changes(std::span<const Vec3> x, std::span<const Vec3> acceleration, double dt, double factor);

  /// [n] N, of tools and contacts in this step, all of them, which act in the next one: at rest they are the same. A
  /// step that does not ask has none.
  std::span<Vec3> pushes() {
    next_pushed_ = true;
    return next_pushes_;
  }
  void accept() {  ///< the step counts
    pushes_.swap(next_pushes_);
    pushed_ = std::exchange(next_pushed_, false);
    if (!pushed_) return;
    for (std::size_t i = 0; i < imposed_.size(); ++i) {  // what holds a particle does not act once it lets go
      for (int axis = 0; axis < 3; ++axis) {
        if ((imposed_[i] >> axis & 1) != 0) pushes_[i][axis] = 0.0;
      }
    }
  }
  void drop() { next_pushed_ = false; }  ///< it does not
  /// [n] N, those of the step before; empty: none.
  std::span<const Vec3> acting() const { return pushed_ ? std::span<const Vec3>(pushes_) : std::span<const Vec3>(); }
  void reset(const VecList& pushes = {});  ///< those of acting()
  /// Adds the pushes, if there are any, as a part of the snapshot, and finds them there. pushes_of() throws Error if
  /// the part is of another body or not finite.
  void put(Snapshot& snapshot) const;
  static bool has(const Snapshot& snapshot);
  VecList pushes_of(const Snapshot& snapshot) const;

 private:
  /// Particles that hang together, and turn as one.
  struct Piece {
    double mass = 0.0;         // kg
    Vec3 centre{0, 0, 0};      // m, at rest
    Mat3 turn = Mat3::Zero();  // sum of m (x - centre) (rest - centre)^T, then the rotation nearest to it
    Vec3 now{0, 0, 0};         // m, centre of mass
  };
  void turn_pieces(std::span<const Vec3> x);
  void find_held();

  const LocalSteps& steps_;
  Loop loop_;
  std::vector<Piece> pieces_;
  std::vector<std::size_t> piece_of_;  // [n]
  std::vector<std::int32_t> imposed_;  // [n]
  std::vector<Held> held_;
  VecList still_, change_, nodes_, pushes_, next_pushes_;
  bool pushed_ = false, next_pushed_ = false;
};

}  // namespace phymul
