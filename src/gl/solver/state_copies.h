// SPDX-License-Identifier: MIT
//
// States on their way to and from the device: rows of displacements (m) and velocities (m/s), and a ring of buffers,
// each with a fence, of copies that nobody waits for.
#pragma once

#include <phymul/state.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <vector>

#include "device.h"
#include "device/table_rows.h"
#include "gl/context/gl_api.h"
#include "gl/objects/handle.h"

namespace phymul::gl {

/// ReportCopy: the two rows of a report, and behind them what tools have felt and which volumes were lost, read from
/// the device at a time.
class ReportCopy {
 public:
  /// `fill` gives the commands that write events, largest and so many rows more, 16 bytes each, to the buffer bound to
  /// GL_PIXEL_PACK_BUFFER. Waits for them.
  template <class Fill>
  BatchReport read(std::int64_t more_rows, Fill&& fill) {
    begin(static_cast<std::size_t>(more_rows));
    fill();
    return end();
  }
  /// The rows behind, of the report last read.
  const std::vector<Float4>& more() const { return more_; }

 private:
  void begin(std::size_t more_rows);
  BatchReport end();
  GLsizeiptr bytes() const;

  Handle<BufferKind> buffer_;
  std::vector<Float4> more_;
};

/// Where the rows of particles are; empty: in the model's order.
using PlaceOf = std::span<const Index>;

/// Writes position - rest and velocity to the rows; those that are nobody's stay as they are.
void pack_state(const VecList& rest, const State& state, PlaceOf place_of, Float4* displacement, Float4* velocity);
/// Position = rest + u. Leaves state.time.
void unpack_state(const Float4* displacement, const Float4* velocity, const VecList& rest, PlaceOf place_of,
                  State& state);

/// Which of three pairs of displacements and velocities is which: a step reads the current one and writes the free
/// one, so that no pass reads what it writes; the checkpoint holds the state before the present batch.
class StatePairs {
 public:
  static constexpr int pairs = 3;

  int current() const { return current_; }
  int free_pair() const;  ///< where the next step goes; advance() makes it the current one
  void advance() { current_ = free_pair(); }
  void set_checkpoint() {
    strains_fresh_ = no_strains();
    checkpoint_ = current_;
  }
  void go_back() { current_ = checkpoint_; }

  /// True where the domains of the checkpoint have no strains but their own.
  bool strains_fresh() const { return strains_fresh_; }
  void set_strains_fresh(bool fresh) { strains_fresh_ = fresh; }
  bool no_strains() const { return strains_fresh_ && current_ == checkpoint_; }  ///< the same of the current state

 private:
  int current_ = 0, checkpoint_ = 0;
  bool strains_fresh_ = true;
};

class StateCopies {
 public:
  static constexpr std::size_t most = 3;

  StateCopies() = default;
  StateCopies(const StateCopies&) = delete;
  StateCopies& operator=(const StateCopies&) = delete;
  ~StateCopies();

  /// Starts a copy of so many rows of displacement, and as many of velocity behind them: `fill` gives the commands that
  /// write them to the buffer bound to GL_PIXEL_PACK_BUFFER. Takes the place of the newest where `most` are on their
  /// way. One number of rows for all requests.
  /// `header` has what else the state is to have: its time, and its tools.
  void request(std::size_t rows, const State& header, const std::function<void()>& fill);
  /// True where the oldest has arrived, and is then in `state`.
  bool collect(const VecList& rest, PlaceOf place_of, State& state);
  void clear();

 private:
  struct Copy {
    GLuint buffer = 0;
    GLsync fence = nullptr;
    std::size_t rows = 0;
    State header;  // without places and velocities
  };
  void drop(Copy& copy);

  std::deque<Copy> on_their_way_;
  std::vector<GLuint> spare_;  // of equal size
};

}  // namespace phymul::gl
