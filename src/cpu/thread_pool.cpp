// SPDX-License-Identifier: MIT
#include "thread_pool.h"

#include <system_error>

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

namespace phymul::cpu {
namespace {

/// About 20 to 50 microseconds: longer than the pause between two passes, shorter than a scheduler's slice.
constexpr int spins_before_sleep = 1000;
/// After this many a waiting thread offers its processor: there may be fewer of them than threads.
constexpr int spins_before_yield = 100;

void pause_a_moment() {
#if defined(__x86_64__) || defined(__i386__)
  _mm_pause();
#endif
}

/// Spins, then yields, then sleeps until `value` is no longer `old`.
template <class T>
void wait_for_change(const std::atomic<T>& value, T old) {
  for (int spin = 0; spin < spins_before_sleep; ++spin) {
    if (value.load(std::memory_order_acquire) != old) return;
    if (spin < spins_before_yield) {
      pause_a_moment();
    } else {
      std::this_thread::yield();
    }
  }
  value.wait(old, std::memory_order_acquire);
}

}  // namespace

ThreadPool::ThreadPool(int parts) {
  workers_.reserve(static_cast<std::size_t>(parts - 1));
  try {
    for (int part = 1; part < parts; ++part) workers_.emplace_back([this, part] { serve(part); });
  } catch (const std::system_error&) {
    // Those that started do: results do not depend on their number.
  }
}

ThreadPool::~ThreadPool() {
  end();
}

void ThreadPool::end() {
  ending_.store(true, std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void ThreadPool::call(Call function, const void* object) {
  function_ = function;
  object_ = object;
  busy_.store(static_cast<int>(workers_.size()), std::memory_order_relaxed);
  round_.fetch_add(1, std::memory_order_release);
  round_.notify_all();
  function(object, 0, parts());
  for (int busy = busy_.load(std::memory_order_acquire); busy != 0; busy = busy_.load(std::memory_order_acquire)) {
    wait_for_change(busy_, busy);
  }
}

void ThreadPool::serve(int part) {
  std::uint32_t seen = 0;
  for (;;) {
    wait_for_change(round_, seen);
    ++seen;
    if (ending_.load(std::memory_order_relaxed)) return;
    function_(object_, part, parts());
    if (busy_.fetch_sub(1, std::memory_order_acq_rel) == 1) busy_.notify_one();
  }
}

}  // namespace phymul::cpu
