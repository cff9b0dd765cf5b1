// SPDX-License-Identifier: MIT
//
// States on disk, and a ring of past ones in memory to go back to.
#pragma once

#include <phymul/solver.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

namespace phymul {

/// A number for a state's bits: equal for states that are the same to the last one.
std::uint64_t fingerprint(const Snapshot& snapshot);

/// Writes a snapshot as a file, bit for bit, with magic word, version and checksums (docs/formats.md). `path` holds
/// either the whole new file or what it held before. Throws Error if the file cannot be written.
void save_state(const Snapshot& snapshot, const std::string& path);
void save_state(const Solver& solver, const std::string& path);  ///< the solver's present state

/// Back into a solver over the same tables; in the backend that wrote it the trajectory goes on bit for bit, in another
/// one within that one's precision. Throws Error, with the file, the byte, what was expected, what came and what to do,
/// where the file is damaged, cut short, of another version or of another body; the solver then keeps its state.
void load_state(Solver& solver, const std::string& path);
Snapshot read_state(const std::string& path);
/// The same from memory; `name` stands for the file in messages.
Snapshot read_state_bytes(std::string_view bytes, const std::string& name);

/// The last states of a run, no more than a number of bytes of them: memory stays the same however long it runs, the
/// oldest states make room.
class StateHistory {
 public:
  /// A state every `every` steps, at most `most_bytes` in all. Throws Error unless both are 1 or more.
  StateHistory(int every, std::size_t most_bytes);

  /// To be called after steps, with what they reported (step(0, dt) does for the start): keeps the solver's state the
  /// first time, and where `every` steps have gone by since the last one kept. States later than the report's time are
  /// of a run that was left, and go. Throws Error, and keeps what it has, for a solver of another body than the states
  /// kept: clear() first.
  void follow(const Solver& solver, const StepReport& report);

  /// The newest state at or before a time, s; null where none is so old.
  const Snapshot* newest_at(double time) const;

  /// Puts the solver there by Solver::restore(), which throws for a solver of another body, and forgets what came
  /// after. False, and nothing done, where no state is so old. Tools then hold what that state says until grasp() or
  /// release() is called anew (Solver::reset); their forces are 0 until the next step: a VirtualCoupling goes on from
  /// VirtualCoupling::reset(), at the tool's pose now.
  bool rewind(Solver& solver, double time);

  std::size_t size() const { return states_.size(); }
  std::size_t bytes() const { return bytes_; }
  void clear();

 private:
  void drop_after(double time);

  int every_;
  std::size_t most_bytes_;
  std::deque<Snapshot> states_;  // by time
  std::size_t bytes_ = 0;
  int since_ = 0;  // steps since the newest
};

}  // namespace phymul
