// SPDX-License-Identifier: MIT
#include "progress.h"

#include <unistd.h>

#include <cstdio>

StudyProgress::StudyProgress(bool quiet, std::size_t all, std::size_t known)
    : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0), all_(all), known_(known), start_(Clock::now()) {
  next_ = start_;
  if (known_ > 0 && !quiet_) std::fprintf(stderr, "%zu of %zu scenes were done before\n", known_, all_);
}

StudyProgress::~StudyProgress() {
  if (quiet_ || done_ == 0) return;
  print();
  if (terminal_) std::fputc('\n', stderr);
}

void StudyProgress::done(bool failed) {
  ++done_;
  if (failed) ++failed_;
  const Clock::time_point now = Clock::now();
  if (quiet_ || now < next_ || known_ + done_ == all_) return;
  next_ = now + (terminal_ ? std::chrono::milliseconds(200) : std::chrono::seconds(3));
  print();
}

void StudyProgress::print() {
  const double spent = std::chrono::duration<double>(Clock::now() - start_).count();
  const double left = spent / static_cast<double>(done_) * static_cast<double>(all_ - known_ - done_);
  std::fprintf(stderr, "%s%zu of %zu scenes, %zu without result; %.3g s a scene, %.0f s left%s", terminal_ ? "\r" : "",
               known_ + done_, all_, failed_, spent / static_cast<double>(done_), left, terminal_ ? "  " : "\n");
  std::fflush(stderr);
}
