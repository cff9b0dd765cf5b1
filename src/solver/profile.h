// SPDX-License-Identifier: MIT
//
// Profile: where a backend writes what its passes cost. There is none unless SolverOptions::profile asks for one, and
// what takes a pointer to one then asks no clock.
#pragma once

#include <phymul/backend.h>

#include <chrono>
#include <string_view>
#include <vector>

namespace phymul {

class Profile {
 public:
  /// The row of a name, made at the first call. Rows stay where they are for ever.
  int row(std::string_view name);
  void add(int row, double seconds, int runs);
  void add_device(int row, double seconds);
  void lose_device(int row);  ///< a time of the device was disturbed: the row has none until clear()

  std::vector<PassProfile> rows() const;  ///< those that ran, in the order they first did
  void clear();

 private:
  struct Row {
    PassProfile sums;
    std::int64_t first_run = 0;  // place in the order; 0: has not run
    bool device = false, disturbed = false;
  };
  std::vector<Row> rows_;
  std::int64_t order_ = 0;
};

/// Takes the time from one lap to the next on one thread.
class Laps {
 public:
  explicit Laps(Profile* profile) : profile_(profile) {
    if (profile_) last_ = Clock::now();
  }
  /// The time since the last lap, or since this was made, goes to the row.
  void end(int row, int runs = 1) {
    if (!profile_) return;
    const Clock::time_point now = Clock::now();
    profile_->add(row, std::chrono::duration<double>(now - last_).count(), runs);
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Profile* profile_;
  Clock::time_point last_;
};

}  // namespace phymul
