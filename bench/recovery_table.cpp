// SPDX-License-Identifier: MIT
//
// From which broken states a body finds back to its rest shape: a cube of 125 particles of soft tissue, 12,000 steps
// with d = 0.99, with and without the cut of SolverOptions::max_displacement_per_step. `recovery_table [backend [share
// of the stable step]]`, default reference and 0.5; takes minutes in the reference backend.
#include <cstdio>
#include <limits>
#include <string>

#include "support/failure_states.h"
#include "usage.h"

namespace {

using namespace phymul;
using namespace phymul::test;

constexpr int cells = 4;
constexpr double side = 0.04;
constexpr int steps = 12000;

struct Setting {
  std::string backend;
  double share = 0.5;  // of the stable step
  double max_displacement_per_step = SolverOptions{}.max_displacement_per_step;
};

void print_row(const char* name, double poisson, const TopologyOptions& topology, const Setting& setting) {
  Model model = make_block({side, side, side}, cells, cells, cells, 6);
  set_material(model, soft_tissue(poisson));
  const Scene scene(model);
  SolverOptions options;
  options.damping.factor = 0.99;
  options.max_displacement_per_step = setting.max_displacement_per_step;
  const auto solver = make_solver(setting.backend, model, scene, topology, options);
  int returned = 0;
  std::string lost;
  for (const FailureState& failure : failure_states()) {
    std::mt19937 bits(5);
    State state = rest_state(model);
    failure.apply(state.position, side, side / cells, bits);
    solver->reset(state);
    const StepReport report = solver->step(steps, setting.share * solver->stable_step());
    // The energy of a uniform strain of about 0.5 %: nothing folded is left.
    const bool rests = report.ok() && solver->energy().elastic < 1e-5 * soft_tissue().young * side * side * side;
    returned += rests;
    if (!rests) lost += std::string(lost.empty() ? "" : ", ") + failure.name + (report.ok() ? "" : " (ran away)");
  }
  std::printf("%-28s nu %.2f  step %.1f of the limit, push %g: %2d of %zu; lost: %s\n", name, poisson, setting.share,
              setting.max_displacement_per_step, returned, failure_states().size(), lost.c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(argc, argv,
                          "recovery_table [backend [share of the stable step]], default reference and 0.5\n"
                          "From which of 14 broken states a cube of 125 particles comes back, by volume law and "
                          "Poisson's ratio; takes minutes in the reference backend, with cpu less.")) {
    return 0;
  }
  Setting setting;
  setting.backend = argc > 1 ? argv[1] : "reference";
  if (argc > 2) setting.share = std::atof(argv[2]);
  for (const double push : {setting.max_displacement_per_step, std::numeric_limits<double>::infinity()}) {
    setting.max_displacement_per_step = push;
    for (const double poisson : {0.3, 0.45}) {
      print_row("bounded volume law", poisson, {}, setting);
      print_row("quadratic volume law", poisson, {.volume_law = VolumeLaw::quadratic}, setting);
    }
  }
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
