// SPDX-License-Identifier: MIT
//
// An application with threads of its own, as an engine has them: the library runs its parts there and starts none.
// docs/guide/hosting.md, Threads.
#include <phymul/phymul.h>

#include <condition_variable>
#include <cstdio>
#include <deque>
#include <functional>
#include <latch>
#include <mutex>
#include <thread>
#include <vector>

namespace {

/// The application's queue of jobs, with its threads.
class Jobs {
 public:
  explicit Jobs(int threads) {
    for (int k = 0; k < threads; ++k) threads_.emplace_back([this](const std::stop_token& stop) { work(stop); });
  }

  int threads() const { return static_cast<int>(threads_.size()); }

  void add(std::function<void()> job) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(job));
    }
    has_some_.notify_one();
  }

 private:
  void work(const std::stop_token& stop) {
    for (;;) {
      std::unique_lock lock(mutex_);
      if (!has_some_.wait(lock, stop, [this] { return !waiting_.empty(); })) return;
      const std::function<void()> job = std::move(waiting_.front());
      waiting_.pop_front();
      lock.unlock();
      job();
    }
  }

  std::mutex mutex_;
  std::condition_variable_any has_some_;
  std::deque<std::function<void()>> waiting_;
  std::vector<std::jthread> threads_;
};

/// What the library is given: it lends the threads of the queue and the one that steps.
class OnJobs final : public phymul::TaskRunner {
 public:
  explicit OnJobs(Jobs& jobs) : jobs_(jobs) {}

  int width() const override { return jobs_.threads() + 1; }

  void run(int count, const std::function<void(int)>& task) override {
    std::latch left(count - 1);
    for (int part = 1; part < count; ++part) {
      jobs_.add([&task, &left, part] {
        task(part);
        left.count_down();
      });
    }
    task(0);
    left.wait();
  }

 private:
  Jobs& jobs_;
};

phymul::State pulled(const std::shared_ptr<phymul::TaskRunner>& runner) {
  phymul::Simulation sim(phymul::make_block({0.2, 0.1, 0.1}, 24, 12, 12),
                         {.material = {.young = 10e3, .poisson = 0.3, .density = 1000},
                          .backend = "cpu",
                          .damping = {.rate = 20},
                          .runner = runner,
                          .solver = {.threads = 2}});
  sim.scene().fix("x0").gravity({0, 0, -9.81});
  if (const auto step = sim.advance(0.2); !step.ok()) throw phymul::Error(step.message());
  std::printf("%d particles, %s: sags %.1f mm\n", sim.model().particle_count(), sim.solver().device().c_str(),
              1e3 * sim.max_displacement());
  return sim.state();
}

}  // namespace

int main() try {
  Jobs jobs(1);  // of the application; the thread that steps is the second
  const bool same = pulled(std::make_shared<OnJobs>(jobs)) == pulled(nullptr);
  std::printf("by the application's threads and by the library's own: %s\n", same ? "the same bits" : "DIFFERENT");
  return same ? 0 : 1;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
