// SPDX-License-Identifier: MIT
//
// haptic_loop [seconds] [particles] [threads]: a tool that moves in a soft block, as a haptic device would move it.
// Once a millisecond of the wall clock a pose arrives, the tool's group is told to be there a millisecond later, and
// the body takes four steps. Prints how late the answers were, and what a millisecond costs the processor.
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "machine.h"
#include "machine_ceilings.h"

namespace {

using Clock = std::chrono::steady_clock;

constexpr double tick = 1e-3;  // s
constexpr int steps_a_tick = 4;
constexpr double spacing = 0.005;  // m
constexpr double reach = 0.25;     // of the spacing: how far the tool goes

/// A block of about so many particles, lower face held; three translations, one an axis, move the tool: the particles
/// near the middle of its upper face.
struct Bench {
  explicit Bench(int particles) : model(make_model(particles)), scene(model) {
    scene.fix("z0");
    const std::vector<phymul::Index>& top = model.group("z1");
    phymul::Vec3 middle = phymul::Vec3::Zero();
    for (const phymul::Index i : top) middle += model.rest[i] / static_cast<double>(top.size());
    std::vector<phymul::Index> tool;
    for (const phymul::Index i : top) {
      if ((model.rest[i] - middle).norm() <= 2.5 * spacing) tool.push_back(i);
    }
    for (int axis = 0; axis < 3; ++axis) {
      phymul::Load load;
      load.type = phymul::LoadType::translation;
      load.particles = tool;
      load.axes.fill(phymul::Axis::free);
      load.axes[axis] = phymul::Axis::driven;
      load.direction = phymul::Vec3::Unit(axis);
      load.events = {{0.0, 0.0}, {tick, 0.0}};
      scene.add(load);
    }
    tool_size = tool.size();
  }

  static phymul::Model make_model(int particles) {
    const int n = std::max(1, static_cast<int>(std::lround(std::cbrt(particles))) - 1);
    const int high = std::max(1, (particles + n * (n + 2)) / ((n + 1) * (n + 1)) - 1);
    phymul::Model model = phymul::make_block({n * spacing, n * spacing, high * spacing}, n, n, high, 6);
    phymul::set_material(model, {.young = 10e3, .poisson = 0.3, .density = 1000});
    return model;
  }

  /// The tool's pose moves from where it was at `date` to where the device now has it, in one tick.
  void drive(double date, const phymul::Vec3& from, const phymul::Vec3& to) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::array<phymul::ValueEvent, 2> events{{{date, from[axis]}, {date + tick, to[axis]}}};
      scene.set_events(static_cast<std::size_t>(axis) + 1, events);
    }
  }
  /// The same by replacing the loads, for what that would cost.
  void drive_by_replacing(double date, const phymul::Vec3& from, const phymul::Vec3& to) {
    for (int axis = 0; axis < 3; ++axis) {
      phymul::Load load = scene.loads()[static_cast<std::size_t>(axis) + 1];
      load.events = {{date, from[axis]}, {date + tick, to[axis]}};
      scene.replace(static_cast<std::size_t>(axis) + 1, std::move(load));
    }
  }

  phymul::Model model;
  phymul::Scene scene;
  std::size_t tool_size = 0;
};

/// A hand's motion: a few hertz, all axes, mostly pressing.
phymul::Vec3 hand(double time) {
  const double a = reach * spacing;
  return {a * std::sin(7.0 * time), a * std::sin(11.0 * time), -a * (1.0 - std::cos(5.0 * time))};
}

struct Times {
  std::vector<double> seconds;
  double cpu = 0.0;  // s a tick, of all threads; unpaced only, as waiting spins
  double at(double share) {
    const auto k = static_cast<std::size_t>(share * static_cast<double>(seconds.size() - 1) + 0.5);
    std::nth_element(seconds.begin(), seconds.begin() + static_cast<std::ptrdiff_t>(k), seconds.end());
    return seconds[k];
  }
};

class Loop {
 public:
  explicit Loop(phymul::Solver& solver) : solver_(solver) { solver_.read(state_); }

