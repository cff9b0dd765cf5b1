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

ThreadPool::ThreadPool(int parts) : claims_(static_cast<std::size_t>(parts)) {
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

/// A part is taken once a round, so its last round is the one before until then.
bool ThreadPool::claim(int part, std::uint32_t round) {
  std::uint32_t before = round - 1;
  return claims_[part].round.compare_exchange_strong(before, round, std::memory_order_acq_rel);
}

void ThreadPool::finish_part() {
  if (busy_.fetch_sub(1, std::memory_order_acq_rel) == 1) busy_.notify_one();
}

void ThreadPool::call(Call function, const void* object) {
  function_ = function;
  object_ = object;
  busy_.store(static_cast<int>(workers_.size()), std::memory_order_relaxed);
  const std::uint32_t round = round_.fetch_add(1, std::memory_order_release) + 1;
  round_.notify_all();
  function(object, 0, parts());
  for (int part = 1; part < parts(); ++part) {
    if (!claim(part, round)) continue;
    function(object, part, parts());
    finish_part();
  }
  for (int busy = busy_.load(std::memory_order_acquire); busy != 0; busy = busy_.load(std::memory_order_acquire)) {
    wait_for_change(busy_, busy);
  }
}

void ThreadPool::serve(int part) {
  std::uint32_t seen = 0;
  for (;;) {
    wait_for_change(round_, seen);
    seen = round_.load(std::memory_order_acquire);
    if (ending_.load(std::memory_order_relaxed)) return;
    // Once claimed, the round waits for this part, and function_ stays.
    if (!claim(part, seen)) continue;
    function_(object_, part, parts());
    finish_part();
  }
}

}  // namespace phymul::cpu
