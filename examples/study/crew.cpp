// SPDX-License-Identifier: MIT
#include "crew.h"

#include <utility>

StudyCrew::StudyCrew(int threads, const std::function<SceneWork()>& make_work) {
  try {
    for (int k = 0; k < threads; ++k) threads_.emplace_back([this, solve = make_work()] { work(solve); });
  } catch (...) {
    close();  // a thread that nobody has joined would end the program
    throw;
  }
}

StudyCrew::~StudyCrew() {
  close();
}

void StudyCrew::close() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  submitted_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void StudyCrew::submit(std::vector<double> values) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(values));
  }
  submitted_.notify_one();
}

std::optional<SceneJob> StudyCrew::take(std::chrono::microseconds patience) {
  std::unique_lock lock(mutex_);
  solved_.wait_for(lock, patience, [this] { return !done_.empty() || problem_; });
  if (problem_) std::rethrow_exception(problem_);
  if (done_.empty()) return std::nullopt;
  SceneJob job = std::move(done_.front());
  done_.pop_front();
  return job;
}

void StudyCrew::work(const SceneWork& solve) {
  for (;;) {
    SceneJob job;
    {
      std::unique_lock lock(mutex_);
      submitted_.wait(lock, [this] { return closing_ || !waiting_.empty(); });
      if (closing_) return;
      job.values = std::move(waiting_.front());
      waiting_.pop_front();
    }
    std::exception_ptr problem;
    try {
      job.result = solve(job.values);
    } catch (...) {
      problem = std::current_exception();
    }
    {
      const std::lock_guard lock(mutex_);
      if (problem) {
        problem_ = problem;
      } else {
        done_.push_back(std::move(job));
      }
    }
    solved_.notify_one();
    if (problem) return;
  }
}
