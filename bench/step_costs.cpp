// SPDX-License-Identifier: MIT
//
// What joints, threads and materials that dissipate cost a step of the backend cpu, on one thread: solvers of one body
// of 2,744 particles with more and more of them take turns. Medians of processor time over the turns, and ratios to the
// first, which has none. Walls: thin bodies of about as many particles beside that body, and one of them with a fluid.
//   step_costs joints|threads|dissipation|walls [turns]
#include <phymul/phymul.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "stopwatch.h"
#include "usage.h"

namespace {

using namespace phymul;

constexpr const char* usage =
    "usage: step_costs joints|threads|dissipation|walls [turns]   what these cost a step of cpu; 41 turns by default";
constexpr int steps_a_turn = 50;

struct Case {
  Case(std::string name_in, const Model& model, const std::function<void(Scene&)>& add = {})
      : name(std::move(name_in)), scene(model) {
    const double low = std::ranges::min_element(model.rest, {}, [](const Vec3& x) { return x.z(); })->z();
    scene.fix(model.particles_in([low](const Vec3& x) { return x.z() < low + 1e-9; })).gravity({0, 0, -9.81});
    if (add) add(scene);
    solver = make_solver("cpu", model, scene, {}, {.damping = {.rate = 5.0}, .threads = 1});
  }
  std::string name;
  Scene scene;
  std::unique_ptr<Solver> solver;
  std::vector<double> us;  // a step
};
using Cases = std::vector<std::unique_ptr<Case>>;

void measure(const char* body, Cases cases, int turns) {
  for (int turn = 0; turn < turns; ++turn) {
    for (auto& one : cases) {
      const double begin = processor_seconds();
      if (!one->solver->step(steps_a_turn, 0.3 * one->solver->stable_step()).ok()) throw Error("a step failed");
      one->us.push_back(1e6 * (processor_seconds() - begin) / steps_a_turn);
    }
  }
  std::printf("%s of %d particles, %s; microseconds a step\n", body, cases[0]->scene.model().particle_count(),
              cases[0]->solver->device().c_str());
  double without = 0.0;
  for (auto& one : cases) {
    const double us = median(one->us);
    if (without == 0.0) without = us;
    std::printf("  %-32s %7.1f, %+7.1f, ratio %.3f; %.1f million particle-steps/s; stable step %.3g s\n",
                one->name.c_str(), us, us - without, us / without, one->scene.model().particle_count() / us,
                one->solver->stable_step());
  }
}

/// Springs from the body's top to the world.
Cases joints(const Model& model) {
  Cases cases;
  for (const int springs : {0, 20, 200, 2000}) {
    cases.push_back(std::make_unique<Case>(std::to_string(springs) + " springs", model, [&](Scene& scene) {
      const std::vector<Index> top = model.group("z1");  // 196
      Joint joint{.springs = {}, .stiffness = 5.0, .damping = 0.001};
      for (int k = 0; k < springs; ++k) {
        const Index i = top[static_cast<std::size_t>(k) % top.size()];
        joint.springs.push_back({at_particle(i), at_world(model.rest[i] + Vec3(0, 0, 0.01))});
      }
      if (springs > 0) scene.add_joint(joint);
    }));
  }
  return cases;
}

/// A free thread, held at one end or lying on something, or stitches under tension.
Cases threads(const Model& model) {
  Cases cases;
  for (const auto& [nodes, stitches] : {std::pair{0, 0}, {2, 0}, {100, 0}, {300, 0}, {0, 1}, {0, 2}, {0, 8}}) {
    const std::string name = "thread of " + std::to_string(nodes) + " nodes, " + std::to_string(stitches) + " stitches";
    cases.push_back(std::make_unique<Case>(name, model, [nodes = nodes, stitches = stitches](Scene& scene) {
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
    }));
  }
  const Thread lying{.length = 0.059, .segment = 1e-3, .damping = 5.0, .touches = true};
  cases.push_back(std::make_unique<Case>("60 nodes on a floor", model, [&](Scene& scene) {
    scene.add_tool({.shape = HalfSpace{}, .pose = {.position = {0, 0, -0.02}}});
    scene.add_thread(lying, {0, 0.1, lying.radius - 0.02}, {1, 0, 0});
  }));
  cases.push_back(std::make_unique<Case>("60 nodes on the body", model, [&](Scene& scene) {
    scene.add_thread(lying, {0.0005, 0.03, 0.06 + lying.radius}, {1, 0, 0});
  }));
  const Thread touching{.length = 0.099, .segment = 1e-3, .touches = true};
  cases.push_back(std::make_unique<Case>("100 nodes that touch nothing", model, [&](Scene& scene) {
    scene.add_thread(touching, {0, 0, 0.2}, {1, 0, 0}).hold(0, {0, 0, 0.2});
  }));
  cases.push_back(std::make_unique<Case>("100 nodes that lie across one of 100", model, [&](Scene& scene) {
    const ThreadHandle lower = scene.add_thread(touching, {0, 0, 0.2}, {1, 0, 0});
    const ThreadHandle upper = scene.add_thread(touching, {0.05, -0.05, 0.2 + 2.0 * touching.radius}, {0, 1, 0});
    for (const Index end : {0, 99}) lower.hold(end, {1e-3 * end, 0, 0.2});
    for (const Index end : {0, 99}) upper.hold(end, {0.05, 1e-3 * end - 0.05, 0.199});
  }));
  return cases;
}

/// `models` keeps the bodies, one a material.
Cases dissipation(const Model& body, std::vector<Model>& models) {
  struct Kind {
    const char* name;
    double retardation_time, relaxation_strength;
  };
  constexpr Kind kinds[] = {
      {"none", 0.0, 0.0}, {"retardation", 1e-3, 0.0}, {"relaxation", 0.0, 1.0}, {"both", 1e-3, 1.0}};
  models.assign(std::size(kinds), body);
  Cases cases;
  for (std::size_t k = 0; k < models.size(); ++k) {
    set_material(models[k], {.young = 10e3,
                             .poisson = 0.4,
                             .density = 1000,
                             .retardation_time = kinds[k].retardation_time,
                             .relaxation_strength = kinds[k].relaxation_strength,
                             .relaxation_time = 0.5});
    cases.push_back(std::make_unique<Case>(kinds[k].name, models[k]));
  }
  return cases;
}

/// `bag` keeps that body.
Cases walls(const Model& body, Model& bag) {
  const Model ball = make_body(solid_ball({0, 0, 0}, 0.025), {.spacing = 2.1e-3});
  const Surface surface{.vertices = ball.rest, .triangles = surface_triangles(ball), .notes = {}};
  bag = make_wall(surface, {.material = {.young = 10e3, .poisson = 0.4, .density = 1000, .thickness = 2e-3}});
  double volume = 0.0;
  for (const auto& [a, b, c] : surface_triangles(bag)) {
    volume += bag.rest[a].dot(bag.rest[b].cross(bag.rest[c])) / 6.0;
  }
  Cases cases;
  cases.push_back(std::make_unique<Case>("tetrahedra", body));
  cases.push_back(std::make_unique<Case>("bag of " + std::to_string(bag.particle_count()) + " particles", bag));
  cases.push_back(std::make_unique<Case>("the bag filled", bag, [&](Scene& scene) {
    scene.constrain_volume({.triangles = surface_triangles(bag), .volume = volume});
  }));
  return cases;
}

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(argc, argv, usage)) return 0;
  const std::string what = argc > 1 ? argv[1] : "";
  const int turns = argc > 2 ? std::max(1, std::atoi(argv[2])) : 41;
  Model model = make_tetrahedral_block({0.06, 0.06, 0.06}, 13, 13, 13, 0.2, 1);
  set_material(model, {.young = 10e3, .poisson = 0.4, .density = 1000});
  if (what == "joints") {
    measure("tetrahedra", joints(model), turns);
  } else if (what == "threads") {
    measure("tetrahedra", threads(model), turns);
  } else if (what == "dissipation") {
    std::vector<Model> models;
    measure("tetrahedra", dissipation(model, models), turns);
    measure("hexahedra", dissipation(make_block({0.06, 0.06, 0.06}, 13, 13, 13), models), turns);
  } else if (what == "walls") {
    Model bag;
    measure("bodies", walls(model, bag), turns);
  } else {
    return std::puts(usage), 2;
  }
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
