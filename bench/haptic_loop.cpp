// SPDX-License-Identifier: MIT
//
// haptic_loop [seconds] [particles] [threads] [moved|needle] [steps] [cubes|warped]: a soft block, of equal cells or of
// no two alike, and in it what a haptic device moves: a group of particles, or a ball and a needle. Once a millisecond
// of the wall clock a pose arrives, the scene is told to be there a millisecond later, and the body takes so many
// steps. Prints how late the answers were, beside ticks of plain arithmetic of the same length, second by second in
// turns, and what a millisecond costs the processor.
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

#include "haptic_scene.h"
#include "machine.h"
#include "paced_ticks.h"
#include "plain_ticks.h"
#include "stopwatch.h"
#include "usage.h"

namespace {

using phymul::bench::Clock;
using phymul::bench::HapticScene;
using phymul::bench::paced;
using phymul::bench::PlainTicks;
using phymul::bench::tick;
using phymul::bench::Times;

struct Wish {
  double seconds = 60.0;
  int particles = 5000, threads = 2;
  std::string what = "moved";
  int steps = 4;  // a tick
  std::string cells = "cubes";
};

void print(const char* what, const Times& times) {
  std::printf("%s: answer after %.0f us (median), %.0f (99 %%), %.0f (99.9 %%), %.0f (worst); %.2f %% late\n", what,
              1e6 * times.at(0.5), 1e6 * times.at(0.99), 1e6 * times.at(0.999), 1e6 * times.at(1.0),
              100.0 * times.share_above(tick));
}

class Loop {
 public:
  Loop(phymul::Solver& solver, HapticScene& scene, int steps) : solver_(solver), scene_(scene), steps_(steps) {
    solver_.read(state_);
  }

  /// One tick's work: the scene, the steps, and the state read back for the force on the hand and the picture.
  template <class Drive>
  void work(Drive drive) {
    drive(time_);
    const phymul::StepReport report = solver_.step(steps_, tick / steps_);
    if (!report.ok()) throw phymul::Error("haptic_loop: " + report.message());
    solver_.read(state_);
    scene_.answer(solver_, state_);
    time_ = report.time;
  }
  void work() {
    work([this](double date) { scene_.drive(date); });
  }

  /// As fast as it goes, which is what a tick costs where nothing waits; prints that.
  template <class Drive>
  void unpaced(const char* what, int ticks, double seconds, Drive drive) {
    Times times;
    const Clock::time_point begin = Clock::now();
    const double cpu = processor_seconds();  // of all threads; unpaced only, as waiting spins
    for (int k = 0; k < ticks && std::chrono::duration<double>(Clock::now() - begin).count() < seconds; ++k) {
      const Clock::time_point start = Clock::now();
      work(drive);
      times.seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
    }
    const double each = (processor_seconds() - cpu) / static_cast<double>(times.seconds.size());
    std::printf("%s: %.0f us (median), %.0f (99 %%), %.0f (99.9 %%), %.0f us of processor time\n", what,
                1e6 * times.at(0.5), 1e6 * times.at(0.99), 1e6 * times.at(0.999), 1e6 * each);
  }

