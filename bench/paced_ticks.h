// SPDX-License-Identifier: MIT
//
// Work at a rate of the wall clock, and how late it was done.
#pragma once

#include <algorithm>
#include <chrono>
#include <thread>
#include <vector>

#include "haptic_scene.h"

namespace phymul::bench {

using Clock = std::chrono::steady_clock;

struct Times {
  std::vector<double> seconds{};  // of each tick: until its answer was there
  std::vector<double> work{};     // s of each: from when it was begun, which may be late
  double wall = 0.0;              // s, all of them; of paced ticks never less than their number asks for

  static double at(double share, std::vector<double> of) {
    const auto k = static_cast<std::size_t>(share * static_cast<double>(of.size() - 1) + 0.5);
    std::nth_element(of.begin(), of.begin() + static_cast<std::ptrdiff_t>(k), of.end());
    return of[k];
  }
  double at(double share) const { return at(share, seconds); }
  double rate() const { return static_cast<double>(seconds.size()) / wall; }  // Hz
  double share_above(double limit) const {
    const auto above = std::ranges::count_if(seconds, [limit](double t) { return t > limit; });
    return static_cast<double>(above) / static_cast<double>(seconds.size());
  }
  void append(const Times& more) {
    seconds.insert(seconds.end(), more.seconds.begin(), more.seconds.end());
    work.insert(work.end(), more.work.begin(), more.work.end());
    wall += more.wall;
  }
};

/// Ticks at the beginning of a stretch that are not counted: they find what worked before in the caches, which a device
/// that runs on and on does not.
inline constexpr int warming = 10;

/// `ticks` of them at 1 kHz of the wall clock: from when a tick was due to when its answer was there. A tick that is
/// late makes the next one late, as it would a device's; none is left out.
template <class Answer>
Times paced(int ticks, Answer answer) {
  Times times;
  times.seconds.reserve(static_cast<std::size_t>(ticks));
  times.work.reserve(static_cast<std::size_t>(ticks));
  const auto after = [](Clock::time_point from, int k) { return from + std::chrono::microseconds(1000) * k; };
  const Clock::time_point begin = Clock::now();
  for (int k = 0; k < warming + ticks; ++k) {
    const Clock::time_point due = after(begin, k);
    while (Clock::now() < due) {  // a sleeping thread wakes some 50 us late
      if (due - Clock::now() > std::chrono::microseconds(200)) {
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      }
    }
    const Clock::time_point start = Clock::now();
    answer();
    const Clock::time_point done = Clock::now();
    if (k < warming) continue;
    times.seconds.push_back(std::chrono::duration<double>(done - due).count());
    times.work.push_back(std::chrono::duration<double>(done - start).count());
  }
  const Clock::time_point end = std::max(Clock::now(), after(begin, warming + ticks));
  times.wall = std::chrono::duration<double>(end - after(begin, warming)).count();
  return times;
}

}  // namespace phymul::bench
