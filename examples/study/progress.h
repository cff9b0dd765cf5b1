// SPDX-License-Identifier: MIT
//
// How far a study is, on the standard error: one line, overwritten in place where that is a terminal, else a line now
// and then.
#pragma once

#include <chrono>
#include <cstddef>

class StudyProgress {
 public:
  /// `known`: scenes of `all` that were done before.
  StudyProgress(bool quiet, std::size_t all, std::size_t known);
  ~StudyProgress();
  StudyProgress(const StudyProgress&) = delete;
  StudyProgress& operator=(const StudyProgress&) = delete;

  void done(bool failed);

 private:
  using Clock = std::chrono::steady_clock;
  void print();

  bool quiet_, terminal_;
  std::size_t all_, known_, done_ = 0, failed_ = 0;
  Clock::time_point start_, next_;
};
