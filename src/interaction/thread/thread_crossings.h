// SPDX-License-Identifier: MIT
//
// Free threads that touch themselves and each other (Thread::touches). Where two segments are nearer to each other than
// the sum of their radii, a force acts on one and its opposite on the other, each split between its two nodes. These
// forces couple nodes that are far from each other in the band. So each iteration of the rods first leaves them out;
// how the ways at all such places answer to all forces follows from the factored bands, and the forces from sweeps over
// this small dense system, with Coulomb's law. This is the same iteration as with the forces in the matrix (M. A.
// Woodbury, "Inverting modified matrices", 1950).
//
// Two segments keep the side on which they were at the step's start: of the points that are closest at its end, the
// vector between them must not have turned round.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "thread_rod.h"

namespace phymul {

class ThreadCrossings {
 public:
  struct Strand {
    ThreadRod* rod = nullptr;
    double radius = 0.0, friction = 0.0, stiffest = 0.0;  // m, Coulomb's, N/m
    double dt = 0.0;                                      // s
    double surprise = 0.0;  // m: how far a node may go in the step otherwise than by its speed
  };
  void forget() { then_.clear(); }  ///< strands or places changed otherwise than step by step

  /// Before a step: which strands may touch in it, from ThreadRod::state(). Returns groups of rows of `strands`; a
  /// strand that touches no other one is a group by itself.
  const std::vector<std::vector<std::size_t>>& find(std::vector<Strand> strands);

  std::size_t strand_of(const ThreadRod& rod) const;

  /// The group that a strand is of; its rods have begun the step. Then in each round: update(), ThreadRod::iterate() of
  /// all, couple().
  void begin(std::size_t strand);
  bool update();  ///< what touches after the last iteration, and how. False: as before it
  void couple();
  bool empty() const { return crosses_.empty(); }
  /// Adds what pushes the nodes of a strand, N [N]. False: nothing does.
  bool add_forces(std::size_t strand, VecList& forces) const;

 private:
  struct Pair {
    std::array<std::size_t, 2> strand{};
    std::array<Index, 2> segment{};  // of the same strand: the second one is behind the first
    std::size_t group = 0;
  };
  struct Cross {
    std::size_t pair = 0;
    int place = 0;  // of two segments that lie along each other: either end of what they share
    std::array<double, 2> share{};
    Vec3 normal{0, 0, 0};     // from the second to the first
    double need = 0.0;        // m, of the first one's way against the second, along the normal
    double missing = 0.0;     // m, after the last iteration; below 0: they are farther apart than they must be
    double compliance = 0.0;  // m/N
    double friction = 0.0;    // Coulomb's
    Vec3 force{0, 0, 0};      // N, on the first
  };
  struct Column {
    std::size_t strand = 0;
    VecList response;  // ThreadRod::respond()
  };

  bool is_neighbour(const Strand& strand, Index first, Index second) const;
  bool knows_near(double reach) const;
  void find_places();
  bool is_within(std::size_t a, std::size_t b, double reach) const;
  void find_near(double reach);
  void find_groups();
  void measure(std::size_t pair, std::vector<Cross>& found) const;
  bool has_before(const Pair& pair, std::size_t side) const;
  Vec3 way(const Cross& cross) const;
  void find_forces();

  std::vector<Strand> strands_;
  std::vector<Pair> listed_, near_;  // since the last find_near(); of the step, by group
  std::vector<std::vector<std::size_t>> groups_;
  std::size_t first_ = 0, end_ = 0;             // of the group in near_
  std::vector<Cross> crosses_, before_;         // of this round and the one before
  std::vector<std::array<Column, 2>> columns_;  // [crosses_]; the second one is not used where a strand touches itself
  std::vector<Mat3> answers_;  // m/N [crosses_][crosses_]: how the way at the first answers to the force at the second
  VecList ways_;               // m [crosses_]: of the first against the second
  VecList middle_, going_;     // m, of segments of all strands: where they are, and their way by their speed
  std::vector<double> half_, room_;  // m, of each: half its length, and what it may go besides with its radius
  std::vector<std::size_t> from_;    // [strands]: first segment in middle_
  // Of the last find_near().
  VecList then_;                   // m: middle_
  std::vector<double> then_half_;  // m: half_
  double reach_ = 0.0;             // m
};

}  // namespace phymul