  /// One tick's work: the scene, the steps, and the state read back for the force on the hand and the picture.
  template <class Drive>
  void work(Drive drive) {
    const phymul::Vec3 now = hand(time_ + tick);
    drive(time_, pose_, now);
    const phymul::StepReport report = solver_.step(steps_a_tick, tick / steps_a_tick);
    if (!report.ok()) throw phymul::Error("haptic_loop: " + report.message());
    solver_.read(state_);
    pose_ = now;
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

  /// At 1 kHz of the wall clock: from when a tick was due to when its answer was there. A tick that is late makes the
  /// next one late, as it would a device's; none is left out.
  template <class Drive>
  Times paced(double seconds, Drive drive) {
    Times times;
    const auto ticks = static_cast<std::size_t>(seconds / tick);
    times.seconds.reserve(ticks);
    const Clock::time_point begin = Clock::now();
    for (std::size_t k = 0; k < ticks; ++k) {
      const Clock::time_point due = begin + std::chrono::microseconds(1000) * k;
      while (Clock::now() < due) {  // a sleeping thread wakes some 50 us late
        if (due - Clock::now() > std::chrono::microseconds(200))
          std::this_thread::sleep_for(std::chrono::microseconds(50));
      }
      work(drive);
      times.seconds.push_back(std::chrono::duration<double>(Clock::now() - due).count());
    }
    wall_ = std::chrono::duration<double>(Clock::now() - begin).count();
    return times;
  }
  double wall() const { return wall_; }

 private:
  phymul::Solver& solver_;
  phymul::State state_;
  phymul::Vec3 pose_ = phymul::Vec3::Zero();
  double time_ = 0.0, wall_ = 0.0;
};

void run(double seconds, int particles, int threads) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // who watches a minute sees that it began
  Bench bench(particles);
  phymul::SolverOptions options;
  options.threads = threads;
  options.damping.rate = 20.0;
  const auto solver = phymul::make_solver("cpu", bench.model, bench.scene, {.cell_average = 0.9}, options);
  for (const auto& [what, value] : machine_facts()) std::printf("%s: %s\n", what.c_str(), value.c_str());
  std::printf(
      "%d particles, cell-averaged lattice, %s; a tool of %zu particles; steps of %.3g us, stable up to %.3g us\n",
      bench.model.particle_count(), solver->device().c_str(), bench.tool_size, 1e6 * tick / steps_a_tick,
      1e6 * solver->stable_step());
  const auto drive = [&](double date, const phymul::Vec3& from, const phymul::Vec3& to) {
    bench.drive(date, from, to);
  };
  const auto replace = [&](double date, const phymul::Vec3& from, const phymul::Vec3& to) {
    bench.drive_by_replacing(date, from, to);
  };
  Loop loop(*solver);
  loop.unpaced(200, 1.0, drive);
  Times free = loop.unpaced(2000, 3.0, drive), replaced = loop.unpaced(500, 3.0, replace);
  std::printf(
      "one tick, unpaced: %.0f us (median), %.0f us of processor time; with Scene::replace instead of set_events "
      "%.0f us, %.0f us\n",
      1e6 * free.at(0.5), 1e6 * free.cpu, 1e6 * replaced.at(0.5), 1e6 * replaced.cpu);
  Times paced = loop.paced(seconds, drive);
  const double ticks = static_cast<double>(paced.seconds.size());
  const auto late = static_cast<double>(std::ranges::count_if(paced.seconds, [](double t) { return t > tick; }));
  std::printf(
      "1 kHz for %.0f s: %.1f Hz held; answer after %.0f us (median), %.0f (99 %%), %.0f (99.9 %%), %.0f (worst); "
      "%.0f of %.0f ticks took more than 1 ms\n",
      seconds, ticks / loop.wall(), 1e6 * paced.at(0.5), 1e6 * paced.at(0.99), 1e6 * paced.at(0.999),
      1e6 * paced.at(1.0), late, ticks);
  const bool held = paced.at(0.999) <= tick && ticks / loop.wall() >= 999.0;
  std::printf("1 kHz %s: the 99.9th percentile is %s 1 ms\n", held ? "held" : "NOT held",
              paced.at(0.999) <= tick ? "within" : "above");
}

}  // namespace

int main(int argc, char** argv) try {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 60.0;
  const int particles = argc > 2 ? std::atoi(argv[2]) : 5000;
  const int threads = argc > 3 ? std::atoi(argv[3]) : 2;
  if (!(seconds > 0.0) || particles < 64 || threads < 0) {
    throw phymul::Error("haptic_loop: expected [seconds > 0] [particles >= 64] [threads >= 0]");
  }
  run(seconds, particles, threads);
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
