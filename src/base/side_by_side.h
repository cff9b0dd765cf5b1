// SPDX-License-Identifier: MIT
//
// Work of a set-up in two parts, by two threads where it is long.
#pragma once

#include <phymul/task_runner.h>
#include <phymul/types.h>

#include <algorithm>
#include <array>
#include <exception>
#include <future>
#include <thread>

#include "thread_pool.h"

namespace phymul {

/// Calls first() and second(): side by side if they are to do something with many `rows` each, which is far more work
/// than starting a thread; by threads of the host, where there is one. If both throw, first()'s exception is passed on.
template <class First, class Second>
void side_by_side(Index rows, TaskRunner* host, const First& first, const Second& second) {
  constexpr Index worth_a_thread = 500;
  if (!host) {
    const bool two = rows >= worth_a_thread && std::thread::hardware_concurrency() > 1;
    auto other = std::async(two ? std::launch::async | std::launch::deferred : std::launch::deferred, second);
    first();
    other.get();
    return;
  }
  std::array<std::exception_ptr, 2> thrown;
  ThreadPool pool(rows >= worth_a_thread ? std::min(2, host->width()) : 1, host);
  pool.run([&](int part, int parts) {
    for (int half = part; half < 2; half += parts) {
      try {
        half == 0 ? first() : second();
      } catch (...) {
        thrown[half] = std::current_exception();
      }
    }
  });
  for (const std::exception_ptr& exception : thrown) {
    if (exception) std::rethrow_exception(exception);
  }
}

/// Calls work(part, first, last) for part 0, the first half of `count` rows, and part 1, the rest, as above. The cut is
/// always the same, so that results do not depend on the machine.
template <class Work>
void in_halves(Index count, TaskRunner* host, const Work& work) {
  const Index half = count / 2;
  side_by_side(
      count, host, [&] { work(0, Index{0}, half); }, [&] { work(1, half, count); });
}

}  // namespace phymul
