// SPDX-License-Identifier: MIT
#include "step_times.h"

#include <phymul/phymul.h>
#include <phymul/topology_textures.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace {

constexpr double spacing = 0.0025;  // m
constexpr double stretch = 1.05;    // of the start: a body at rest would have nothing to compute but zeros
constexpr double shortest = 0.1;    // s, of a call; a browser's clock has steps of up to a millisecond
constexpr int repeats = 3;

phymul::Model body_of(int side) {
  if (side == 0) return phymul::make_cylinder(0.010, 0.040, 3, 8, 11);
  const double length = (side - 1) * spacing;
  return phymul::make_block({length, length, length}, side - 1, side - 1, side - 1, 6);
}

}  // namespace

StepTime step_time(int side, const std::string& backend) {
  const phymul::Model model = body_of(side);
  const phymul::Scene scene(model);
  const auto topology =
      std::make_shared<const phymul::TopologyTextures>(build_topology(model, {.reaction = phymul::Reaction::shared}));
  phymul::SolverOptions options;
  options.damping.factor = 0.99;
  options.threads = 1;
  options.gl.context = phymul::GlContext::current;
  const auto solver = phymul::make_solver(backend, topology, scene, options);
  phymul::State start = phymul::rest_state(model);
  for (phymul::Vec3& x : start.position) x.z() *= stretch;
  phymul::State end;
  const double dt = 0.2 * solver->stable_step();
  const auto seconds_of = [&](int steps) {
    solver->reset(start);
    solver->read(end);
    const auto begin = std::chrono::steady_clock::now();
    const phymul::StepReport report = solver->step(steps, dt);
    solver->read(end);  // a device might not have begun yet
    if (!report.ok()) throw phymul::Error(report.message());
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  int steps = 2;
  double once = seconds_of(steps);
  while (once < shortest) {
    steps = once > 0.1 * shortest ? static_cast<int>(1.2 * steps * shortest / once) + 1 : 8 * steps;
    once = seconds_of(steps);
  }
  std::vector<double> times{once};
  while (static_cast<int>(times.size()) < repeats && once < 0.5) times.push_back(seconds_of(steps));
  std::ranges::sort(times);
  return {model.particle_count(), times[times.size() / 2] / steps};
}
