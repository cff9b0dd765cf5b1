// SPDX-License-Identifier: MIT
//
// Threads of one process that solve scenes.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "scene.h"

struct SceneJob {
  std::vector<double> values;
  SceneResult result;
};

using SceneWork = std::function<SceneResult(const std::vector<double>&)>;

class StudyCrew {
 public:
  /// `make_work` is called once per thread, here, so that threads share nothing.
  StudyCrew(int threads, const std::function<SceneWork()>& make_work);
  ~StudyCrew();  ///< waits for the scenes that are being solved, drops those that are not begun
  StudyCrew(const StudyCrew&) = delete;
  StudyCrew& operator=(const StudyCrew&) = delete;

  void submit(std::vector<double> values);
  /// A scene that is done; none within the time. Rethrows what the work threw.
  std::optional<SceneJob> take(std::chrono::microseconds patience);

 private:
  void work(const SceneWork& solve);
  void close();

  std::mutex mutex_;
  std::condition_variable submitted_, solved_;
  std::deque<std::vector<double>> waiting_;
  std::deque<SceneJob> done_;
  std::exception_ptr problem_;
  bool closing_ = false;
  std::vector<std::thread> threads_;
};
