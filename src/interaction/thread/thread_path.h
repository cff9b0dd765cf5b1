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
#include "thread_tensions.h"

namespace phymul {

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
