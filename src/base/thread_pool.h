// SPDX-License-Identifier: MIT
//
// A pool of threads that live as long as their owner. Passes of a step take microseconds, so workers spin a while for
// the next one before they sleep.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace phymul::cpu {

/// run() calls work(part, parts) once for each part 0 <= part < parts(), part 0 on the calling thread, and returns when
/// all have returned. Each other part has a thread of its own; where that has not begun by the time the caller is done,
/// because other programs have the processors, the caller takes the part. Results depend on parts() only through how
/// the work is cut. `work` must not throw. One caller at a time.
class ThreadPool {
 public:
  explicit ThreadPool(int parts);  ///< parts - 1 threads are started, or as many as the system gives
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int parts() const { return static_cast<int>(workers_.size()) + 1; }

  template <class Work>
  void run(const Work& work) {
    if (workers_.empty()) {
      work(0, 1);
      return;
    }
    call([](const void* object, int part, int parts) { (*static_cast<const Work*>(object))(part, parts); }, &work);
  }

 private:
  using Call = void (*)(const void*, int, int);

  /// What the caller tells the workers: a line of the caches that it alone writes.
  struct alignas(64) Order {
    std::atomic<std::uint32_t> round{0};  ///< grows by one at each call; workers wait for it to change
    std::atomic<bool> ending{false};
    Call function = nullptr;
    const void* object = nullptr;
  };

  /// Of one part: the last round in which some thread took it, and the last one that its own thread finished. A line
  /// that the caller reads once a call where that thread is in time.
  struct alignas(64) Part {
    std::atomic<std::uint32_t> taken{0}, finished{0};
  };

  void call(Call function, const void* object);
  bool take(int part, std::uint32_t round);
  void serve(int part);
  void end();

  Order order_;
  std::vector<Part> parts_;  // of part 0 unused
  std::vector<std::thread> workers_;
};

}  // namespace phymul::cpu
