// SPDX-License-Identifier: MIT
//
// One body of the sweep on every backend: rates, and what they are of the machine's ceilings.
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "sweep_cases.h"

namespace phymul::bench {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// A row of the CSV file. Not a number: not measured, or not to be had.
struct SweepRow {
  std::string variant, bases, backend, device, status = "ok";
  int particles = 0, threads = 0;  ///< threads of GL backends: 0
  double base_count = unknown;
  double seconds_a_step = unknown, least = unknown, greatest = unknown;  ///< wall clock: median of the repeats, spread
  /// Of all threads of the process, likewise. Of one thread it is what the wall clock says on a quiet machine.
  double processor_seconds_a_step = unknown, processor_least = unknown, processor_greatest = unknown;
  double device_seconds_a_step = unknown;  ///< by the device's timers, over all passes
  double multiply_share = unknown;         ///< multiplications of the triples over time, of one core's most; 1 thread
  double operation_share = unknown;  ///< the same of all their operations, where the core does multiply-adds alone
  int repeats = 0;
  std::string load;  ///< of the machine, before
};

struct SweepLimits {
  int repeats = 7;
  double sample_seconds = 0.05;  ///< a sample lasts about so long
  double seconds_a_body = 120.0;
  std::vector<std::string> backends;
  /// Seconds a step is expected to take, 0: not known. One that cannot do its repeats in its time is left out.
  std::function<double(const std::string& backend)> expected = [](const std::string&) { return 0.0; };
};

/// Calls `done` with each row. Solvers of a body are run in turns, so that other work on the machine hurts all alike.
void measure_body(const SweepVariant& variant, int size, const SweepLimits& limits,
                  const std::function<void(const SweepRow&)>& done);

}  // namespace phymul::bench