 private:
  phymul::Solver& solver_;
  HapticScene& scene_;
  phymul::State state_;
  int steps_ = 0;
  double time_ = 0.0;
};

struct Both {
  Times ticks, plain;
};

/// In turns of a second, so that both meet the same moments of a machine whose host has others to serve.
Both beside_plain_ticks(double seconds, int threads, Loop& loop) {
  PlainTicks plain(threads);
  Both both;
  for (int left = static_cast<int>(std::lround(seconds / tick)); left > 0; left -= 1000) {
    const int ticks = std::min(left, 1000);
    both.ticks.append(paced(ticks, [&] { loop.work(); }));
    const double wanted = Times::at(0.5, both.ticks.work);
    const auto calibrate = [&](const Times& found) { plain.scale(Times::at(0.5, found.work), wanted); };
    if (both.plain.seconds.empty()) {
      calibrate(paced(20, [&] { plain.work(); }));  // to be of some length
      calibrate(paced(50, [&] { plain.work(); }));
    }
    const Times found = paced(ticks, [&] { plain.work(); });
    both.plain.append(found);
    calibrate(found);
  }
  return both;
}

/// What the figures say of the library, and what they cannot.
void judge(const Both& both) {
  const double late = 1e3 * both.ticks.at(0.999), plain = 1e3 * both.plain.at(0.999);
  const bool held = late <= 1e3 * tick && both.ticks.rate() >= 999.0;
  if (held) {
    std::printf("1 kHz held: the 99.9th percentile is %.2f ms, of plain arithmetic %.2f ms\n", late, plain);
  } else if (plain <= 1e3 * tick) {
    std::printf(
        "1 kHz NOT held, and the machine is not the reason: the 99.9th percentile is %.2f ms, of plain "
        "arithmetic %.2f ms\n",
        late, plain);
  } else {
    std::printf(
        "1 kHz: cannot be told on this machine: the 99.9th percentile is %.2f ms, of plain arithmetic, which "
        "cannot be late by itself, %.2f ms\n",
        late, plain);
  }
}

/// A body that is pressed has a smaller limit than one at rest: half of that, as Solver::stable_step() says.
void refuse_unstable(const phymul::Solver& solver, int steps) {
  const double limit = 0.5 * solver.stable_step();
  if (tick / steps <= limit) return;
  char text[200];
  std::snprintf(text, sizeof text,
                "haptic_loop: expected steps of at most %.4g us, half of the stable one, got %d a tick, which are of "
                "%.4g us; ask for %.0f or more",
                1e6 * limit, steps, 1e6 * tick / steps, std::ceil(tick / limit));
  throw phymul::Error(text);
}

void run(const Wish& wish) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // who watches a minute sees that it began
  const bool warped = wish.cells == "warped";
  std::unique_ptr<HapticScene> haptic;
  phymul::bench::MovedParticles* moved = nullptr;
  if (wish.what == "needle") {
    haptic = std::make_unique<phymul::bench::ProbeAndNeedle>(wish.particles, warped);
  } else {
    auto made = std::make_unique<phymul::bench::MovedParticles>(wish.particles, warped);
    moved = made.get();
    haptic = std::move(made);
  }
  phymul::SolverOptions options;
  options.threads = wish.threads;
  options.damping.rate = 20.0;
  const auto solver = phymul::make_solver("cpu", haptic->model(), haptic->scene(), {}, options);
  refuse_unstable(*solver, wish.steps);
  for (const auto& [what, value] : machine_facts()) std::printf("%s: %s\n", what.c_str(), value.c_str());
  std::printf("%d particles, %s, %s; %s; %d steps a tick of %.3g us, stable up to %.3g us\n",
              haptic->model().particle_count(), warped ? "warped hexahedra" : "equal cubes", solver->device().c_str(),
              haptic->what().c_str(), wish.steps, 1e6 * tick / wish.steps, 1e6 * solver->stable_step());
  Loop loop(*solver, *haptic, wish.steps);
  const auto drive = [&](double date) { haptic->drive(date); };
  loop.unpaced("the first ticks", 200, 1.0, drive);
  loop.unpaced("one tick, unpaced", 2000, 5.0, drive);
  if (moved) {
    loop.unpaced("with Scene::replace instead of set_events", 500, 3.0,
                 [&](double date) { moved->drive_by_replacing(date); });
  }
  const int all = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  haptic->forget();
  const Both both = beside_plain_ticks(wish.seconds, wish.threads > 0 ? wish.threads : all, loop);
  print("1 kHz", both.ticks);
  print("plain arithmetic in turns with it", both.plain);
  std::printf("%.1f Hz for %.0f s\n", both.ticks.rate(), wish.seconds);
  if (const std::string found = haptic->found(wish.seconds); !found.empty()) std::printf("%s\n", found.c_str());
  judge(both);
}

}  // namespace

int main(int argc, char** argv) try {
  if (phymul::bench::prints_usage(
          argc, argv,
          "haptic_loop [seconds >= 0.001] [particles >= 64] [threads >= 0] [moved|needle] [steps a tick >= 1] "
          "[cubes|warped]\n"
          "A haptic device moves a soft block once a millisecond: how late the answers are, and what they cost.")) {
    return 0;
  }
  Wish wish;
  if (argc > 1) wish.seconds = std::atof(argv[1]);
  if (argc > 2) wish.particles = std::atoi(argv[2]);
  if (argc > 3) wish.threads = std::atoi(argv[3]);
  if (argc > 4) wish.what = argv[4];
  if (argc > 5) wish.steps = std::atoi(argv[5]);
  if (argc > 6) wish.cells = argv[6];
  if (!(wish.seconds >= tick) || wish.particles < 64 || wish.threads < 0 || argc > 7 || wish.steps < 1 ||
      (wish.what != "moved" && wish.what != "needle") || (wish.cells != "cubes" && wish.cells != "warped")) {
    throw phymul::Error(
        "haptic_loop: expected [seconds >= 0.001] [particles >= 64] [threads >= 0] [moved|needle] [steps a tick >= 1] "
        "[cubes|warped]");
  }
  run(wish);
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
