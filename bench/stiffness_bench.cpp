// SPDX-License-Identifier: MIT
//
// What another stiffness costs while a scene runs: a step, a step after Scene::scale_stiffness, and a step of a solver
// made anew for a model that has it. Jittered tetrahedra, two materials, backend "cpu", one thread.
#include <benchmark/benchmark.h>
#include <phymul/phymul.h>

#include <memory>

namespace {

using namespace phymul;

constexpr Material tissue{10e3, 0.4, 1000.0};
constexpr Material tumour(double factor) {
  return {factor * 30e3, 0.4, 1000.0};
}

Model make_model(double factor, int cells) {
  const double side = cells * 0.005;
  Model model = make_tetrahedral_block({side, side, side}, cells, cells, cells, 0.2, 1);
  set_material(model, tissue);
  set_material(model, tumour(factor), [=](const Vec3& place) { return place.x() < 0.3 * side; });
  return model;
}

struct Run {
  explicit Run(Model made) : model(std::move(made)), scene(model) {
    scene.fix("z0").gravity({0, 0, -9.81});
    solver = make_solver("cpu", model, scene, {}, {.damping = {.rate = 5.0}, .threads = 1});
  }
  Model model;
  Scene scene;
  std::unique_ptr<Solver> solver;
};

enum class Way { none, scaled, anew };

void stiffness_step(benchmark::State& state, Way way) {
  const auto cells = static_cast<int>(state.range(0));
  auto run = std::make_unique<Run>(make_model(1.0, cells));
  if (way == Way::scaled) run->scene.scale_stiffness(1.0);
  const double dt = 0.2 * run->solver->stable_step();
  bool softer = false;
  for (auto _ : state) {
    softer = !softer;
    const double factor = softer ? 0.5 : 1.0;
    if (way == Way::scaled) run->scene.scale_stiffness(tumour(1.0), factor);
    if (way == Way::anew) run = std::make_unique<Run>(make_model(factor, cells));
    if (!run->solver->step(1, dt).ok()) state.SkipWithError("the step failed");
  }
  state.counters["particles"] = run->model.particle_count();
}
BENCHMARK_CAPTURE(stiffness_step, as_before, Way::none)->Arg(13)->Arg(26)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(stiffness_step, scaled, Way::scaled)->Arg(13)->Arg(26)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(stiffness_step, made_anew, Way::anew)->Arg(13)->Arg(26)->Unit(benchmark::kMicrosecond);

}  // namespace
