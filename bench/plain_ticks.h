// SPDX-License-Identifier: MIT
//
// What a machine makes of ticks in which nothing but arithmetic happens: a control for those of a haptic loop. Work
// that takes L is late where the machine takes more than 1 ms - L away, so the control's ticks are as long, and of as
// many threads; they touch no memory, call nothing, and threads meet once a tick.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace phymul::bench {

class PlainTicks {
 public:
  explicit PlainTicks(int threads);
  ~PlainTicks();
  PlainTicks(const PlainTicks&) = delete;
  PlainTicks& operator=(const PlainTicks&) = delete;

  /// One tick's work: a count of multiply-adds, not a time, or what the machine takes away would be part of it.
  void work();
  /// Ticks of now on take `wanted` s where those until now took `found`.
  void scale(double found, double wanted);

 private:
  void serve();
  void take_pieces(std::uint32_t tick);

  long rounds_ = 1000;                     // of a piece
  std::atomic<std::uint32_t> tick_{0};     // grows by one a tick; threads wait for it to change
  std::atomic<std::uint64_t> claimed_{0};  // the tick in the upper half, and how many of its pieces are taken
  std::atomic<int> done_{0};               // pieces of this tick
  std::atomic<bool> ending_{false};
  std::vector<std::jthread> others_;
};

}  // namespace phymul::bench
