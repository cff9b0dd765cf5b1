// SPDX-License-Identifier: MIT
//
// What threads cost a step of the backend cpu, on one thread: solvers of one body of 2,744 particles, with free threads
// and with stitches, take turns. Medians of processor time over the turns, and ratios to the step without threads.
//   thread_cost [turns]
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
  /// A free thread of so many nodes (0: none), held at one end, and so many stitches under tension.
  Case(const Model& model, int nodes_in, int stitches_in) : nodes(nodes_in), stitches(stitches_in), scene(model) {
    scene.fix("z0").gravity({0, 0, -9.81});
    if (nodes > 0) {
      const Thread constants{.length = 3e-3 * (nodes - 1), .segment = 3e-3};
      scene.add_thread(constants, {0, 0, 0.2}, {1, 0, 0}).hold(0, {0, 0, 0.2});
    }
    for (int k = 0; k < stitches; ++k) {
      const double y = 0.06 * (k + 0.5) / stitches;
      const ThreadHandle thread = scene.sew(
          Thread{}, VecList{Vec3(0.02, y, 0.06), Vec3(0.026, y, 0.055), Vec3(0.034, y, 0.055), Vec3(0.04, y, 0.06)});
      thread.pull(ThreadTip::first, {0.02, 0, 0});
      thread.pull(ThreadTip::last, {-0.02, 0, 0});
    }
    solver = make_solver("cpu", model, scene, {}, {.damping = {.rate = 5.0}, .threads = 1});
  }
  int nodes, stitches;
  Scene scene;
  std::unique_ptr<Solver> solver;
  std::vector<double> us;  // a step
};

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(argc, argv,
                          "usage: thread_cost [turns]   what threads cost a step of cpu; 41 turns by default")) {
    return 0;
  }
  const int turns = argc > 1 ? std::max(1, std::atoi(argv[1])) : 41;
  Model model = make_tetrahedral_block({0.06, 0.06, 0.06}, 13, 13, 13, 0.2, 1);
  set_material(model, {.young = 10e3, .poisson = 0.4, .density = 1000});
  std::vector<std::unique_ptr<Case>> cases;
  for (const auto& [nodes, stitches] : {std::pair{0, 0}, {2, 0}, {100, 0}, {300, 0}, {0, 1}, {0, 2}, {0, 8}}) {
    cases.push_back(std::make_unique<Case>(model, nodes, stitches));
  }
  for (int turn = 0; turn < turns; ++turn) {
    for (auto& one : cases) {
      const double begin = bench::processor_seconds();
      if (!one->solver->step(steps_a_turn, 0.3 * one->solver->stable_step()).ok()) return 1;
      one->us.push_back(1e6 * (bench::processor_seconds() - begin) / steps_a_turn);
    }
  }
  std::printf("%d particles, %s; microseconds a step\n", model.particle_count(), cases[0]->solver->device().c_str());
  double without = 0.0;
  for (auto& one : cases) {
    std::ranges::sort(one->us);
    const double median = one->us[one->us.size() / 2];
    if (one->nodes == 0 && one->stitches == 0) without = median;
    std::printf("thread of %3d nodes, %d stitches: %7.1f, %+7.1f, ratio %.3f\n", one->nodes, one->stitches, median,
                median - without, median / without);
  }
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
