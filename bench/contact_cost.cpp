// SPDX-License-Identifier: MIT
//
// What contacts, or a tool that acts on the host, cost a step: two solvers of the same body, one with it, take turns
// from the same start. Medians of wall time over the turns; on cpu with one thread of processor time. Where bodies
// touch the two move apart.
//   contact_cost [--help]
#include <phymul/phymul.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "arguments.h"
#include "stopwatch.h"

namespace {

using namespace phymul;

constexpr int steps_a_turn = 40;

struct Case {
  std::string name;
  Model model;
  Vec3 gravity{0, 0, 0};  // m/s2
  std::string fixed{};    // group
  Vec3 spin{0, 0, 0};     // rad/s, at the start
  Vec3 thrown{0, 0, 0};   // m/s, of the group "high" at the start
  bool self = true;
};

Model soft(Model model) {
  set_material(model, {5e3, 0.3, 1000.0});
  return model;
}

/// Of so many particles in all, of jittered tetrahedra: the smaller one lies on the larger one, a third of whose top it
/// covers.
Model two_tetrahedral_blocks(int particles) {
  const int across = static_cast<int>(std::cbrt(particles / 1.125)), half = across / 2;
  const double spacing = 0.1 / (across - 1), side = spacing * (half - 1);
  const Model low = soft(make_tetrahedral_block({0.1, 0.1, 0.1}, across, across, across, 0.2, 7));
  Model high = soft(make_tetrahedral_block({side, side, side}, half, half, half, 0.2, 9));
  for (Vec3& x : high.rest) x += Vec3(0.2 * spacing + 0.02, 0.3 * spacing + 0.02, 0.1 + 0.3 * spacing);
  const NamedBody bodies[] = {{"low", &low}, {"high", &high}};
  return merge_models(bodies);
}

Model two_blocks() {
  const Model low = soft(make_block({0.1, 0.1, 0.03}, 20, 20, 6));
  Model high = soft(make_block({0.05, 0.05, 0.05}, 10, 10, 10));
  for (Vec3& x : high.rest) x += Vec3(0.0213, 0.0221, 0.031);
  const NamedBody bodies[] = {{"low", &low}, {"high", &high}};
  return merge_models(bodies);
}

Model organ(const Vec3& centre, const Vec3& half_axes, double spacing) {
  Model made = make_body(solid_ellipsoid(centre, half_axes), {.spacing = spacing});
  set_material(made, {5e3, 0.45, 1000.0});
  return made;
}

/// Two, of which the far sides are held: groups "low/held" and "high/held".
Model two_organs(Model low, Model high) {
  for (Model* own : {&low, &high}) {
    const double side = own == &low ? -1.0 : 1.0;
    double end = -HUGE_VAL;
    for (const Vec3& x : own->rest) end = std::max(end, side * x.z());
    std::vector<Index> held;
    for (Index i = 0; i < own->particle_count(); ++i) {
      if (side * own->rest[i].z() > end - 4e-3) held.push_back(i);
    }
    own->add_group("held", held);
  }
  const NamedBody bodies[] = {{"low", &low}, {"high", &high}};
  Model both = merge_models(bodies);
  std::vector<Index> all = both.group("low/held");
  for (const Index i : both.group("high/held")) all.push_back(i);
  both.add_group("held", all);
  return both;
}

Model organs_apart(double gap) {
  const Vec3 half(0.035, 0.03, 0.02);
  return two_organs(organ({0, 0, 0}, half, 6e-3), organ({0, 0, 2.0 * half.z() + gap}, half, 6e-3));
}

Model gallbladder_under_liver() {
  return two_organs(organ({0, 0, -0.0395}, {0.03, 0.014, 0.014}, 4e-3), organ({0, 0, 0}, {0.07, 0.05, 0.025}, 7e-3));
}

std::vector<Case> cases() {
  const Vec3 size(0.05, 0.065, 0.1), leaning(3, 0, -9.81), down(0, 0, -9.81);
  const Model block = soft(make_block(size, 10, 13, 20));
  const Model tetrahedra = soft(make_tetrahedral_block(size, 10, 13, 20, 0.2, 7));
  return {{.name = "block, still", .model = block},
          {.name = "block, falling", .model = block, .gravity = leaning},
          {.name = "block, swaying", .model = block, .gravity = leaning, .fixed = "z0"},
          {.name = "block, spinning", .model = block, .spin = {5, 3, 2}},
          {.name = "tetrahedra, still", .model = tetrahedra},
          {.name = "tetrahedra, swaying", .model = tetrahedra, .gravity = leaning, .fixed = "z0"},
          {.name = "stacked", .model = two_blocks(), .gravity = down, .fixed = "low/z0"},
          {.name = "stacked, self off", .model = two_blocks(), .gravity = down, .fixed = "low/z0", .self = false},
          {.name = "colliding at 1 m/s", .model = two_blocks(), .thrown = {0.2, 0, -1}},
          {.name = "colliding at 5 m/s", .model = two_blocks(), .thrown = {1, 0, -5}},
          {.name = "organs, 30 mm apart", .model = organs_apart(0.030), .fixed = "held"},
          {.name = "organs, 5 mm apart", .model = organs_apart(0.005), .fixed = "held"},
          {.name = "organs, 1 mm apart", .model = organs_apart(0.001), .fixed = "held"},
          {.name = "organs, 0.5 mm apart", .model = organs_apart(0.0005), .fixed = "held"},
          {.name = "organ lying on another", .model = organs_apart(0.001), .gravity = down, .fixed = "low/held"},
          {.name = "liver, gallbladder", .model = gallbladder_under_liver(), .gravity = down, .fixed = "held"}};
}

Case tetrahedral_block(int particles) {
  const int across = static_cast<int>(std::cbrt(particles));
  return {.name = "tetrahedra, a block",
          .model = soft(make_tetrahedral_block({0.1, 0.1, 0.1}, across, across, across, 0.2, 7)),
          .fixed = "z0"};
}

Case tetrahedra_stacked(int particles) {
  return {.name = "tetrahedra, stacked",
          .model = two_tetrahedral_blocks(particles),
          .gravity = Vec3(0, 0, -9.81),
          .fixed = "low/z0"};
}

State start_of(const Case& test) {
  State state = rest_state(test.model);
  for (std::size_t i = 0; i < state.position.size(); ++i) state.velocity[i] = test.spin.cross(state.position[i]);
  if (test.thrown != Vec3::Zero()) {
    for (const Index i : test.model.group("high")) state.velocity[i] = test.thrown;
  }
  return state;
}

struct Choice {
  std::string backend;
  int threads = 1;
  int turns = 11;
  std::string touch = "contacts";
};

/// contacts; host: the same, and a tool on triangles out of reach, so that what touches acts on the host, on devices
/// too; ball: pressed into the top by 3 mm, on triangles; needle: 10 mm deep.
void add_touch(Scene& scene, const Case& test, const std::string& touch) {
  Vec3 top(0, 0, -HUGE_VAL);
  for (const Vec3& x : test.model.rest) {
    if (x.z() > top.z()) top = x;
  }
  if (touch == "contacts" || touch == "host") scene.contacts({.self = test.self});
  if (touch == "host" || touch == "ball") {
    const Vec3 at = touch == "ball" ? Vec3(top + Vec3(0, 0, 0.007)) : Vec3(0, 0, 50);
    scene.add_tool("ball", {.shape = Sphere{0.01}, .pose = {.position = at}, .contact = ToolContact::surface});
  }
  if (touch == "needle") {
    const auto needle = scene.add_tool({.shape = Needle{.length = 0.08, .puncture = 0.1, .cutting = 0.1},
                                        .pose = {.position = top + Vec3(0, 0, 1e-3)}});
    needle.move_to({.position = top - Vec3(0, 0, 0.01)});
  }
}

double microseconds_a_step(const std::function<void()>& steps, bool processor_time) {
  const Stopwatch watch;
  const double begin = processor_seconds();
  steps();
  return 1e6 / steps_a_turn * (processor_time ? processor_seconds() - begin : watch.seconds());
}

void run(const Case& test, const Choice& choice) {
  Scene without(test.model), with(test.model);
  for (Scene* scene : {&without, &with}) {
    scene->gravity(test.gravity);
    if (!test.fixed.empty()) scene->fix(test.fixed);
  }
  add_touch(with, test, choice.touch);
  SolverOptions options;
  options.threads = choice.threads;
  options.damping.rate = 5.0;
  const State start = start_of(test);
  std::unique_ptr<Solver> solver[2];
  std::vector<double> us[2];
  for (const int k : {0, 1}) {
    solver[k] = make_solver(choice.backend, test.model, k == 0 ? without : with, {}, options);
    solver[k]->reset(start);
  }
  const double dt = 0.4 * solver[0]->stable_step();
  const bool processor_time = choice.backend == "cpu" && choice.threads == 1;
  for (int turn = 0; turn < choice.turns; ++turn) {
    for (const int k : {0, 1}) {
      StepReport report;
      us[k].push_back(microseconds_a_step([&] { report = solver[k]->step(steps_a_turn, dt); }, processor_time));
      if (report.ok()) continue;
      std::printf("%s: %s\n", test.name.c_str(), report.message().c_str());
      std::exit(1);
    }
  }
  const double off = median(us[0]), on = median(us[1]);
  std::printf("%-12s %7d  %-22s %9d | %9.1f %9.1f | %6.2f\n", choice.backend.c_str(), choice.threads, test.name.c_str(),
              test.model.particle_count(), off, on, on / off);
  std::fflush(stdout);
}

const bench::KnownArguments known{{"cases", ""},    {"particles", ""}, {"backends", "cpu"},
                                  {"threads", "1"}, {"turns", "11"},   {"touch", "contacts"}};

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(
          argc, argv, "contact_cost",
          "Microseconds a step without and with what touches. cases: a part of their names;\n"
          "particles: in place of the cases, two stacked blocks of so many, or one block under a tool;\n"
          "threads: of cpu; touch: contacts, host (the same, acting on the host on devices too), ball, needle",
          known)) {
    return 0;
  }
  const bench::Arguments arguments(argc, argv, known);
  const std::string touch = arguments.text("touch");
  if (touch != "contacts" && touch != "host" && touch != "ball" && touch != "needle") {
    throw Error("--touch: expected contacts, host, ball or needle, got \"" + touch + "\"");
  }
  std::vector<Case> tests;
  for (const double particles : arguments.numbers("particles")) {
    const bool stacked = touch == "contacts" || touch == "host";
    const auto count = static_cast<int>(particles);
    tests.push_back(stacked ? tetrahedra_stacked(count) : tetrahedral_block(count));
  }
  if (tests.empty()) tests = cases();
  const std::string& part = arguments.text("cases");
  std::erase_if(tests, [&](const Case& test) { return test.name.find(part) == std::string::npos; });
  if (tests.empty()) throw Error("--cases: no case has a name with \"" + part + '"');
  const int turns = std::max(1, static_cast<int>(arguments.number("turns")));
  std::printf("us a step, medians of %d turns of %d steps\n", turns, steps_a_turn);
  std::printf("%-12s %7s  %-22s %9s | %9s %9s | %6s\n", "", "threads", "", "particles", "without", "with", "ratio");
  for (const Case& test : tests) {
    for (const std::string& backend : arguments.list("backends")) {
      const std::vector<double> threads = backend == "cpu" ? arguments.numbers("threads") : std::vector{1.0};
      for (const double count : threads) run(test, {backend, static_cast<int>(count), turns, touch});
    }
  }
  return 0;
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
