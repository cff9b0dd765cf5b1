// SPDX-License-Identifier: MIT
//
// Threads that the host lends (task_runner.h): the same bits whoever runs the parts, whatever the host does wrong, and
// no thread of the library's own.
#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/side_by_side.h"
#include "base/thread_pool.h"
#include "support/allocation_count.h"
#include "support/bodies.h"

namespace phymul::test {
namespace {

/// Does what a function says with each task.
class Host final : public TaskRunner {
 public:
  using How = std::function<void(int count, const std::function<void(int)>& task)>;
  Host(int width, How how) : width_(width), how_(std::move(how)) {}

  int width() const override { return width_; }
  void run(int count, const std::function<void(int)>& task) override {
    ++calls;
    largest = std::max(largest, count);
    how_(count, task);
  }

  int calls = 0, largest = 0;

 private:
  int width_;
  How how_;
};

/// Each part in a new thread, the last first.
void by_threads(int count, const std::function<void(int)>& task) {
  std::vector<std::jthread> threads;
  for (int part = count - 1; part >= 0; --part) threads.emplace_back([&task, part] { task(part); });
}

void in_turn(int count, const std::function<void(int)>& task) {
  for (int part = 0; part < count; ++part) task(part);
}

void not_all(int count, const std::function<void(int)>& task) {
  for (int part = 1; part < count; part += 2) task(part);
}

void twice_and_beyond(int count, const std::function<void(int)>& task) {
  for (int part = -1; part <= count; ++part) {
    task(part);
    task(part);
  }
}

void throws_at_once(int, const std::function<void(int)>&) {
  throw std::runtime_error("the host has no thread");
}

void throws_midway(int, const std::function<void(int)>& task) {
  task(1);
  throw 1;
}

struct NamedHow {
  const char* name;
  Host::How how;
};

std::vector<NamedHow> all_hosts() {
  return {{"threads", by_threads},
          {"in turn", in_turn},
          {"not all", not_all},
          {"twice", twice_and_beyond},
          {"throws at once", throws_at_once},
          {"throws midway", throws_midway}};
}

TEST(HostThreads, EveryPartIsRunOnceWhateverTheHostDoes) {
  for (const auto& [name, how] : all_hosts()) {
    for (const int parts : {1, 2, 5}) {
      Host host(5, how);
      ThreadPool pool(parts, &host);
      ASSERT_EQ(pool.parts(), parts);
      std::vector<int> times(static_cast<std::size_t>(parts), 0);
      for (int round = 1; round <= 50; ++round) {
        pool.run([&](int part, int of) { times[static_cast<std::size_t>(part)] += of; });
        ASSERT_EQ(times, std::vector<int>(times.size(), round * parts)) << name;
      }
      EXPECT_EQ(host.calls, parts == 1 ? 0 : 50) << name;
    }
  }
}

/// run() returns before a part that another thread has begun: it is waited for. One that was not begun is taken, and
/// the late thread finds it done, also when the next task is at work.
TEST(HostThreads, ALatePartIsWaitedForOrTaken) {
  std::vector<std::jthread> late;
  std::atomic<bool> begun{false};
  Host host(3, [&](int, const std::function<void(int)>& task) {
    begun = false;
    late.emplace_back([&task] { task(1); });
    late.emplace_back([&task] {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      task(2);
    });
    while (!begun) std::this_thread::yield();
  });
  ThreadPool pool(3, &host);
  std::vector<int> times(3, 0);
  for (int round = 1; round <= 20; ++round) {
    pool.run([&](int part, int) {
      if (part == 1) {
        begun = true;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      ++times[static_cast<std::size_t>(part)];
    });
    ASSERT_EQ(times, std::vector<int>(3, round));
  }
  late.clear();  // joined before the pool ends, as a host must
}

Model tissue(bool with_material) {
  Model model = make_block({0.2, 0.1, 0.1}, 20, 10, 10);
  if (with_material) set_material(model, {.young = 1e4, .poisson = 0.4, .density = 1000});
  return model;
}

/// One set-up for many solvers, because it takes far longer than their steps.
struct Pressed {
  explicit Pressed(bool with_material) : model(tissue(with_material)) {
    scene.fix("x0").gravity({0, 0, -9.81});
    scene.add_tool("ball", {.shape = Sphere{0.02}, .pose = {.position = {0.15, 0.05, 0.115}}});
  }

  State by(const std::shared_ptr<TaskRunner>& host, int threads) const {
    const auto solver = make_solver("cpu", tables, scene, {.spectrum = spectrum, .threads = threads, .runner = host});
    EXPECT_TRUE(solver->step(20, 0.5 * solver->stable_step()).ok());
    return solver->read();
  }

  Model model;
  Scene scene{model};
  std::shared_ptr<const TopologyTextures> tables = std::make_shared<const TopologyTextures>(build_topology(model));
  Spectrum spectrum = estimate_spectrum(*tables, tables->rest);
};

TEST(HostThreads, StepsHaveTheSameBits) {
  for (const bool with_material : {true, false}) {
    const Pressed body(with_material);
    const State own = body.by(nullptr, 1);
    EXPECT_TRUE(body.by(nullptr, 2) == own);
    for (const auto& [name, how] : all_hosts()) {
      for (const int width : {1, 3}) {
        const auto host = std::make_shared<Host>(width, how);
        EXPECT_TRUE(body.by(host, 4) == own) << name << ", " << width;
        EXPECT_EQ(host->largest, width == 1 ? 0 : 3) << name;
        if (width > 1) {
          EXPECT_GE(host->calls, 20) << name;
        }
      }
    }
  }
}

TEST(HostThreads, TablesAndSpectraHaveTheSameBits) {
  for (const bool with_material : {true, false}) {
    const Model model = tissue(with_material);
    const TopologyTextures own = build_topology(model);
    const Spectrum spectrum = estimate_spectrum(own, own.rest);
    const auto host = std::make_shared<Host>(2, by_threads);
    const TopologyTextures tables = build_topology(model, {.runner = host});
    EXPECT_EQ(fingerprint(tables), fingerprint(own));
    const int for_tables = host->calls;
    EXPECT_EQ(for_tables > 0, with_material);  // without one nothing of them is long
    const Spectrum other = estimate_spectrum(tables, tables.rest);
    EXPECT_GT(host->calls, for_tables);
    EXPECT_EQ(other.largest, spectrum.largest);
    EXPECT_EQ(other.most_negative, spectrum.most_negative);
  }
}

/// Threads of this process.
int thread_count() {
  const std::filesystem::directory_iterator all("/proc/self/task");
  return static_cast<int>(std::distance(begin(all), end(all)));
}

TEST(HostThreads, TheLibraryStartsNone) {
#if defined(_WIN32)
  GTEST_SKIP() << "NOT TESTED: /proc is not this process's own, even where Wine shows one";
#endif
  if (!std::filesystem::exists("/proc/self/task")) GTEST_SKIP() << "NOT TESTED: this system does not list threads";
  int most = 0;
  const auto host = std::make_shared<Host>(4, [&](int count, const std::function<void(int)>& task) {
    most = std::max(most, thread_count());
    in_turn(count, task);
  });
  const int before = thread_count();
  Simulation sim(tissue(true), {.backend = "cpu", .runner = host, .solver = {.threads = 4}});
  sim.scene().fix("x0");
  ASSERT_TRUE(sim.advance(0.01).ok());
  EXPECT_EQ(most, before);
  EXPECT_EQ(thread_count(), before);
  Simulation own(tissue(true), {.backend = "cpu", .solver = {.threads = 4}});
  ASSERT_TRUE(own.advance(0.01).ok());
  EXPECT_EQ(thread_count(), before + 3) << "this test would not see them";
}

TEST(HostThreads, StepsAllocateNothing) {
  const Model model = tissue(true);
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  const auto host = std::make_shared<Host>(3, in_turn);
  const auto solver = make_solver("cpu", model, scene, {}, {.threads = 3, .runner = host});
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(1, dt).ok());
  const std::size_t before = allocation_count();
  ASSERT_TRUE(solver->step(20, dt).ok());
  EXPECT_EQ(allocation_count(), before);
  EXPECT_EQ(host->largest, 3);
}

TEST(HostThreads, ExceptionsOfASetUpReachTheCaller) {
  const auto fails = [] { throw Error("the second"); };
  const auto fails_first = [] { throw Error("the first"); };
  const auto works = [] {};
  const auto text_of = [](const auto& call) -> std::string {
    try {
      call();
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  };
  Host host(2, by_threads);
  for (TaskRunner* const runner : {static_cast<TaskRunner*>(&host), static_cast<TaskRunner*>(nullptr)}) {
    for (const Index rows : {10, 10'000}) {
      EXPECT_EQ(text_of([&] { side_by_side(rows, runner, works, works); }), "none");
      EXPECT_EQ(text_of([&] { side_by_side(rows, runner, works, fails); }), "the second");
      EXPECT_EQ(text_of([&] { side_by_side(rows, runner, fails_first, works); }), "the first");
      EXPECT_EQ(text_of([&] { side_by_side(rows, runner, fails_first, fails); }), "the first");
    }
  }
  EXPECT_EQ(host.calls, 4) << "little work is no task";
}

TEST(HostThreads, ARunnerWithoutAThreadIsRefused) {
  const auto none = std::make_shared<Host>(0, in_turn);
  const Model model = make_block({0.02, 0.02, 0.02}, 2, 2, 2);
  EXPECT_THROW(build_topology(model, {.runner = none}), Error);
  const Scene scene(model);
  EXPECT_THROW(make_solver("cpu", model, scene, {}, {.runner = none}), Error);
  EXPECT_THROW(make_solver("reference", model, scene, {}, {.runner = none}), Error);
}

// The torque that rounding leaves on a body that is turned without being deformed: what it gains or loses of its spin
// in single precision. docs/measurements/accuracy.md has the formula.

constexpr Material spun_tissue{.young = 10e3, .poisson = 0.3, .density = 1000};
constexpr double most_units = 20.0;  // of the unit below; lattices have 8, tetrahedra 1

Vec3 centre_of(const Model& model) {
  Vec3 sum = Vec3::Zero();
  double mass = 0.0;
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    sum += model.mass[i] * model.rest[i];
    mass += model.mass[i];
  }
  return sum / mass;
}

/// N m: what half a unit in the last place makes of the stabiliser's forces, which cancel in a turn by 1 rad:
/// 2^-24 s mu V.
double unit_of(const TopologyTextures& tables) {
  double sum = 0.0;
  for (const DomainTexel& domain : tables.domains) sum += domain.spread_stiffness / domain.inverse_volume;
  return std::ldexp(sum, -24);
}

/// N m about z on the body turned by `angle`, at rest otherwise.
double torque_at(Solver& solver, double angle, double dt) {
  const Model& model = solver.model();
  const Vec3 centre = centre_of(model);
  const Eigen::AngleAxisd turn(angle, Vec3::UnitZ());
  State state = rest_state(model);
  for (Vec3& x : state.position) x = centre + turn * (x - centre);
  solver.reset(state);
  EXPECT_TRUE(solver.step(1, dt).ok());
  return solver.momentum(centre).angular.z() / dt;
}

struct Turning {
  const char* name;
  Model model;
};

std::vector<Turning> turning() {
  return {{"two cubes", make_block({0.02, 0.01, 0.01}, 2, 1, 1)},
          {"lattice", make_block({0.06, 0.03, 0.03}, 12, 6, 6)},
          {"tetrahedra", make_tetrahedral_block({0.06, 0.03, 0.03}, 12, 6, 6, 0.2, 3)}};
}

TEST(CpuSpin, TheTorqueOfRoundingIsBounded) {
  double worst = 0.0;
  for (const Turning& body : turning()) {
    SCOPED_TRACE(body.name);
    const Model model = with_material(body.model, spun_tissue);
    const Scene scene(model);
    const auto single = make_solver("cpu", model, scene), exact = make_solver("reference", model, scene);
    const double unit = unit_of(single->topology()), dt = 0.1 * exact->stable_step();
    double largest = 0.0;
    for (int k = 1; k <= 60; ++k) {
      const double angle = 0.05 * k, turn = 2.0 * std::sin(0.5 * angle);
      largest = std::max(largest, std::abs(torque_at(*single, angle, dt)) / (unit * turn));
      EXPECT_LT(std::abs(torque_at(*exact, angle, dt)), 1e-6 * unit * turn) << angle;
    }
    EXPECT_LT(largest, most_units);
    std::cout << body.name << ": at most " << largest << " of 2^-24 s mu V 2 sin(angle / 2)\n";
    worst = std::max(worst, largest);
  }
  EXPECT_GT(worst, 0.1) << "or the unit is none";
}

/// A free body that turns by 0.8 rad in 8 s: slow enough to show it.
TEST(CpuSpin, ASlowSpinDriftsNoFasterThanThatTorque) {
  const Model model = with_material(turning().front().model, spun_tissue);
  const Scene scene(model);
  const Vec3 centre = centre_of(model);
  const double rate = 0.1, time = 8.0, dt = 1e-3;
  for (const char* backend : {"reference", "cpu"}) {
    const auto solver = make_solver(backend, model, scene);
    State state = rest_state(model);
    for (std::size_t i = 0; i < state.position.size(); ++i) {
      state.velocity[i] = rate * Vec3::UnitZ().cross(model.rest[i] - centre);
    }
    solver->reset(state);
    const double before = solver->momentum(centre).angular.z();
    ASSERT_TRUE(solver->step(static_cast<int>(time / dt), dt).ok());
    const double gained = std::abs(solver->momentum(centre).angular.z() - before);
    const double bound = most_units * unit_of(solver->topology()) * rate * time;
    std::cout << backend << ": " << gained / before << " of its momentum, bound " << bound * time / before << '\n';
    EXPECT_LT(gained, solver->name() == "cpu" ? bound * time : 1e-9 * before);
  }
}

}  // namespace

}  // namespace phymul::test
