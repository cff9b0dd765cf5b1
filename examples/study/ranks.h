// SPDX-License-Identifier: MIT
//
// The processes of a study. Rank 0 hands out scenes one by one, because they differ in time, and solves some itself.
// Built without MPI, or started without mpirun, there is one process.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "crew.h"

/// One object in main(); MPI is used by the thread that made it alone.
class StudyRanks {
 public:
  StudyRanks(int* argc, char*** argv);
  ~StudyRanks();
  StudyRanks(const StudyRanks&) = delete;
  StudyRanks& operator=(const StudyRanks&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }

  /// Collective, once all are ready to begin. `problem`: what keeps this process from it; empty: nothing. Returns what
  /// this process should print before all of them end; none: all go on. The first process with a problem gets it to
  /// print; the others get an empty text.
  std::optional<std::string> agree(const std::string& problem, std::uint32_t fingerprint);

  /// Collective: rank 0 goes on and calls solve(); the others work for it, and return when it is destroyed.
  void begin(int threads, const std::function<SceneWork()>& make_work);

  /// Rank 0: solves scenes and calls `done` for each, in the order in which they are done.
  void solve(const std::vector<std::vector<double>>& scenes, const std::function<void(SceneJob)>& done);
  int slots() const;  ///< scenes that are solved at the same time

  /// After an error here that the others do not know of: ends them where they would wait for ever.
  void abort_if_awaited();

 private:
  void serve();
  void send(int to, const std::string& text);
  bool receive(int& from, std::string& text);  ///< false: nothing has come

  int rank_ = 0, size_ = 1;
  std::vector<int> threads_{1};  // [size]
  std::unique_ptr<StudyCrew> crew_;
};
