// SPDX-License-Identifier: MIT
//
// A free thread: nodes with mass, segments with tension, quadratic bending between neighbouring segments. One linearly
// implicit Euler step of positions x and tensions T together,
//   M (dx - dx*) / dt^2 + K x + G^T T = 0,   G dx - (l / EA) dT = -(C - (l / EA) T),   C = |d| - l,
// where dx* is the way without inner forces and K has bending and what tension adds across a segment. The matrix is
// symmetric and quasi-definite, so that LDL^T in fixed order needs no pivots (R. J. Vanderbei, "Symmetric quasidefinite
// matrices", SIAM J. Optim. 5 (1995) 100-113).
#pragma once

#include <phymul/thread.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace phymul {

class ThreadRod {
 public:
  explicit ThreadRod(const SceneThread& thread);  ///< straight and at rest, at its first place

  const ThreadState& state() const { return state_; }
  void restore(const ThreadState& state) { state_ = state; }
  Index last() const { return static_cast<Index>(state_.position.size()) - 1; }

  /// Begins a step: predicts where velocity, gravity and the loads at the tips take each node.
  void begin(double dt, const Vec3& gravity);
  void load(Index node, const Vec3& force);  ///< N
  void give(Index node, const Vec3& way);    ///< m: it goes this way, whatever pulls it
  /// The node is at a place, m, of a body that would go `way`, m, by itself. `inverse_mass`: 1/kg of the body there, by
  /// axis; 0: the way is given.
  void attach(Index node, const Vec3& place, const Vec3& way, const Vec3& inverse_mass);
  void solve();  ///< by as many iterations as that takes: one, where nothing is violent
  /// What pushes a node by stiffness (to - way) besides: N/m, m.
  struct Push {
    Index node = 0;
    Mat3 stiffness = Mat3::Zero();
    Vec3 to{0, 0, 0};
    Vec3 at(const Vec3& way) const { return stiffness * (to - way); }
  };
  /// The parts of solve(); iterate() improves on the ways that are there.
  void start_newton();
  void iterate(std::span<const Push> pushes = {});
  /// A place on a segment: a share of the way from its first node to its last.
  struct Point {
    Index segment = 0;
    double share = 0.0;
    double weight(std::size_t end) const { return end == 0 ? 1.0 - share : share; }  ///< of the node at an end
  };
  /// Forces that the last iterate() left out: clear_response(), push() for each, respond(). Then response() has what
  /// they change in the way of a point, m, and add_response() adds it.
  void clear_response();
  void push(const Point& point, const Vec3& force);  ///< N
  void respond();
  Vec3 response(const Point& point) const;
  void add_response();
  Mat3 answer(const Point& point) const;      ///< m/N, about: of the way of a point to a force on it
  void touch(Index node, const Vec3& force);  ///< N, besides: of ThreadState::touch

  Vec3 way(Index node) const { return way_[node]; }  ///< m, of the last iteration
  Vec3 way(const Point& point) const {
    return point.weight(0) * way_[point.segment] + point.weight(1) * way_[point.segment + 1];
  }
  const Vec3& place(Index node) const { return place_[node]; }  ///< m, at the step's start
  bool has_settled() const;                                     ///< segments are as long as their tensions say
  bool is_broken(Index segment) const { return state_.broken[segment] != 0; }
  double segment() const { return segment_; }  ///< m
  bool is_given(Index node) const { return given_[node] != 0; }
  /// N, of the thread on what holds a tip, by tension and bending after solve().
  Vec3 force_at(ThreadTip tip) const;
  void report(ThreadTip tip, const Vec3& force) { force_[static_cast<std::size_t>(tip)] = force; }
  bool is_finite() const;  ///< what accept() would keep
  void accept();           ///< the step counts

 private:
  static constexpr int band = 8, row = band + 1;

  void assemble(std::span<const Push> pushes);
  void add_bending();
  void add_segments();
  void impose();
  void factor_and_solve();
  double& entry(std::size_t r, std::size_t c) { return matrix_[r * row + (band + c - r)]; }  // c <= r
  bool bends(std::size_t node) const { return !state_.broken[node - 1] && !state_.broken[node]; }

  double stretch_, bend_, segment_, node_mass_, damping_, breaking_force_;  // EA, EI, m, kg, 1/s, N
  double dt_ = 0.0;
  ThreadState state_;
  // Of the step: [N]
  VecList place_;                                            // m
  VecList free_way_, way_;                                   // m: dx*, dx
  VecList mass_;                                             // kg, by axis
  std::vector<std::uint8_t> given_;                          // bit a: coordinate a
  std::vector<double> tension_;                              // N [N - 1]
  std::array<Vec3, 2> force_{Vec3(0, 0, 0), Vec3(0, 0, 0)};  // N, ThreadState::force
  VecList touch_;                                            // N, ThreadState::touch
  VecList along_;                                            // [N - 1] unit vectors
  std::vector<double> matrix_, value_;  // [4 N][row], [4 N]: x, y, z of a node, then the tension after it
  std::vector<double> response_;        // [4 N], likewise
  std::size_t low_ = 0;                 // first row with a force of push()
};

}  // namespace phymul
