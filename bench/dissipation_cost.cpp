// SPDX-License-Identifier: MIT
//
// What dissipation costs a step of the backend cpu, on one thread: solvers of one body of 2,744 particles without it,
// with either kind and with both take turns. Medians of processor time over the turns, and step limits.
//   dissipation_cost [turns]
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

constexpr int steps_a_turn = 50;

struct Case {
  Case(const char* name_in, Model body, double retardation_time, double relaxation_strength)
      : name(name_in), model(std::move(body)) {
    set_material(model, {.young = 10e3,
                         .poisson = 0.4,
                         .density = 1000,
                         .retardation_time = retardation_time,
                         .relaxation_strength = relaxation_strength,
                         .relaxation_time = 0.5});
    scene.fix("z0").gravity({0, 0, -9.81});
    solver = make_solver("cpu", model, scene, {}, {.damping = {.rate = 5.0}, .threads = 1});
  }
  const char* name;
  Model model;
  Scene scene{model};
  std::unique_ptr<Solver> solver;
  std::vector<double> us;  // a step
};

void measure(const char* body, const Model& model, int turns) {
  std::vector<std::unique_ptr<Case>> cases;
  cases.push_back(std::make_unique<Case>("none", model, 0.0, 0.0));
  cases.push_back(std::make_unique<Case>("retardation", model, 1e-3, 0.0));
  cases.push_back(std::make_unique<Case>("relaxation", model, 0.0, 1.0));
  cases.push_back(std::make_unique<Case>("both", model, 1e-3, 1.0));
  for (int turn = 0; turn < turns; ++turn) {
    for (auto& one : cases) {
      const double begin = bench::processor_seconds();
      if (!one->solver->step(steps_a_turn, 0.3 * one->solver->stable_step()).ok()) throw Error("a step failed");
      one->us.push_back(1e6 * (bench::processor_seconds() - begin) / steps_a_turn);
    }
  }
  std::printf("%s of %d particles, %s\n", body, model.particle_count(), cases[0]->solver->device().c_str());
  for (auto& one : cases) {
    std::ranges::sort(one->us);
    std::printf("  %-11s: %.1f us a step, stable step %.3g s\n", one->name, one->us[one->us.size() / 2],
                one->solver->stable_step());
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(
          argc, argv, "usage: dissipation_cost [turns]   what dissipation costs a step of cpu; 41 turns by default")) {
    return 0;
  }
  const int turns = argc > 1 ? std::max(1, std::atoi(argv[1])) : 41;
  measure("tetrahedra", make_tetrahedral_block({0.06, 0.06, 0.06}, 13, 13, 13, 0.2, 1), turns);
  measure("hexahedra", make_block({0.06, 0.06, 0.06}, 13, 13, 13), turns);
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
