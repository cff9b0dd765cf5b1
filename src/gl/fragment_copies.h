// SPDX-License-Identifier: MIT
//
// Copies of the state on their way to the host: a ring of pixel buffers, each with a fence. Nothing here waits.
#pragma once

#include <phymul/state.h>

#include <deque>

#include "gl/fragment_state.h"

namespace phymul::gl {

class FragmentCopies {
 public:
  static constexpr std::size_t most = 3;

  FragmentCopies() = default;
  FragmentCopies(const FragmentCopies&) = delete;
  FragmentCopies& operator=(const FragmentCopies&) = delete;
  ~FragmentCopies();

  /// Starts a copy; takes the place of the newest where `most` are on their way.
  void request(const FragmentState& state, double time);
  /// True where the oldest has arrived, and is then in `state`.
  bool collect(const VecList& rest, State& state);
  void clear();

 private:
  struct Copy {
    GLuint buffer = 0;
    GLsync fence = nullptr;
    std::size_t bytes = 0;  // of displacements; velocities follow
    double time = 0.0;
  };
  void drop(Copy& copy);

  std::deque<Copy> on_their_way_;
  std::vector<GLuint> spare_;  // of equal size
};

}  // namespace phymul::gl
