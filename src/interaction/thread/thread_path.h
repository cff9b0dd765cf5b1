// SPDX-License-Identifier: MIT
//
// A sewn thread: points (a tip, the passages, the other tip) joined by straight segments without mass. It says where
// they are in a step and what may slide; ThreadTensions finds the tensions; then it pulls at the particles, moves rest
// length along and notes what broke.
#pragma once

#include <phymul/thread.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "interaction/predicted_step.h"

namespace phymul {

// The tensions of sewn threads whose passages share particles, in one step: those with which the points end where the
// threads let them, to first order,
//   C - (dt^2 G W G^T + l / EA) T = 0,   C = |d| - l at the predicted places,
// W: inverse masses of the points, each a weighted mean of particles, shared particles included. One thread after the
// other would leave each a little off and correct that in the next step, which adds energy. An active set has for each
// bend whether the thread sticks or slides there, with T_next = T exp(mu theta) + F toward the pull, and which pieces
// are slack. Sliding bends join pieces to groups with one unknown.

/// A straight piece of thread between two points: a segment, or what a knot holds.
struct ThreadPiece {
  std::size_t a = 0, b = 0;  // points
  double rest = 0.0;         // m
  double compliance = 0.0;   // m/N
  double given = -1.0;       // N: its tension; below 0: unknown
  double most = HUGE_VAL;    // N: what a knot holds
  Vec3 along{0, 0, 0};
  double longer = 0.0;  // m: C
  // Results:
  double tension = 0.0;  // N
  double lacks = 0.0;    // m of rest length, with these tensions
};

/// Between a segment and the next.
struct ThreadBend {
  std::int8_t slides = 0;  // as ThreadState::slides
  bool locked = true;      // it may not
  double growth = 1.0;     // exp(mu theta)
  double channel = 0.0;    // N: F
};

/// One past the last of the segments from `first` on that sliding bends join. `slides(k)`: at the bend after segment k.
template <class Slides>
std::size_t end_of_group(std::size_t first, std::size_t segments, const Slides& slides) {
  std::size_t end = first + 1;
  while (end < segments && slides(end - 1)) ++end;
  return end;
}

/// The first piece of a group whose tension is given; `end`: none.
inline std::size_t given_in(const std::vector<ThreadPiece>& pieces, std::size_t first, std::size_t end) {
  std::size_t k = first;
  while (k < end && pieces[k].given < 0.0) ++k;
  return k;
}

/// 1/kg, by axis: velocity of one anchor's mean under an impulse on the other's. 0 unless they share particles that no
/// tool holds.
Vec3 mobility_between(TouchedParticles& touched, const Anchor& a, const Anchor& b);

/// For one set of threads, of one scene as it is: inverse masses of points are found once, and when tools hold others.
class ThreadTensions {
 public:
  void clear();

  std::vector<const Anchor*> points;  ///< null: in no body
  std::vector<ThreadPiece> pieces;    ///< segments, chain after chain, then knots
  std::vector<ThreadBend> bends;      ///< [segments - 1]; locked between chains

  void solve(TouchedParticles& touched);

 private:
  static constexpr std::size_t no_unknown = SIZE_MAX;
  /// Of the group it is in: tension = factor * unknown + offset.
  struct Part {
    bool slack = false;
    std::size_t unknown = no_unknown;
    double factor = 0.0, offset = 0.0;
  };

  void find_couplings(TouchedParticles& touched);
  double between(const ThreadPiece& a, const ThreadPiece& b) const;  // 1/kg
  std::size_t segments() const { return bends.size() + 1; }
  std::size_t end_from(std::size_t first) const;
  std::size_t first_of_group(std::size_t piece) const;
  void join_groups();
  void find_tensions();
  bool changes_slack();
  bool changes_knots();
  bool stops_sliding();
  bool starts_sliding();

