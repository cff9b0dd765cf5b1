// SPDX-License-Identifier: MIT
#include "ranks.h"

#ifdef PHYMUL_HAS_MPI
#include <mpi.h>
#endif

#include <thread>
#include <utility>

#include "journal.h"

namespace {

/// Between two looks for messages: what a scene may wait for, and what keeps a waiting process off the processor. MPI's
/// own waiting occupies it.
constexpr std::chrono::microseconds patience{200};

}  // namespace

#ifdef PHYMUL_HAS_MPI

StudyRanks::StudyRanks(int* argc, char*** argv) {
  int provided = 0;
  MPI_Init_thread(argc, argv, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
}

StudyRanks::~StudyRanks() {
  if (rank_ == 0 && crew_) {
    for (int to = 1; to < size_; ++to) send(to, "");
    std::string text;
    for (int left = size_ - 1, from = 0; left > 0;) {
      if (!receive(from, text)) {
        std::this_thread::sleep_for(patience);
      } else if (text.empty()) {
        --left;  // else a result that nobody waits for any more
      }
    }
  }
  crew_.reset();
  MPI_Finalize();
}

std::optional<std::string> StudyRanks::agree(const std::string& problem, std::uint32_t fingerprint) {
  const std::uint64_t own = problem.empty() ? fingerprint : ~std::uint64_t{0};
  std::vector<std::uint64_t> all(size_);
  MPI_Allgather(&own, 1, MPI_UINT64_T, all.data(), 1, MPI_UINT64_T, MPI_COMM_WORLD);
  for (int k = 0; k < size_; ++k) {
    if (all[k] == all[0] && all[0] != ~std::uint64_t{0}) continue;
    if (k != rank_) return "";
    const std::string who = k > 0 ? "process " + std::to_string(k) + " of " + std::to_string(size_) + ": " : "";
    return who + (problem.empty() ? "its files differ from those of process 0" : problem);
  }
  return std::nullopt;
}

void StudyRanks::begin(int threads, const std::function<SceneWork()>& make_work) {
  crew_ = std::make_unique<StudyCrew>(threads, make_work);
  threads_.resize(size_);
  MPI_Allgather(&threads, 1, MPI_INT, threads_.data(), 1, MPI_INT, MPI_COMM_WORLD);
  if (rank_ > 0) serve();
}

void StudyRanks::abort_if_awaited() {
  if (size_ > 1 && (rank_ > 0 || !crew_)) MPI_Abort(MPI_COMM_WORLD, 1);
}

void StudyRanks::send(int to, const std::string& text) {
  MPI_Send(text.data(), static_cast<int>(text.size()), MPI_CHAR, to, 0, MPI_COMM_WORLD);
}

bool StudyRanks::receive(int& from, std::string& text) {
  MPI_Status status;
  int there = 0, size = 0;
  MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &there, &status);
  if (there == 0) return false;
  MPI_Get_count(&status, MPI_CHAR, &size);
  text.resize(static_cast<std::size_t>(size));
  from = status.MPI_SOURCE;
  MPI_Recv(text.data(), size, MPI_CHAR, from, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  return true;
}

#else

StudyRanks::StudyRanks(int*, char***) {}

StudyRanks::~StudyRanks() = default;

std::optional<std::string> StudyRanks::agree(const std::string& problem, std::uint32_t) {
  if (problem.empty()) return std::nullopt;
  return problem;
}

void StudyRanks::begin(int threads, const std::function<SceneWork()>& make_work) {
  crew_ = std::make_unique<StudyCrew>(threads, make_work);
  threads_ = {threads};
}

void StudyRanks::abort_if_awaited() {}

void StudyRanks::send(int, const std::string&) {}

bool StudyRanks::receive(int&, std::string&) {
  return false;
}

#endif

int StudyRanks::slots() const {
  int sum = 0;
  for (const int threads : threads_) sum += threads;
  return sum;
}

void StudyRanks::solve(const std::vector<std::vector<double>>& scenes, const std::function<void(SceneJob)>& done) {
  std::vector<int> free = threads_;
  std::size_t next = 0;
  const auto take_back = [&](int rank, SceneJob job) {
    ++free[rank];
    done(std::move(job));
  };
  for (std::size_t left = scenes.size(); left > 0;) {
    for (int rank = 0; rank < size_; ++rank) {
      for (; next < scenes.size() && free[rank] > 0; --free[rank], ++next) {
        if (rank == 0) {
          crew_->submit(scenes[next]);
        } else {
          send(rank, result_text(scenes[next], {}));
        }
      }
    }
    int from = 0;
    std::string text;
    while (receive(from, text)) {
      SceneJob job;
      read_result(text, job.values, job.result);
      take_back(from, std::move(job));
      --left;
    }
    if (std::optional<SceneJob> job = crew_->take(patience)) {
      take_back(0, std::move(*job));
      --left;
    }
  }
}

void StudyRanks::serve() {
  int from = 0;
  for (std::string text;;) {
    while (receive(from, text)) {
      if (text.empty()) return send(0, "");
      SceneJob job;
      read_result(text, job.values, job.result);
      crew_->submit(std::move(job.values));
    }
    while (const std::optional<SceneJob> job = crew_->take(patience)) send(0, result_text(job->values, job->result));
  }
}
