// SPDX-License-Identifier: MIT
//
// Snapshots in files, and a history of snapshots in memory.
#pragma once

#include <phymul/solver.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>

namespace phymul {

/// Hash of all bits of a snapshot except its topology_hash and backend, tools and joints of the scene, and reports.
std::uint64_t fingerprint(const Snapshot& snapshot);

/// Writes a snapshot as a file, bit for bit, with magic word, version and checksums (docs/guide/formats.md). `path`
/// holds either the whole new file or what it held before. Throws Error if the file cannot be written.
void save_state(const Snapshot& snapshot, const std::string& path);
void save_state(const Solver& solver, const std::string& path);  ///< the solver's present state

/// Restores a file in a solver with the same topology_hash(). In the backend that wrote it the trajectory continues bit
/// for bit. Throws Error if the file is damaged, incomplete, of another version or of another topology; the solver then
/// keeps its state.
void load_state(Solver& solver, const std::string& path);
Snapshot read_state(const std::string& path);
/// The same from memory. `name`: of the file, for messages.
Snapshot read_state_bytes(std::string_view bytes, const std::string& name);

/// The last states of a run within a limit on memory. New states replace the oldest ones.
class StateHistory {
 public:
  /// Keeps a state every `every` steps, at most `most_bytes` bytes in all. Throws Error unless both are 1 or more.
  StateHistory(int every, std::size_t most_bytes);

  /// Call it after each step() with its report (that of step(0, dt) for the start). Keeps the solver's state the first
  /// time and after every `every` steps. Removes states later than the report's time. Throws Error, and changes
  /// nothing, if the solver's topology_hash() differs from that of the kept states: clear() first.
  /// `start`: of a Simulation, Snapshot::start.
  void follow(const Solver& solver, const StepReport& report, const Snapshot::Start& start = {});

  /// The newest state at or before a time, s, or less than a thousandth of a step after it, as rounding leaves; null if
  /// there is none.
  const Snapshot* newest_at(double time) const;

  /// Restores that state in the solver (Solver::restore(), which may throw) and removes later ones. Returns false, and
  /// does nothing, if there is no such state. A VirtualCoupling is not part of it: keep a copy with each state, or call
  /// VirtualCoupling::reset() with the tool's present pose. For what tools hold see Solver::reset().
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
