// SPDX-License-Identifier: MIT
//
// What joints cost a step of the backend cpu, on one thread: solvers of one body of 2,744 particles, with more and more
// springs from its surface to the world, take turns. Medians of processor time over the turns.
//   joint_cost [turns]
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
  Case(const Model& model, int springs_in) : springs(springs_in), scene(model) {
    scene.fix("z0").gravity({0, 0, -9.81});
    const std::vector<Index> top = model.group("z1");  // 196
    Joint joint{.springs = {}, .stiffness = 5.0, .damping = 0.001};
    for (int k = 0; k < springs; ++k) {
      const Index i = top[static_cast<std::size_t>(k) % top.size()];
      joint.springs.push_back({at_particle(i), at_world(model.rest[i] + Vec3(0, 0, 0.01))});
    }
    if (springs > 0) scene.add_joint(joint);
    solver = make_solver("cpu", model, scene, {}, {.damping = {.rate = 5.0}, .threads = 1});
  }
  int springs;
  Scene scene;
  std::unique_ptr<Solver> solver;
  std::vector<double> us;  // a step
};

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(argc, argv,
                          "usage: joint_cost [turns]   what joints cost a step of cpu; 41 turns by default")) {
    return 0;
  }
  const int turns = argc > 1 ? std::max(1, std::atoi(argv[1])) : 41;
  Model model = make_tetrahedral_block({0.06, 0.06, 0.06}, 13, 13, 13, 0.2, 1);
  set_material(model, {.young = 10e3, .poisson = 0.4, .density = 1000});
  std::vector<std::unique_ptr<Case>> cases;
  for (const int springs : {0, 20, 200, 2000}) cases.push_back(std::make_unique<Case>(model, springs));
  for (int turn = 0; turn < turns; ++turn) {
    for (auto& one : cases) {
      const double begin = bench::processor_seconds();
      if (!one->solver->step(steps_a_turn, 0.3 * one->solver->stable_step()).ok()) return 1;
      one->us.push_back(1e6 * (bench::processor_seconds() - begin) / steps_a_turn);
    }
  }
  std::printf("%d particles, %s; microseconds a step\n", model.particle_count(), cases[0]->solver->device().c_str());
  for (auto& one : cases) {
    std::ranges::sort(one->us);
    std::printf("%4d springs: %.1f\n", one->springs, one->us[one->us.size() / 2]);
  }
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
