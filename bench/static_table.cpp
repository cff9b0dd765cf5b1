// SPDX-License-Identifier: MIT
//
// Simulation::solve_static beside run_to_rest: evaluations of forces, and times on one thread. A cantilever of
// unstructured tetrahedra under gravity, by size, Poisson's ratio and load.
#include <phymul/phymul.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "stopwatch.h"
#include "usage.h"

namespace {

using namespace phymul;

Simulation cantilever(int across, double poisson, double gravity) {
  SimulationOptions options{.material = Material{.young = 10e3, .poisson = poisson, .density = 1000}, .backend = "cpu"};
  options.solver.threads = 1;
  Simulation sim(make_tetrahedral_block({0.2, 0.05, 0.05}, 4 * across, across, across, 0.2, 1), options);
  sim.scene().fix("x0").gravity({0, 0, -9.81 * gravity});
  sim.solver();
  return sim;
}

void print_row(int across, double poisson, double gravity, bool steps) {
  Simulation solved = cantilever(across, poisson, gravity);
  double begin = processor_seconds();
  const StaticResult result = solved.solve_static();
  const double solving = processor_seconds() - begin;
  std::printf("%9d %4.2f %6.3f  %-7s %5d %8.1e %8.4f s", solved.model().particle_count(), poisson, gravity,
              result.converged() ? "at rest" : "not", result.evaluations, result.residual, solving);
  if (steps) {
    Simulation stepped = cantilever(across, poisson, gravity);
    begin = processor_seconds();
    const RestResult rest = stepped.run_to_rest(40'000);
    const double stepping = processor_seconds() - begin;
    std::printf("  %-7s %6d %8.3f s %6.1f", rest.converged() ? "at rest" : "not", rest.report.steps, stepping,
                stepping / solving);
  }
  std::printf("\n");
  std::fflush(stdout);
}

/// A load that grows by 1 % from call to call, as of slow manipulation.
void print_following_row(int across, double poisson, double tolerance, bool predict) {
  constexpr int calls = 20;
  double gravity = 0.02;
  Simulation sim = cantilever(across, poisson, gravity);
  sim.solve_static({.tolerance = 1e-8, .predict = predict});
  int evaluations = 0;
  double seconds = 0.0;
  for (int k = 0; k < calls; ++k) {
    gravity *= 1.01;
    sim.scene().gravity({0, 0, -9.81 * gravity});
    const double begin = processor_seconds();
    evaluations += sim.solve_static({.tolerance = tolerance, .predict = predict}).evaluations;
    seconds += processor_seconds() - begin;
  }
  const State followed = sim.state();
  sim.solve_static({.tolerance = 1e-9});
  const State rest = sim.state();
  double off = 0.0;
  for (std::size_t i = 0; i < rest.position.size(); ++i) {
    off = std::max(off, (followed.position[i] - rest.position[i]).norm());
  }
  std::printf("%9d %4.2f %8.0e %-9s %6.1f %8.2f ms %8.4f %%\n", sim.model().particle_count(), poisson, tolerance,
              predict ? "predicted" : "", static_cast<double>(evaluations) / calls, 1e3 * seconds / calls,
              100.0 * off / sim.max_displacement());
  std::fflush(stdout);
}

/// A ball of 2 cm that indents a block of 8 x 8 x 5 cm by 5 mm.
Simulation pressed(int across, double poisson, ToolContact contact) {
  SimulationOptions options{.material = Material{.young = 10e3, .poisson = poisson, .density = 1000}, .backend = "cpu"};
  options.solver.threads = 1;
  Simulation sim(make_block({0.08, 0.08, 0.05}, across + 1, across + 1, 5 * across / 8 + 1), options);
  const Tool ball{.shape = Sphere{0.02}, .pose = {.position = {0.04, 0.04, 0.065}}, .contact = contact};
  sim.scene().fix("z0").add_tool("ball", ball);
  sim.solver();
  return sim;
}

/// The ball goes 0.05 mm deeper in each call, and as far aside.
void print_moving_tool_row(int across, double poisson, ToolContact contact, bool predict) {
  constexpr int calls = 20;
  Simulation sim = pressed(across, poisson, contact);
  const auto ball = sim.scene().tool("ball");
  sim.solve_static({.tolerance = 1e-6, .predict = predict});
  int evaluations = 0, most = 0;
  double seconds = 0.0;
  for (int k = 1; k <= calls; ++k) {
    ball.move_to({.position = {0.04 + 5e-5 * k, 0.04, 0.065 - 5e-5 * k}});
    const double begin = processor_seconds();
    const StaticResult result = sim.solve_static({.tolerance = 1e-3, .predict = predict});
    seconds += processor_seconds() - begin;
    evaluations += result.evaluations;
    most = std::max(most, result.evaluations);
  }
  const double force = sim.force_on(ball).force.norm();
  for (int k = 0; k < 6; ++k) sim.solve_static({.tolerance = 1e-6, .predict = true});
  const double at_rest = sim.force_on(ball).force.norm();
  std::printf("%9d %4.2f %-9s %-9s %6.1f (at most %3d) %8.2f ms %8.3f %%\n", sim.model().particle_count(), poisson,
              contact == ToolContact::surface ? "surface" : "particles", predict ? "predicted" : "",
              static_cast<double>(evaluations) / calls, most, 1e3 * seconds / calls, 100.0 * (force / at_rest - 1.0));
  std::fflush(stdout);
}

void print_tool_row(int across, ToolContact contact, bool steps) {
  Simulation solved = pressed(across, 0.3, contact);
  double begin = processor_seconds();
  const StaticResult result = solved.solve_static();
  const double solving = processor_seconds() - begin;
  std::printf("%9d %-9s %-7s %5d %8.4f s %7.4f N", solved.model().particle_count(),
              contact == ToolContact::surface ? "surface" : "particles", result.converged() ? "at rest" : "not",
              result.evaluations, solving, solved.force_on(solved.scene().tool("ball")).force.norm());
  if (steps) {
    Simulation stepped = pressed(across, 0.3, contact);
    begin = processor_seconds();
    const RestResult rest = stepped.run_to_rest(40'000);
    const double stepping = processor_seconds() - begin;
    std::printf("  %-7s %6d %8.3f s %7.4f N %6.1f", rest.converged() ? "at rest" : "not", rest.report.steps, stepping,
                stepped.force_on(stepped.scene().tool("ball")).force.norm(), stepping / solving);
  }
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(
          argc, argv,
          "static_table [cells across, at most [steps]], default 16 and 1\n"
          "Evaluations and processor time of solve_static() to a residual of 1e-6, for a cantilever of\n"
          "4, 8 and 16 cells across, also after changes of its load by 1 %, and for a ball on a block of\n"
          "twice as many, also one that moves; with steps 1 also of run_to_rest(), which takes minutes.")) {
    return 0;
  }
  const int most = argc > 1 ? std::atoi(argv[1]) : 16;
  const bool steps = argc <= 2 || std::atoi(argv[2]) != 0;
  std::printf("particles nu   load/g  solve_static: evaluations, residual, time; run_to_rest: steps, time; ratio\n");
  for (const double gravity : {0.001, 0.02, 1.0}) {
    for (const double poisson : {0.3, 0.45, 0.49}) {
      for (int across = 4; across <= most; across *= 2) print_row(across, poisson, gravity, steps);
    }
  }
  std::printf(
      "particles nu  tolerance, a load that grows by 1 %% a call: evaluations and time of a call; off, of the "
      "displacement\n");
  for (const double poisson : {0.3, 0.45, 0.49}) {
    for (const double tolerance : {1e-6, 1e-3}) {
      for (const int across : {4, 8, 13, 16}) {
        if (across > most) continue;
        for (const bool predict : {false, true}) print_following_row(across, poisson, tolerance, predict);
      }
    }
  }
  std::printf(
      "particles nu  a ball that goes 0.05 mm deeper with each call: evaluations and time of a call; off, of the "
      "force\n");
  for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
    for (const double poisson : {0.3, 0.45}) {
      for (int across = 8; across <= 2 * most; across *= 2) {
        for (const bool predict : {false, true}) print_moving_tool_row(across, poisson, contact, predict);
      }
    }
  }
  std::printf("particles tool meets  solve_static: evaluations, time, force; run_to_rest: steps, time, force; ratio\n");
  for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
    for (int across = 8; across <= 2 * most; across *= 2) print_tool_row(across, contact, steps);
  }
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
