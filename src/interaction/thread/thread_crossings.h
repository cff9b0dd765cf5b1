// SPDX-License-Identifier: MIT
//
// Free threads that touch themselves and each other (Thread::touches). Where two segments are nearer to each other than
// the sum of their radii, a force acts on one and its opposite on the other, each split between its two nodes. These
// forces couple nodes that are far from each other in the band. So each iteration of the rods first leaves them out;
// then an accelerated projected gradient method finds them, with Coulomb's law (H. Mazhar, T. Heyn, D. Negrut,
// A. Tasora, "Using Nesterov's method to accelerate multibody dynamics with friction and contact", ACM Trans. Graph. 34
// (2015) 32). A sweep costs one solution with the factored bands, and the step has at most so many sweeps: so its cost
// grows as nodes and places together.
//
// Two segments keep the side on which they were at the step's start: of the points that are closest at its end, the
// vector between them must not have turned round. Nothing is kept from step to step.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "thread_rod.h"

namespace phymul {

class ThreadCrossings {
 public:
  struct Strand {
    ThreadRod* rod = nullptr;
    double radius = 0.0, friction = 0.0, stiffest = 0.0;  // m, Coulomb's, N/m
  };
  /// Before a step of dt, s: start(), add() for each, give() for nodes of the strand that was added last, find().
  void start(double dt);
  void add(const Strand& strand, double surprise);  ///< m: how far a node may go otherwise than by its speed
  void give(Index node, const Vec3& way);           ///< m: it goes this way, and draws those that are near with it
  void find();                                      ///< which segments may touch in the step, from ThreadRod::state()

  /// Of the strands that are to be solved with this one the first.
  std::size_t first_of(std::size_t strand) const { return group_[strand]; }
  /// The group that begins with a strand; its rods have begun the step. Then in each round: update(),
  /// ThreadRod::iterate() of all, couple().
  void begin(std::size_t first);
  bool update();  ///< what touches after the last iteration, and how. False: as before it
  void couple();
  /// Whether a node is where threads touch in the step, so that they may have pressed it in the step before.
  bool presses(std::size_t strand, Index node) const { return pressed_[first_node(strand) + node] != 0; }
  void give_forces() const;  ///< ThreadRod::touch()

 private:
  using Box = Eigen::AlignedBox<double, 3>;  // m
  /// Neighbouring segments.
  struct Run {
    std::size_t strand = 0;
    Index first = 0, end = 0;
    Box box;
  };
  struct Pair {
    std::array<std::size_t, 2> strand{};
    std::array<Index, 2> segment{};  // of the same strand: the second one is behind the first
  };
  struct Cross {
    std::size_t pair = 0;
    int place = 0;  // 0: where they are nearest; 1, 2: ends of what they share, if they lie along each other
    std::array<ThreadRod*, 2> rod{};
    std::array<ThreadRod::Point, 2> at{};
    double least = 0.0;             // m, the sum of radii
    Vec3 normal{0, 0, 0};           // from the second to the first
    double need = 0.0;              // m, of the first one's way against the second, along the normal
    double missing = 0.0;           // m, after the last iteration; below 0: they are farther apart than they must be
    double compliance = 0.0;        // m/N
    double friction = 0.0;          // Coulomb's
    Vec3 force{0, 0, 0};            // N, on the first
    Mat3 frame = Mat3::Identity();  // columns: the normal, and axes across it along which the answer is diagonal
    Vec3 answer{0, 0, 0};           // m/N, by these axes: of the way to a force here alone
  };

  std::size_t first_node(std::size_t strand) const { return from_[strand] + strand; }
  bool is_neighbour(const Strand& strand, Index first, Index second) const;
  void find_boxes();
  void find_pairs(const Run& one, const Run& other);
  std::size_t root_of(std::size_t strand) const;
  void measure(std::size_t pair, std::vector<Cross>& found) const;
  bool has_before(const Pair& pair, std::size_t side) const;
  template <class Each>
  void each_rod(Each each) const;
  void find_frames();
  void respond(const VecList& forces, VecList& open);
  void find_forces();

  double dt_ = 0.0;  // s
  std::vector<Strand> strands_;
  std::vector<std::size_t> from_, group_;  // [strands]: first segment in boxes_; strand
  // Of nodes of all strands: m, their way by their speed, and how far they may go besides.
  VecList going_;
  std::vector<double> surprise_;
  std::vector<std::uint8_t> pressed_;
  std::vector<Box> boxes_;  // of segments of all strands: where they may be in the step
  std::vector<Run> runs_;   // along x
  std::vector<Pair> near_;  // of the step, by group
  // Of the group at hand.
  std::size_t first_ = 0, begin_ = 0, end_ = 0;  // its first strand; in near_
  std::vector<Cross> crosses_, before_;          // of this round and the one before
  bool is_coupled_ = false;                      // couple() has used crosses_, else before_
  double met_ = 0.0;                             // of the sum of radii, by which segments may still be too near
  double steepest_ = 1.0;  // of the answer to forces at all places, by each place's own: no more than that
  // [crosses_], by their axes. open: m, the way beyond the one that is needed, with compliance.
  VecList free_, force_, open_, ahead_, open_ahead_, next_, open_next_;  // of no force; N, m
};

}  // namespace phymul
