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

  /// Of one part: the last round in which some thread took it. A line of its own.
  struct alignas(64) Claim {
    std::atomic<std::uint32_t> round{0};
  };

  void call(Call function, const void* object);
  bool claim(int part, std::uint32_t round);
  void finish_part();
  void serve(int part);
  void end();

  std::vector<Claim> claims_;  // [parts], of part 0 unused
  std::vector<std::thread> workers_;
  Call function_ = nullptr;
  const void* object_ = nullptr;
  std::atomic<std::uint32_t> round_{0};  // grows by one at each call; workers wait for it to change
  std::atomic<int> busy_{0};             // parts but 0 that are not finished
  std::atomic<bool> ending_{false};
};

}  // namespace phymul::cpu
