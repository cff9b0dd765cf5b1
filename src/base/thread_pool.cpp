// SPDX-License-Identifier: MIT
#include "thread_pool.h"

#include <exception>

#include "compiler.h"

namespace phymul {
namespace {

/// Some 10 microseconds of pauses, as long as parts of a step differ: an offer of the processor takes half a
/// microsecond where nobody wants it, which a waiting thread is late by then.
constexpr int spins_before_yield = 300;
/// Thereafter it offers its processor, of which there may be fewer than threads: some hundred microseconds, longer than
/// the pause between two calls and shorter than a scheduler's slice.
constexpr int spins_before_sleep = 1200;

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

ThreadPool::ThreadPool(int parts, TaskRunner* host)
    : parts_(static_cast<std::size_t>(parts)), host_(host), task_([this](int part) {
        if (part >= 0 && part < this->parts()) run_if_not_taken(part, order_.round.load(std::memory_order_acquire));
      }) {
  if (host_) return;
  workers_.reserve(static_cast<std::size_t>(parts - 1));
  try {
    for (int part = 1; part < parts; ++part) workers_.emplace_back([this, part] { serve(part); });
  } catch (const std::exception&) {  // no thread, or no memory for it
    // Those that started do: results do not depend on their number.
  }
}

ThreadPool::~ThreadPool() {
  end();
}

void ThreadPool::end() {
  order_.ending.store(true, std::memory_order_relaxed);
  order_.round.fetch_add(1);
  order_.round.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

/// A part is taken in every round. One that is seen as taken is left alone: to write there costs both threads a wait.
bool ThreadPool::take(int part, std::uint32_t round) {
  std::uint32_t before = parts_[part].taken.load(std::memory_order_relaxed);
  return before == round - 1 && parts_[part].taken.compare_exchange_strong(before, round, std::memory_order_acq_rel);
}

void ThreadPool::call(Call function, const void* object) {
  order_.function = function;
  order_.object = object;
  const std::uint32_t round = order_.round.load(std::memory_order_relaxed) + 1;
  // No read-modify-write, which would wait for the line: a worker that falls asleep at this very moment may miss the
  // round, and the caller takes its part.
  order_.round.store(round, std::memory_order_release);
  if (host_) {
    try {
      host_->run(parts(), task_);
    } catch (...) {
      // As with threads that the system does not give: what it left out is done below.
    }
    finish(0, round);
  } else {
    order_.round.notify_all();
    function(object, 0, parts());
    finish(1, round);
  }
}

/// Takes the parts from `first` on that nobody has begun, and waits for the others.
void ThreadPool::finish(int first, std::uint32_t round) {
  for (int part = first; part < parts(); ++part) {
    if (!take(part, round)) continue;
    order_.function(order_.object, part, parts());
    parts_[part].finished.store(round, std::memory_order_relaxed);
  }
  for (int part = first; part < parts(); ++part) {
    const std::atomic<std::uint32_t>& finished = parts_[part].finished;
    for (std::uint32_t last = finished.load(std::memory_order_acquire); last != round;
         last = finished.load(std::memory_order_acquire)) {
      wait_for_change(finished, last);
    }
  }
}

void ThreadPool::serve(int part) {
  std::uint32_t seen = 0;
  for (;;) {
    wait_for_change(order_.round, seen);
    seen = order_.round.load(std::memory_order_acquire);
    if (order_.ending.load(std::memory_order_relaxed)) return;
    run_if_not_taken(part, seen);
  }
}

/// Once taken, the round waits for this part, and the order stays.
void ThreadPool::run_if_not_taken(int part, std::uint32_t round) {
  if (!take(part, round)) return;
  order_.function(order_.object, part, parts());
  parts_[part].finished.store(round);
  parts_[part].finished.notify_one();
}

}  // namespace phymul
