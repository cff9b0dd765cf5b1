// SPDX-License-Identifier: MIT
//
// A pool of threads that live as long as their owner. Passes of a step take microseconds, so workers spin a while for
// the next one before they sleep. Or threads of the host, where it lends them.
#pragma once

#include <phymul/task_runner.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace phymul {

/// run() calls work(part, parts) once for each part 0 <= part < parts(), part 0 on the calling thread, and returns when
/// all have returned. Each other part has a thread of its own; where that has not begun by the time the caller is done,
/// because other programs have the processors, the caller takes the part. Results depend on parts() only through how
/// the work is cut. `work` must not throw. One caller at a time. Of a host's threads any may run part 0 too.
class ThreadPool {
 public:
  /// parts - 1 threads are started, or as many as the system gives; none where the host lends its own.
  explicit ThreadPool(int parts, TaskRunner* host = nullptr);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int parts() const { return host_ ? static_cast<int>(parts_.size()) : static_cast<int>(workers_.size()) + 1; }

  template <class Work>
  void run(const Work& work) {
    if (parts() == 1) {
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
  void finish(int first, std::uint32_t round);
  bool take(int part, std::uint32_t round);
  void serve(int part);
  void run_if_not_taken(int part, std::uint32_t round);
  void end();

  Order order_;
  std::vector<Part> parts_;  // of part 0 used with a host alone
  std::vector<std::thread> workers_;
  TaskRunner* const host_;
  const std::function<void(int)> task_;  // what a host is given: made once, because steps do not allocate
};

}  // namespace phymul
