// SPDX-License-Identifier: MIT
//
// What SolverOptions::max_substeps saves. A cube of 0.1 m with a ball, a hundred times as stiff, in 2 % of its volume,
// held at one side under gravity; backend cpu, one thread. Three solvers take turns: the cube without the ball, with it
// by one step for all, and with it by substeps. Medians over the turns of processor time per second of physics, and the
// error of each against a fifth of its body's shortest step.
// Then a liver of some 2,500 particles with a duct of 700 at a third of its spacing, and two places of the liver tied
// by a lock of 27 springs: the liver alone, with both by one step for all, and with both by
// SolverOptions::max_substeps.
//   local_steps_table [cells of an edge [turns]]
#include <phymul/phymul.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numeric>
#include <vector>

#include "stopwatch.h"
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
    const double begin = processor_seconds();
    if (!solver->step(steps, seconds / steps).ok()) throw Error("a step failed");
    return processor_seconds() - begin;
  }
  const char* name;
  Model model;
  Scene scene{model};
  std::unique_ptr<Solver> solver;
  std::vector<double> cost;
};

/// us of processor time per step, and s per second of physics at half the stable step, of solvers that take turns.
void measure_duct(int turns) {
  constexpr double h = 8.7e-3;  // m
  Model liver = make_body(solid_ellipsoid({0, 0, 0}, {0.08, 0.06, 0.04}), {.spacing = h});
  Model duct = make_body(solid_capsule({-0.038, 0, 0.047}, {0.038, 0, 0.047}, 0.0048),
                         {.spacing = h / 3.0, .most_volume_error = 0.3});
  set_material(liver, soft);
  set_material(duct, soft);
  const std::vector<NamedBody> bodies{{"liver", &liver}, {"duct", &duct}};
  const Model both = merge_models(bodies);
  const auto near = [&](const Vec3& place) {
    std::vector<Index> found(liver.rest.size());
    std::iota(found.begin(), found.end(), 0);
    std::ranges::sort(found, {}, [&](Index i) { return (liver.rest[i] - place).norm(); });
    found.resize(27);
    return found;
  };
  const std::vector<Index> left = near({-0.02, 0, -0.04}), right = near({0.02, 0, -0.04});
  Joint lock{.springs = {}, .stiffness = 2.6e4};
  for (std::size_t k = 0; k < left.size(); ++k) {
    lock.springs.push_back({.a = at_particle(left[k]), .b = at_particle(right[k])});
  }
  struct Row {
    const char* name;
    const Model* model;
    bool locked;
    int max_substeps;
    std::unique_ptr<Scene> scene{};
    std::unique_ptr<Solver> solver{};
    std::vector<double> cost{};
  };
  std::vector<Row> rows;
  rows.push_back({"liver alone", &liver, false, 1});
  rows.push_back({"with duct", &both, false, 1});
  rows.push_back({"with duct and lock", &both, true, 1});
  rows.push_back({"liver alone, max_substeps 16", &liver, false, 16});
  rows.push_back({"with duct, max_substeps 16", &both, false, 16});
  rows.push_back({"with duct and lock, max_substeps 16", &both, true, 16});
  for (Row& row : rows) {
    row.scene = std::make_unique<Scene>(*row.model);
    if (row.locked) row.scene->add_joint("lock", lock);
    row.solver = make_solver("cpu", *row.model, *row.scene, {}, {.max_substeps = row.max_substeps, .threads = 1});
  }
  for (int turn = 0; turn < turns; ++turn) {
    for (Row& row : rows) {
      const double begin = processor_seconds();
      if (!row.solver->step(100, 0.5 * row.solver->stable_step()).ok()) throw Error("a step failed");
      row.cost.push_back((processor_seconds() - begin) / 100.0);
    }
  }
  std::printf("liver of %d particles, duct of %d\n", liver.particle_count(), duct.particle_count());
  double alone = 0.0;
  for (Row& row : rows) {
    const double step = median(row.cost), cost = step / (0.5 * row.solver->stable_step());
    if (&row == &rows.front()) alone = cost;
    std::printf("  %-36s stable step %.3g s, %.1f us per step, %.3g s per second, %.2f times\n", row.name,
                row.solver->stable_step(), 1e6 * step, cost, cost / alone);
  }
}

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
    const Case& one = *cases[k];
    const VecList& exact = fine[std::min<std::size_t>(k, 1)];
    std::printf("  %-17s: stable step %.3g s, %d substeps, %.3g s per second, error in time %.2f %%\n", one.name,
                one.solver->stable_step(), one.solver->substeps(), median(one.cost),
                100.0 * difference(one.solver->read().position, exact) / difference(exact, shape.rest));
  }
  std::vector<double> ratio;
  for (std::size_t turn = 0; turn < cases[0]->cost.size(); ++turn) {
    ratio.push_back(cases[2]->cost[turn] / cases[0]->cost[turn]);
  }
  std::printf("  substeps over without the ball: %.2f times\n", median(ratio));
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
  measure_duct(5 * turns);
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
