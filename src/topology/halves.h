// SPDX-License-Identifier: MIT
//
// Work on long tables, cut in two.
#pragma once

#include <phymul/types.h>

#include <future>
#include <thread>

namespace phymul {

/// Calls work(part, first, last) for part 0, the first half of `count` rows, and part 1, the rest; side by side where
/// that is far more work than starting a thread. The cut is always the same, so that results do not depend on the
/// machine; where both parts throw, the first one's exception is passed on.
template <class Work>
void in_halves(Index count, const Work& work) {
  constexpr Index worth_a_thread = 500;
  const Index half = count / 2;
  const bool side_by_side = count >= worth_a_thread && std::thread::hardware_concurrency() > 1;
  const auto policy = side_by_side ? std::launch::async | std::launch::deferred : std::launch::deferred;
  auto second = std::async(policy, [&] { work(1, half, count); });
  work(0, Index{0}, half);
  second.get();
}

}  // namespace phymul
