// SPDX-License-Identifier: MIT
//
// TaskRunner: threads of the host, lent to the library, which then starts none of its own.
#pragma once

#include <functional>

namespace phymul {

/// Derive from it and give it to SimulationOptions::runner, or to TopologyOptions::runner and SolverOptions::runner.
/// Results do not depend on it. Its functions are called by threads that call the library, by none of which it is
/// called twice at once: a runner that several solvers share, and are stepped by several threads, must allow that.
class TaskRunner {
 public:
  virtual ~TaskRunner() = default;

  /// How many parts of a task it can run side by side, the calling thread included: at least 1. Asked when tables and
  /// solvers are made.
  virtual int width() const = 0;

  /// Calls task(0), task(1), ..., task(count - 1) once each, by any threads and in any order, and returns when all have
  /// returned. 2 <= count <= width(). The calling thread may run parts. `task` does not throw. It may call none of them
  /// before the library was called, or after this function has returned or thrown. Parts that it leaves out, by an
  /// exception or otherwise, are done by the calling thread; the exception is dropped.
  virtual void run(int count, const std::function<void(int)>& task) = 0;
};

}  // namespace phymul
