// SPDX-License-Identifier: MIT
//
//   phymul_soak [minutes 60] [backend cpu]
//
// Two bodies in contact, joined, pushed and grasped by a tool, made stiffer and softer, put back, saved, loaded and
// made anew, for as long as asked. Fails if memory grows after the first tenth of the time, or if a state is not
// finite. Prints a line for each twentieth.
#include <phymul/phymul.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "support/heap_in_use.h"

namespace phymul {
namespace {

constexpr double megabyte = 1e6;
constexpr double slack = 2 * megabyte;  // what the heap's own tables and the threads' caches may still take

double resident() {  // bytes
  std::size_t whole = 0, pages = 0;
  std::ifstream("/proc/self/statm") >> whole >> pages;
  return static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

double seconds() {
  using Seconds = std::chrono::duration<double>;
  return Seconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Model two_bodies() {
  Model low = make_block({0.04, 0.04, 0.02}, 8, 8, 4);
  set_material(low, {.young = 5e3, .poisson = 0.4, .density = 1000});
  Model high = moved(make_block({0.02, 0.02, 0.02}, 5, 5, 5), {0.01, 0.01, 0.0201});
  set_material(high, {.young = 1e4, .poisson = 0.3, .density = 1000});
  const std::vector<NamedBody> bodies{{"low", &low}, {"high", &high}};
  return merge_models(bodies);
}

/// One life of a solver over its scene: some tenths of a second of computing.
class Life {
 public:
  Life(const Model& model, std::shared_ptr<const TopologyTextures> tables, const std::string& backend)
      : scene_(model), tool_(add_scene(scene_)) {
    SolverOptions options{.damping = {.rate = 5.0}};
    options.sleep_tolerance = 1e-6;
    options.threads = 2;
    solver_ = make_solver(backend, std::move(tables), scene_, options);
    dt_ = 0.3 * solver_->stable_step();
    file_ = (std::filesystem::temp_directory_path() / ("phymul_soak_" + std::to_string(getpid()))).string();
  }

  std::int64_t live() {
    std::int64_t steps = 0;
    Recorder recorder(*solver_, scene_);
    StateHistory history(8, 1 << 20);
    double most_force = 0.0;
    int most_held = 0;
    for (int tick = 0; tick < 100; ++tick) {
      const double phase = 0.16 * tick;  // about 0.3 m/s
      tool_.move_to({.position = {0.02 + 1e-3 * std::sin(phase), 0.02, 0.0458 - 4e-4 * std::sin(0.5 * phase)}});
      if (tick % 20 == 5) tool_.grasp(0.002);
      if (tick % 20 == 15) tool_.release();
      if (tick % 25 == 0) scene_.scale_stiffness(tick % 50 == 0 ? 0.5 : 1.0);
      const StepReport report = recorder.step(8, 0.5 * dt_);
      if (!report.ok()) throw Error("a step failed: " + report.message());
      steps += report.steps;
      most_force = std::max(most_force, solver_->tool_force(tool_).force.norm());
      most_held = std::max(most_held, solver_->held(tool_));
      history.follow(*solver_, report);
      if (tick % 40 == 39) history.rewind(*solver_, solver_->time() - 20 * dt_);
    }
    save_state(*solver_, file_ + ".state");
    save_recording(recorder.recording(), file_ + ".rec");
    write_vtu(solver_->model(), solver_->read(), file_ + ".vtu");
    load_state(*solver_, file_ + ".state");
    read_recording(file_ + ".rec");
    read_mesh(file_ + ".vtu");
    if (most_force == 0.0 || most_held == 0) throw Error("the tool met nothing");
    if (!is_finite(solver_->read())) throw Error("a state is not finite");
    for (const char* ending : {".state", ".rec", ".vtu"}) std::filesystem::remove(file_ + ending);
    return steps;
  }

 private:
  static ToolHandle add_scene(Scene& scene) {
    const Model& model = scene.model();
    scene.fix("low/z0").gravity({0, 0, -9.81}).contacts({.friction = 0.3});
    const ToolHandle tool = scene.add_tool({.shape = Sphere{0.006}, .pose = {.position = {0.02, 0.02, 0.0466}}});
    scene.attach(model.group("high/z1"), World{}, {.stiffness = 1e3, .damping = 1.0});
    return tool;
  }

  Scene scene_;
  ToolHandle tool_;
  std::unique_ptr<Solver> solver_;
  double dt_ = 0.0;
  std::string file_;
};

int run(double minutes, const std::string& backend) {
  const Model model = two_bodies();
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model));
  const double start = seconds(), whole = 60.0 * minutes;
  double heap = 0.0, pages = 0.0;  // after the first tenth
  std::int64_t steps = 0, lives = 0;
  for (int part = 1; part <= 20; ++part) {
    do {
      steps += Life(model, tables, backend).live();
      ++lives;
    } while (seconds() - start < whole * part / 20);
    std::printf("%.1f min: %lld solvers, %lld steps, %.2f MB resident, %.3f MB of the heap\n", (seconds() - start) / 60,
                static_cast<long long>(lives), static_cast<long long>(steps), resident() / megabyte,
                test::heap_in_use() / megabyte);
    std::fflush(stdout);
    if (part == 2) heap = test::heap_in_use(), pages = resident();
  }
  const double more_heap = test::heap_in_use() - heap, more_pages = resident() - pages;
  std::printf("since the first tenth: %+.3f MB resident, %+.3f MB of the heap\n", more_pages / megabyte,
              more_heap / megabyte);
  return more_heap < slack / 20 && more_pages < slack ? 0 : 1;
}

}  // namespace
}  // namespace phymul

int main(int argc, char** argv) try {
  return phymul::run(argc > 1 ? std::atof(argv[1]) : 60.0, argc > 2 ? argv[2] : "cpu");
} catch (const std::exception& error) {
  std::fprintf(stderr, "phymul_soak: %s\n", error.what());
  return 1;
}
