// SPDX-License-Identifier: MIT
//
// haptic_loop [seconds] [particles] [threads] [moved|needle]: a soft block, and in it what a haptic device moves: a
// group of particles, or a ball and a needle. Once a millisecond of the wall clock a pose arrives, the scene is told to
// be there a millisecond later, and the body takes four steps. Prints how late the answers were, and what a millisecond
// costs the processor.
#include <phymul/phymul.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "haptic_scene.h"
#include "machine.h"
#include "machine_ceilings.h"

namespace {

using Clock = std::chrono::steady_clock;

using phymul::bench::HapticScene;
using phymul::bench::tick;

constexpr int steps_a_tick = 4;

struct Times {
  std::vector<double> seconds;
  double cpu = 0.0;   // s a tick, of all threads; unpaced only, as waiting spins
  double wall = 0.0;  // s, all ticks; paced only
  double at(double share) {
    const auto k = static_cast<std::size_t>(share * static_cast<double>(seconds.size() - 1) + 0.5);
    std::nth_element(seconds.begin(), seconds.begin() + static_cast<std::ptrdiff_t>(k), seconds.end());
    return seconds[k];
  }
};

/// At 1 kHz of the wall clock: from when a tick was due to when its answer was there. A tick that is late makes the
/// next one late, as it would a device's; none is left out.
template <class Answer>
Times paced(double seconds, Answer answer) {
  Times times;
  const auto ticks = static_cast<std::size_t>(seconds / tick);
  times.seconds.reserve(ticks);
  const Clock::time_point begin = Clock::now();
  for (std::size_t k = 0; k < ticks; ++k) {
    const Clock::time_point due = begin + std::chrono::microseconds(1000) * k;
    while (Clock::now() < due) {  // a sleeping thread wakes some 50 us late
      if (due - Clock::now() > std::chrono::microseconds(200)) {
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      }
    }
    answer();
    times.seconds.push_back(std::chrono::duration<double>(Clock::now() - due).count());
  }
  times.wall = std::chrono::duration<double>(Clock::now() - begin).count();
  return times;
}

void print(const char* what, Times& times) {
  std::printf("%s: answer after %.0f us (median), %.0f (99 %%), %.0f (99.9 %%), %.0f (worst)\n", what,
              1e6 * times.at(0.5), 1e6 * times.at(0.99), 1e6 * times.at(0.999), 1e6 * times.at(1.0));
}

class Loop {
 public:
  Loop(phymul::Solver& solver, HapticScene& scene) : solver_(solver), scene_(scene) { solver_.read(state_); }

  /// One tick's work: the scene, the steps, and the state read back for the force on the hand and the picture.
  template <class Drive>
  void work(Drive drive) {
    drive(time_);
    const phymul::StepReport report = solver_.step(steps_a_tick, tick / steps_a_tick);
    if (!report.ok()) throw phymul::Error("haptic_loop: " + report.message());
    solver_.read(state_);
    scene_.answer(solver_);
    time_ = report.time;
  }

  /// As fast as it goes: what a tick costs where nothing waits.
  template <class Drive>
  Times unpaced(int ticks, double seconds, Drive drive) {
    Times times;
    const Clock::time_point begin = Clock::now();
    const double cpu = phymul::bench::processor_seconds();
    for (int k = 0; k < ticks && std::chrono::duration<double>(Clock::now() - begin).count() < seconds; ++k) {
      const Clock::time_point start = Clock::now();
      work(drive);
      times.seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
    }
    times.cpu = (phymul::bench::processor_seconds() - cpu) / static_cast<double>(times.seconds.size());
    return times;
  }

 private:
  phymul::Solver& solver_;
  HapticScene& scene_;
  phymul::State state_;
  double time_ = 0.0;
};

void run(double seconds, int particles, int threads, bool tools) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // who watches a minute sees that it began
  std::unique_ptr<HapticScene> haptic;
  phymul::bench::MovedParticles* moved = nullptr;
  if (tools) {
    haptic = std::make_unique<phymul::bench::ProbeAndNeedle>(particles);
  } else {
    auto made = std::make_unique<phymul::bench::MovedParticles>(particles);
    moved = made.get();
    haptic = std::move(made);
  }
  phymul::SolverOptions options;
  options.threads = threads;
  options.damping.rate = 20.0;
  const auto solver = phymul::make_solver("cpu", haptic->model(), haptic->scene(), {.cell_average = 0.9}, options);
  for (const auto& [what, value] : machine_facts()) std::printf("%s: %s\n", what.c_str(), value.c_str());
  std::printf("%d particles, cell-averaged lattice, %s; %s; steps of %.3g us, stable up to %.3g us\n",
              haptic->model().particle_count(), solver->device().c_str(), haptic->what().c_str(),
              1e6 * tick / steps_a_tick, 1e6 * solver->stable_step());
  const auto drive = [&](double date) { haptic->drive(date); };
  Loop loop(*solver, *haptic);
  loop.unpaced(200, 1.0, drive);
  Times free = loop.unpaced(2000, 5.0, drive);
  std::printf("one tick, unpaced: %.0f us (median), %.0f (99 %%), %.0f (99.9 %%), %.0f us of processor time\n",
              1e6 * free.at(0.5), 1e6 * free.at(0.99), 1e6 * free.at(0.999), 1e6 * free.cpu);
  if (moved) {
    Times replaced = loop.unpaced(500, 3.0, [&](double date) { moved->drive_by_replacing(date); });
    std::printf("with Scene::replace instead of set_events %.0f us, %.0f us of processor time\n",
                1e6 * replaced.at(0.5), 1e6 * replaced.cpu);
  }
  Times idle = paced(std::min(seconds, 10.0), [] {});
  print("ticks without work, which show what else the machine does", idle);
  Times ticked = paced(seconds, [&] { loop.work(drive); });
  const auto ticks = static_cast<double>(ticked.seconds.size());
  const auto late = static_cast<double>(std::ranges::count_if(ticked.seconds, [](double t) { return t > tick; }));
  const double rate = ticks / ticked.wall;
  print("1 kHz", ticked);
  std::printf("%.1f Hz for %.0f s; %.0f of %.0f ticks took more than 1 ms\n", rate, seconds, late, ticks);
  if (const std::string found = haptic->found(); !found.empty()) std::printf("%s\n", found.c_str());
  const bool within = ticked.at(0.999) <= tick;
  std::printf("1 kHz %s: the 99.9th percentile is %s 1 ms\n", within && rate >= 999.0 ? "held" : "NOT held",
              within ? "within" : "above");
}

}  // namespace

int main(int argc, char** argv) try {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 60.0;
  const int particles = argc > 2 ? std::atoi(argv[2]) : 5000;
  const int threads = argc > 3 ? std::atoi(argv[3]) : 2;
  const std::string what = argc > 4 ? argv[4] : "moved";
  if (!(seconds > 0.0) || particles < 64 || threads < 0 || (what != "moved" && what != "needle")) {
    throw phymul::Error("haptic_loop: expected [seconds > 0] [particles >= 64] [threads >= 0] [moved|needle]");
  }
  run(seconds, particles, threads, what == "needle");
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
