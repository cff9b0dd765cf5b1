// SPDX-License-Identifier: MIT
//
// What SolverOptions::max_substeps saves. A cube of 0.1 m with a ball, a hundred times as stiff, in 2 % of its volume,
// held at one side under gravity; backend cpu, one thread. Three solvers take turns: the cube without the ball, with it
// by one step for all, and with it by substeps. Medians over the turns of processor time per second of physics, and the
// error of each against a fifth of its body's shortest step.
//   local_steps_table [cells of an edge [turns]]
#include <phymul/phymul.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "machine_ceilings.h"
#include "usage.h"

namespace {

using namespace phymul;

constexpr double edge = 0.1, seconds = 0.1;  // m, s
const Material soft{5e3, 0.45, 1000.0}, stiff{500e3, 0.45, 1000.0};

struct Case {
  Case(const char* name_in, Model body, int max_substeps) : name(name_in), model(std::move(body)) {
    scene.fix("x0").gravity({0, 0, -1.0});
    solver = make_solver("cpu", model, scene, {}, {.max_substeps = max_substeps, .threads = 1});
  }
  /// Processor time, s.
  double fall(double dt) {
    solver->reset();
    const int steps = static_cast<int>(seconds / dt) + 1;
    const double begin = bench::processor_seconds();
    if (!solver->step(steps, seconds / steps).ok()) throw Error("a step failed");
    return bench::processor_seconds() - begin;
  }
  const char* name;
  Model model;
  Scene scene{model};
  std::unique_ptr<Solver> solver;
  std::vector<double> cost;
};

double difference(const VecList& a, const VecList& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i] - b[i]).norm());
  return most;
}

void measure(const char* kind, const Model& shape, int turns) {
  Model plain = shape, ball = shape;
  set_material(plain, soft);
  set_material(ball, soft);
  const Vec3 middle = Vec3::Constant(0.5 * edge);
  set_material(ball, stiff, [&](const Vec3& place) { return (place - middle).norm() < 0.168 * edge; });
  std::vector<std::unique_ptr<Case>> cases;
  cases.push_back(std::make_unique<Case>("without the ball", plain, 1));
  cases.push_back(std::make_unique<Case>("one step for all", ball, 1));
  cases.push_back(std::make_unique<Case>("substeps", ball, 32));
  const double shortest = cases[1]->solver->stable_step();
  std::vector<VecList> fine;
  for (const int k : {0, 1}) {
    cases[static_cast<std::size_t>(k)]->fall(0.2 * shortest);
    fine.push_back(cases[static_cast<std::size_t>(k)]->solver->read().position);
  }
  for (int turn = 0; turn < turns; ++turn) {
    for (auto& one : cases) one->cost.push_back(one->fall(0.5 * one->solver->stable_step()) / seconds);
  }
  std::printf("%s, %d particles, %s\n", kind, shape.particle_count(), cases[0]->solver->device().c_str());
  for (std::size_t k = 0; k < cases.size(); ++k) {
    Case& one = *cases[k];
    std::ranges::sort(one.cost);
    const VecList& exact = fine[std::min<std::size_t>(k, 1)];
    std::printf("  %-17s: stable step %.3g s, %d substeps, %.3g s per second, error in time %.2f %%\n", one.name,
                one.solver->stable_step(), one.solver->substeps(), one.cost[one.cost.size() / 2],
                100.0 * difference(one.solver->read().position, exact) / difference(exact, shape.rest));
  }
  std::vector<double> ratio;
  for (std::size_t turn = 0; turn < cases[0]->cost.size(); ++turn) {
    ratio.push_back(cases[2]->cost[turn] / cases[0]->cost[turn]);
  }
  std::printf("  substeps over without the ball: %.2f times\n", ratio[ratio.size() / 2]);
}

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(
          argc, argv,
          "usage: local_steps_table [cells of an edge [turns]]   what SolverOptions::max_substeps saves; "
          "12, 20 and 28 cells, 9 turns by default")) {
    return 0;
  }
  const std::vector<int> sizes = argc > 1 ? std::vector<int>{std::max(2, std::atoi(argv[1]))} : std::vector{12, 20, 28};
  const int turns = argc > 2 ? std::max(1, std::atoi(argv[2])) : 9;
  const phymul::Vec3 size = phymul::Vec3::Constant(edge);
  for (const int cells : sizes) {
    measure("tetrahedra", phymul::make_tetrahedral_block(size, cells, cells, cells, 0.2, 7), turns);
    measure("hexahedra", phymul::make_block(size, cells, cells, cells), turns);
  }
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
