// SPDX-License-Identifier: MIT
//
// The C program's results beside those of the same calls in C++: equal to the last bit.
#include <phymul/phymul.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "c_program.h"

namespace {

bool faulty = false;

void expect_same(const char* what, const double* c, const double* cpp, std::size_t count) {
  const bool moves = std::any_of(c, c + count, [](double value) { return value != 0.0; });
  if (moves && std::memcmp(c, cpp, count * sizeof(double)) == 0) return;
  std::printf("%s: in C %.17g, ..., in C++ %.17g, ...%s\n", what, c[0], cpp[0], moves ? "" : "; all are 0");
  faulty = true;
}

void expect_same(const char* what, const double* c, const phymul::VecList& cpp) {
  expect_same(what, c, cpp.front().data(), 3 * cpp.size());
}

phymul::Model block() {
  phymul::Model body = phymul::make_block({0.03, 0.03, 0.03}, 3, 3, 3);
  phymul::Component nodule;
  nodule.name = "nodule";
  nodule.exclusive = false;
  nodule.cell_refs = {13, 22};
  body.components.push_back(nodule);
  set_material(body, {.young = 8e3, .poisson = 0.4, .density = 1000});
  set_material(body, {.young = 3e4, .poisson = 0.4, .density = 1000}, "nodule");
  return body;
}

void compare(const c_results& c) {
  phymul::SimulationOptions options{.backend = "cpu", .damping = {.rate = 20}};
  options.solver.threads = 1;
  phymul::Simulation sim(block(), options);
  phymul::Scene& scene = sim.scene().fix("z0");
  const auto top = sim.model().group("z1");
  phymul::Load load;
  load.particles = top;
  load.direction = {1, 0, 0};
  load.events = {{0.0, 0.0}, {0.02, 1e-3}};
  scene.add(load);
  phymul::ToolPose pose{.position = {0.015, 0.015, 0.042}};
  const auto tool = scene.add_tool({.shape = phymul::Sphere{.radius = 0.012}, .pose = pose, .friction = 0.2});
  const auto joint =
      scene.attach(top, phymul::World{.offset = {0, 0, 0.01}}, {.stiffness = 1e5, .damping = 50, .slack = true});
  const phymul::VecList points{{0.004, 0.004, 0.03}, {0.022, 0.004, 0.03}, {0.004, 0.022, 0.03}};
  const phymul::Skin skin(sim.model(), points);
  for (int tick = 0; tick < 20; ++tick) {
    pose.position.z() -= 3e-4;
    tool.move_to(pose);
    sim.advance(2e-3);
  }
  const phymul::VecList skin_now = skin.deform(sim.state().position);
  phymul::VecList normals;
  phymul::surface_normals(std::vector<std::array<phymul::Index, 3>>{{0, 1, 2}}, skin_now, normals);
  expect_same("skin", c.skin, skin_now);
  expect_same("normals", c.normal, normals);
  expect_same("force on the tool", c.tool_force, sim.force_on(tool).force.data(), 3);
  expect_same("force of the joint", c.joint_force, sim.report_of(joint).force.data(), 3);
  tool.grasp(2e-3);
  sim.advance(2e-3);
  if (const int held = sim.solver().held(tool); held != c.held || held == 0) {
    std::printf("held: in C %d, in C++ %d\n", c.held, held);
    faulty = true;
  }

  const phymul::State state = sim.state();
  phymul::VecList force(state.position.size());
  elastic_forces(sim.solver().topology(), state.position, force);
  const phymul::Energy energy = sim.energy();
  const double parts[3] = {energy.elastic, energy.kinetic, energy.gravity};
  expect_same("positions", c.position, state.position);
  expect_same("velocities", c.velocity, state.velocity);
  expect_same("forces", c.force, force);
  expect_same("energies", c.energy, parts, 3);
  expect_same("time", &c.time, &state.time, 1);

  phymul::Simulation still(block(), {.backend = "reference"});
  still.scene().fix("z0").gravity({0, 0, -1});
  const double residual = still.solve_static().residual;
  expect_same("residual at rest", &c.rest_residual, &residual, 1);
}

void compare_sutured(const c_results& c) {
  phymul::SimulationOptions options{.backend = "cpu", .damping = {.rate = 20}};
  options.solver.threads = 1;
  phymul::Simulation sim(block(), options);
  phymul::Scene& scene = sim.scene().fix("z0");
  const auto stitch = scene.sew(
      {.length = 0.1, .friction = 0.0, .channel_friction = 0.01},
      phymul::VecList{{0.005, 0.015, 0.028}, {0.012, 0.015, 0.02}, {0.018, 0.015, 0.02}, {0.025, 0.015, 0.028}});
  stitch.pull(phymul::ThreadTip::first, {0.3, 0, 0});
  stitch.pull(phymul::ThreadTip::last, {-0.2, 0, 0});
  const auto wall = [&](const char* group) { return phymul::at_mean(sim.model().group(group)); };
  const auto clip = scene.add_clip("clip", {.gap = 0.028, .holding = 0.4}, wall("y0"), wall("y1"));
  scene.constrain_volume(
      phymul::VolumeConstraint{.triangles = surface_triangles(sim.model()),
                               .volume = 2.8e-5,
                               .name = "air",
                               .fluid = {.law = phymul::FluidLaw::gas, .exponent = 1.4, .conductance = 1e-9}});
  scene.set_volume("air", 2.75e-5);
  phymul::ToolPose pose{.position = {0.015, 0.015, 0.031}};
  const phymul::Needle fine{.length = 0.05, .radius = 0.4e-3, .static_friction = 20, .spread = 0.012};
  const auto needle = scene.add_tool({.shape = fine, .pose = pose});
  for (int tick = 0; tick < 20; ++tick) {
    if (tick == 10) stitch.tie(3, 0, 4);
    pose.position.z() -= 5e-4;
    needle.move_to(pose);
    sim.advance(2e-3);
  }
  const phymul::Solver& solver = sim.solver();
  const phymul::ThreadState& state = solver.thread_state(stitch);
  expect_same("thread", c.thread, state.position);
  expect_same("tensions", c.tension, state.tension.data(), state.tension.size());
  expect_same("knot", &c.knot, &state.knots.at(0).tension, 1);
  expect_same("clip", &c.clip_tension, &solver.thread_state(clip).tension[1], 1);
  expect_same("pressure", &c.pressure, &solver.fluid("air").pressure, 1);
  expect_same("force on the needle", c.needle, sim.force_on(needle).force.data(), 3);
  expect_same("shaft", c.shaft, solver.needle_points("tool 1", shaft_points));
  const double nodes = static_cast<double>(solver.read().tools.at(0).needle.hole.size()), same = c.needle_nodes;
  expect_same("nodes of the hole", &same, &nodes, 1);
}

}  // namespace

int main() {
  c_results results{};
  if (const char* wrong = c_program(&results)) {
    std::printf("%s\n", wrong);
    return 1;
  }
  compare(results);
  compare_sutured(results);
  return faulty ? 1 : 0;
}
