// SPDX-License-Identifier: MIT
#include "truth_table.h"

#include <phymul/error.h>

#include <cstdio>
#include <fstream>
#include <sstream>

namespace phymul::bench {

TruthTable::TruthTable(const std::string& measured, const std::string& folder)
    : rows_(folder + "/truth.csv", {"case", "quantity", "mesh", "particles", "ours", "low", "high"}),
      curves_(folder + "/truth_curves.csv", {"case", "curve", "x", "y"}) {
  std::ifstream in(measured);
  if (!in) throw Error(measured + ": cannot be read; expected a CSV file with the columns case,quantity,low,high");
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#' || line.starts_with("case,")) continue;
    std::istringstream fields(line);
    std::string it, quantity, low, high;
    std::getline(fields, it, ','), std::getline(fields, quantity, ','), std::getline(fields, low, ',');
    std::getline(fields, high, ',');
    known_[it + "," + quantity] = {std::stod(low), std::stod(high)};
  }
}

const Known& TruthTable::measured(const std::string& it, const std::string& quantity) const {
  const auto found = known_.find(it + "," + quantity);
  if (found == known_.end()) throw Error("no measured value of " + it + ", " + quantity);
  return found->second;
}

void TruthTable::row(const std::string& it, const std::string& quantity, const std::string& mesh, int particles,
                     double ours, const Known& known) {
  rows_.row({it, quantity, mesh, std::to_string(particles), field(ours), field(known.low), field(known.high)});
  errors_[it + "; " + quantity + "; " + mesh] = ours / known.mean() - 1;
  std::printf("%-12s %-34s %-30s %6d %11.5g %11.5g  %+.2f %%\n", it.c_str(), quantity.c_str(), mesh.c_str(), particles,
              ours, known.mean(), 100 * (ours / known.mean() - 1));
  std::fflush(stdout);
}

void TruthTable::curve(const std::string& it, const std::string& name, double x, double y) {
  curves_.row({it, name, field(x), field(y)});
}

Simulation simulation(Model model, const Material& material, const std::string& backend) {
  SimulationOptions options{.material = material, .backend = backend};
  options.solver.threads = 1;  // bodies are small, and the machine may be busy
  return Simulation(std::move(model), std::move(options));
}

Simulation silicone_beam(int across, const Material& material, const std::string& backend) {
  Simulation sim = simulation(make_block({0.1, 0.03, 0.03}, 10 * across / 3, across, across), material, backend);
  sim.scene().fix("x0").gravity({0, 0, -9.80709});
  return sim;
}

void impose(Scene& scene, std::vector<Index> particles, const Vec3& u, const std::string& driven,
            const std::string& held) {
  Load load = push(LoadType::translation, u, std::move(particles));
  for (int axis = 0; axis < 3; ++axis) {
    const char name = "xyz"[axis];
    load.axes[axis] = held.find(name) != std::string::npos     ? Axis::held
                      : driven.find(name) == std::string::npos ? Axis::free
                      : u.norm() > 0.0                         ? Axis::driven
                                                               : Axis::held;
  }
  scene.add(std::move(load));
}

Load push(LoadType type, const Vec3& each, std::vector<Index> particles) {
  Load load;
  load.type = type;
  load.particles = std::move(particles);
  load.direction = each;
  load.events = {{0.0, each.norm()}};
  return load;
}

VecList rest(Simulation& sim, const std::string& name, double tolerance) {
  const StaticResult result = sim.solve_static({.tolerance = tolerance, .most_evaluations = 20000});
  if (!result.converged()) throw Error(name + ": " + result.message());
  return displacement(sim);
}

VecList displacement(const Simulation& sim) {
  VecList u = sim.state().position;
  for (std::size_t i = 0; i < u.size(); ++i) u[i] -= sim.model().rest[i];
  return u;
}

Vec3 at_point(const Simulation& sim, const Vec3& point) {
  return Skin(sim.model(), std::span(&point, 1), 2.0).deform(sim.state().position)[0] - point;
}

std::string text(const char* format, double a, double b, double c) {
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, format, a, b, c);
  return buffer;
}

}  // namespace phymul::bench