  std::vector<Part> parts_;             // [pieces]
  std::vector<const Anchor*> known_;    // points whose couplings are known
  std::vector<std::uint8_t> held_;      // of their particles: Touched::held
  VecList coupling_;                    // [points][points] 1/kg, by axis
  std::vector<double> stiffness_;       // [pieces][pieces] m/N: dt^2 G W G^T + l / EA
  std::vector<double> matrix_, value_;  // of the unknowns
  std::size_t unknowns_ = 0;
};

/// Whether none of its particles was removed. `mass`: of all particles, kg.
bool has_tissue(const Anchor& anchor, std::span<const double> mass);

class ThreadPath {
 public:
  explicit ThreadPath(const SceneThread& thread);

  const ThreadState& state() const { return state_; }
  void restore(const ThreadState& state);  ///< of a thread that was just made
  /// Takes over what holds the thread. Passages of removed particles let go.
  void follow(const ThreadControl& control, std::span<const double> mass);
  std::vector<Index> particles() const;  ///< that it may pull, some more than once

  /// A tip that is anchored outside the body: where, m, at the start and the end of the step.
  struct Outside {
    Vec3 start{0, 0, 0}, end{0, 0, 0};
    bool is_loose = false;  // the tail has no tension
  };
  /// A new passage at `place`, m, behind all others; the last tip is at `tip`.
  void append(const Anchor& anchor, const Vec3& place, const Vec3& tip);
  /// Begins a step, where the particles would go by themselves. `steps_left`: of the call.
  void begin(TouchedParticles& touched, const std::array<Outside, 2>& tips, int steps_left);
  void put_segments(ThreadTensions& all);
  void put_knots(ThreadTensions& all);  ///< after the segments of all threads
  void take(TouchedParticles& touched, const ThreadTensions& all);
  /// N, of the last take(), on what a tip is anchored to.
  const Vec3& force_at(ThreadTip tip) const { return next_.force[static_cast<std::size_t>(tip)]; }
  bool is_finite() const;  ///< what accept() would keep
  void accept() {
    state_ = next_;
    before_.reset();
  }
  bool drop();  ///< the step does not count; true where append() is undone

 private:
  bool is_anchored(std::size_t tip) const { return control_.ends[tip].hold == TipHold::anchored; }
  bool is_clamped(std::size_t tip) const { return control_.ends[tip].hold == TipHold::clamped; }
  bool is_free_row(Index row) const;
  std::size_t point_of(Index row) const;  // of SceneThread::passages; 0: the thread no longer goes through it
  Vec3 place(TouchedParticles& touched, std::size_t point, bool end) const;
  void set_first_lengths();
  void draw(std::size_t tip, int steps_left);
  void loosen(std::size_t tip);
  void take_from_tails(double length);
  void give_to_tails(double length);
  void take_over_knots();
  template <class Is>
  void drop_knots(const Is& is);
  void tie_again(const std::vector<Knot>& knots);
  void list_pieces(const std::array<Outside, 2>& tips);
  void push(TouchedParticles& touched);
  void move_rest_length();
  void note_events();
  std::size_t passage_left() const;
  void remove(std::size_t passage);

  Thread thread_;
  double stretch_;
  std::vector<Anchor> passages_;
  bool known_ = false;  // control_ is the scene's
  ThreadControl control_;
  ThreadState state_, next_;
  std::optional<ThreadState> before_;  // the first append() of the step
  // Of the step. Points are 0 ... segments; passage p is point p + 1, between pieces p and p + 1.
  std::vector<const Anchor*> anchors_;  // [points] of particles; null: none
  VecList start_, place_, force_;       // [points] m, at the start and predicted for the end; N
  std::vector<ThreadPiece> pieces_;     // segments, then knots
  std::vector<std::uint8_t> locked_;    // [passages]
  std::vector<double> holding_;         // [passages] N, of clamps
  std::size_t first_point_ = 0, first_piece_ = 0, first_knot_ = 0;  // in ThreadTensions
};

}  // namespace phymul
