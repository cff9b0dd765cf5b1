// SPDX-License-Identifier: MIT
//
// Fluids in closed surfaces (Scene::constrain_volume): their laws against closed forms, openings, and changes while a
// simulation runs. Most cases are a cylinder with a piston: a box whose end "x1" slides and whose other particles are
// held.
#include <gtest/gtest.h>
#include <phymul/elasticity.h>

#include <numbers>

#include "interaction/fluid_exchange.h"
#include "model/closed_surface.h"
#include "support/bodies.h"
#include "support/message_of.h"
#include "support/run_scenes.h"
#include "support/text_file.h"
#include "support/wall_cases.h"

namespace phymul::test {
namespace {

constexpr double stroke_length = 0.04, piston_area = 4e-4, full_volume = piston_area * stroke_length;
constexpr double piston_mass = 0.02;  // kg

/// Without stiffness; masses as the gradient of the volume, so that the piston stays plane.
Model cylinder() {
  Model model = make_block({stroke_length, 0.02, 0.02}, 1, 2, 2);
  for (double& k : model.stiffness) k = 0.0;
  VecList gradient(model.rest.size());
  volume_gradient(surface_triangles(model), model.rest, gradient);
  for (const Index i : model.group("x1")) model.mass[i] = piston_mass * gradient[i].x() / piston_area;
  return model;
}

VolumeConstraint filled(const Model& model, const Fluid& fluid, double volume = full_volume) {
  return {.triangles = surface_triangles(model), .volume = volume, .applied_to = {}, .name = "gas", .fluid = fluid};
}

Load piston_force(const Model& model, double force) {
  return pull(model, "x1", {force < 0.0 ? -1.0 : 1.0, 0, 0}, {{0, std::abs(force)}}, LoadType::acceleration);
}

/// `push`: N, into the cylinder.
Scene piston_scene(const Model& model, const VolumeConstraint& fluid, double push = 0.0) {
  Scene scene(model);
  scene.fix("x0");
  Load slides;  // y and z of the piston are held
  slides.type = LoadType::translation;
  slides.particles = model.group("x1");
  slides.direction = {0, 1, 0};
  slides.axes = {Axis::free, Axis::held, Axis::held};
  slides.events = {{0.0, 0.0}};
  scene.add(slides);
  if (push != 0.0) scene.add(piston_force(model, -push / piston_mass));
  scene.constrain_volume(fluid);
  return scene.copy();
}

double piston_at(const Model& model, const State& state) {
  return state.position[model.group("x1").front()].x();
}

const Fluid diatomic{.law = FluidLaw::gas, .outer_pressure = 1e5, .exponent = 1.4};

TEST(Fluid, RatioAndPressureAreInverse) {
  const Fluid curve{.law = FluidLaw::curve, .curve = {{0.5, 4000}, {0.9, 300}, {1.0, 0}, {1.4, -50}}};
  for (const Fluid& fluid : {diatomic, curve}) {
    for (const double p : {-0.97e5, -0.5e5, -20.0, 1.0, 10.0, 350.0, 3e4, 5e5}) {
      const double r = fluid_ratio(fluid, p).volume, h = 1e-5 * (std::abs(p) + 100.0);
      EXPECT_NEAR(fluid_pressure(fluid, r), p, 1e-9 * (std::abs(p) + 1e3)) << p;
      const double slope = (fluid_ratio(fluid, p + h).volume - fluid_ratio(fluid, p - h).volume) / (2.0 * h);
      EXPECT_NEAR(fluid_ratio(fluid, p).slope, slope, 1e-4 * std::abs(slope)) << p;
    }
  }
}

/// omega^2 = n P A^2 / (V m) for small motions; no energy is lost in 200 periods of 50 steps.
TEST(Fluid, GasSwingsAsASpringAndKeepsItsEnergy) {
  const Model model = cylinder();
  const double omega = std::sqrt(1.4 * 1e5 * piston_area * piston_area / (full_volume * piston_mass));
  const double period = 2.0 * std::numbers::pi / omega;
  for (const char* backend : {"reference", "cpu"}) {
    const Scene scene = piston_scene(model, filled(model, diatomic));
    const auto solver = make_solver(backend, model, scene);
    State state = rest_state(model);
    const double way = 1e-3 * stroke_length;
    for (const Index i : model.group("x1")) state.velocity[i].x() = omega * way;
    solver->reset(state);
    const double dt = period / 50.0;
    double most[2] = {0, 0}, crossings = 0;
    double before = 0.0;
    for (int k = 0; k < 200 * 50; ++k) {
      ASSERT_TRUE(solver->step(1, dt).ok());
      const double x = piston_at(model, solver->read()) - stroke_length;
      if (before < 0.0 && x >= 0.0) ++crossings;
      before = x;
      if (k < 500) most[0] = std::max(most[0], std::abs(x));
      if (k >= 199 * 50 - 500) most[1] = std::max(most[1], std::abs(x));
    }
    EXPECT_NEAR(crossings, 200.0, 1.0) << backend;
    EXPECT_NEAR(most[0], way, 0.01 * way) << backend;
    EXPECT_NEAR(most[1], most[0], 0.01 * way) << backend;
  }
}

/// A period in a step and a half: explicit forces would explode from a third of a period on.
TEST(Fluid, NoStepIsTooLong) {
  const Model model = cylinder();
  const double omega = std::sqrt(1.4 * 1e5 * piston_area * piston_area / (full_volume * piston_mass));
  const Scene scene = piston_scene(model, filled(model, diatomic));
  const auto solver = make_solver("reference", model, scene);
  State state = rest_state(model);
  const double way = 1e-3 * stroke_length;
  for (const Index i : model.group("x1")) state.velocity[i].x() = omega * way;
  solver->reset(state);
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(solver->step(1, 3.0 * std::numbers::pi / omega).ok());
    ASSERT_LT(std::abs(piston_at(model, solver->read()) - stroke_length), 12.0 * way);
  }
}

/// Under a force F the pressure is F / A, and the volume what the law says; whatever the law.
TEST(Fluid, CarriesALoadByItsLaw) {
  const Model model = cylinder();
  const Fluid isothermal{.law = FluidLaw::gas, .outer_pressure = 2e4};
  const Fluid curve{.law = FluidLaw::curve, .curve = {{0.5, 8000}, {0.8, 2000}, {1.0, 0}}};
  const double p = 5000.0;
  const struct {
    Fluid fluid;
    double ratio;
  } cases[] = {{{}, 1.0}, {isothermal, 2e4 / 2.5e4}, {diatomic, std::pow(1.05, -1.0 / 1.4)}, {curve, 0.65}};
  for (const auto& [fluid, ratio] : cases) {
    for (const char* backend : {"reference", "cpu"}) {
      const Scene scene = piston_scene(model, filled(model, fluid), p * piston_area);
      const auto solver = make_solver(backend, model, scene, {}, damped(50.0));
      ASSERT_TRUE(solver->step(20000, 1e-4).ok());
      const double single = backend[0] == 'c' ? 1e-4 : 1e-7;
      EXPECT_NEAR(piston_at(model, solver->read()), ratio * stroke_length, single * stroke_length) << ratio;
      EXPECT_NEAR(solver->fluid("gas").pressure, p, 10.0 * single * p) << ratio;
      EXPECT_EQ(solver->fluid("gas").volume, full_volume);
    }
  }
}

/// G F / A a second leaves, until the pressure behind the opening is as high; then it comes back.
TEST(Fluid, LeavesThroughAnOpening) {
  const Model model = cylinder();
  const double p = 500.0, G = 1e-9;  // half a ml a second
  for (const Fluid& closed : {Fluid{}, Fluid{.law = FluidLaw::gas, .outer_pressure = 1e6}}) {
    Fluid open = closed;
    open.conductance = G;
    Scene scene = piston_scene(model, filled(model, open), p * piston_area);
    const auto solver = make_solver("reference", model, scene, {}, damped(5.0));
    ASSERT_TRUE(solver->step(20000, 1e-4).ok());
    const double start = solver->fluid("gas").volume;
    ASSERT_TRUE(solver->step(10000, 1e-4).ok());
    EXPECT_NEAR(start - solver->fluid("gas").volume, G * p * 1.0, 1e-3 * G * p);
    open.outlet_pressure = p;
    scene.set_fluid("gas", open);
    ASSERT_TRUE(solver->step(20000, 1e-4).ok());
    const double held = solver->fluid("gas").volume;
    ASSERT_TRUE(solver->step(10000, 1e-4).ok());
    EXPECT_NEAR(solver->fluid("gas").volume, held, 1e-3 * G * p);
    open.outlet_pressure = 3.0 * p;
    scene.set_fluid("gas", open);
    ASSERT_TRUE(solver->step(10000, 1e-4).ok());
    EXPECT_NEAR(solver->fluid("gas").volume - held, 2.0 * G * p, 0.02 * G * p);
    const double reached = solver->fluid("gas").volume;
    scene.set_fluid("gas", closed);
    ASSERT_TRUE(solver->step(20000, 1e-4).ok());
    EXPECT_EQ(solver->fluid("gas").volume, reached);
    EXPECT_NEAR(piston_at(model, solver->read()) * piston_area, reached * fluid_ratio(closed, p).volume,
                1e-6 * reached);
  }
}

TEST(Fluid, IsSetAddedAndTakenOutWhileItRuns) {
  const Model model = cylinder();
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene = piston_scene(model, filled(model, {}), 1.0);
    const auto solver = make_solver(backend, model, scene, {}, damped(50.0));
    const double single = 1e-6 * stroke_length;
    ASSERT_TRUE(solver->step(10, 1e-4).ok());
    scene.set_volume("gas", 0.9 * full_volume);
    ASSERT_TRUE(solver->step(10, 1e-4).ok());
    EXPECT_NEAR(piston_at(model, solver->read()), 0.9 * stroke_length, single) << backend;
    scene.remove_volume("gas");
    ASSERT_TRUE(solver->step(100, 1e-4).ok());
    EXPECT_LT(piston_at(model, solver->read()), 0.899 * stroke_length) << backend;
    EXPECT_NE(message_of([&] { static_cast<void>(solver->fluid("gas")); }).find("no volume constraint"),
              std::string::npos);
    const double now = piston_at(model, solver->read());
    scene.constrain_volume(filled(model, {}, now * piston_area));
    ASSERT_TRUE(solver->step(1000, 1e-4).ok());
    EXPECT_NEAR(piston_at(model, solver->read()), now, single) << backend;
    EXPECT_NEAR(solver->fluid("gas").pressure, 1.0 / piston_area, 0.01 / piston_area) << backend;
  }
}

/// A fluid of the same name in another bag of the same mesh.
TEST(Fluid, IsInTheBagThatItIsPutIn) {
  const Model one = wall_of(sphere_surface(0.02, 3), 10e3, 0.4, 1e-3), two = moved(one, {0.1, 0, 0});
  const Model both = merge_models(std::vector<NamedBody>{{"one", &one}, {"two", &two}});
  const auto bag = [&](double at) {
    VolumeConstraint fluid;
    fluid.name = "fluid";
    for (const auto& t : surface_triangles(both)) {
      if (std::abs(both.rest[t[0]].x() - at) < 0.05) fluid.triangles.push_back(t);
    }
    fluid.volume = 1.1 * enclosed_volume(fluid.triangles, both.rest);
    return fluid;
  };
  Scene scene(both);
  scene.constrain_volume(bag(0.0));
  const auto solver = make_solver("reference", both, scene, {}, damped(50.0));
  const double dt = 0.3 * solver->stable_step();
  ASSERT_TRUE(solver->step(5, dt).ok());
  scene.remove_volume("fluid");
  scene.constrain_volume(bag(0.1));
  ASSERT_TRUE(solver->step(5, dt).ok());
  const VolumeConstraint second = bag(0.1);
  EXPECT_NEAR(enclosed_volume(second.triangles, solver->read().position), second.volume, 1e-9 * second.volume);
}

TEST(Fluid, OfAStateIsHeldToBeOne) {
  const Model model = cylinder();
  Scene scene = piston_scene(model, filled(model, {}), 1.0);
  const auto solver = make_solver("reference", model, scene, {}, damped(50.0));
  ASSERT_TRUE(solver->step(1, 1e-4).ok());
  State state = solver->read();
  state.fluids.at(0).volume = std::nan("");
  EXPECT_TRUE(refuses([&] { solver->reset(state); }, "fluid \"gas\"", "volume above 0"));
}

/// Thrown, turning, and out of shape.
TEST(Fluid, GasInAFreeBagKeepsBothMomenta) {
  const Model model = wall_of(sphere_surface(0.02, 4), 10e3, 0.4, 1e-3);
  VolumeConstraint gas{.triangles = surface_triangles(model),
                       .volume = 0.0,
                       .applied_to = {},
                       .name = "gas",
                       .fluid = {.law = FluidLaw::gas, .outer_pressure = 1e4}};
  gas.volume = 1.02 * enclosed_volume(gas.triangles, model.rest);
  Scene scene(model);
  scene.constrain_volume(gas);
  const auto solver = make_solver("reference", model, scene);
  State state = rest_state(model);
  std::mt19937 bits(9);
  double scale = 0.0;
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    state.velocity[i] = Vec3(0.3, -0.1, 0.2) + Vec3(0, 0, 20).cross(model.rest[i]) + 0.1 * random_vector(bits, 3);
    scale += model.mass[i] * state.velocity[i].norm();
  }
  solver->reset(state);
  const Momentum start = solver->momentum();
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(1000, dt).ok());
  const Momentum end = solver->momentum();
  EXPECT_LT((end.linear - start.linear).norm(), 1e-12 * scale);
  EXPECT_LT((end.angular - start.angular).norm(), 1e-12 * scale * 0.3);
  EXPECT_GT(solver->fluid("gas").pressure, 1.0);
}

/// Pressed flat between plates and released, a bag comes back to its shape with its fluid.
TEST(Fluid, BagComesBackFromBetweenPlates) {
  constexpr double radius = 0.02;
  const Model model = wall_of(sphere_surface(radius, 8), 20e3, 0.45, 1e-3);
  Scene scene(model);
  VolumeConstraint water{.triangles = surface_triangles(model), .volume = 0.0, .applied_to = {}, .name = "water"};
  water.volume = enclosed_volume(water.triangles, model.rest);
  scene.constrain_volume(water);
  const double gap = 1e-3;
  const Quaternion down(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()));
  scene.add_tool("below", {.shape = HalfSpace{}, .pose = {.position = {0, 0, -radius - gap}}});
  scene.add_tool("above", {.shape = HalfSpace{}, .pose = {.position = {0, 0, radius + gap}, .orientation = down}});
  const auto solver = make_solver("cpu", model, scene, {}, damped(30.0));
  const double dt = 0.5 * solver->stable_step();
  const auto press_to = [&](double half, int steps) {
    scene.tool("below").move_to({.position = {0, 0, -half}});
    scene.tool("above").move_to({.position = {0, 0, half}, .orientation = down});
    const StepReport report = solver->step(steps, dt);
    EXPECT_TRUE(report.ok()) << report.message();
  };
  press_to(0.3 * radius, static_cast<int>(0.3 / dt));
  State state = solver->read();
  EXPECT_NEAR(enclosed_volume(water.triangles, state.position) / water.volume, 1.0, 1e-6);
  EXPECT_GT(solver->fluid("water").pressure, 100.0);
  double width = 0.0;
  for (const Vec3& x : state.position) width = std::max(width, std::hypot(x.x(), x.y()));
  EXPECT_GT(width, 1.4 * radius);
  press_to(radius + gap, static_cast<int>(0.1 / dt));
  ASSERT_TRUE(solver->step(static_cast<int>(0.6 / dt), dt).ok());
  solver->read(state);
  double worst = 0.0;
  for (std::size_t i = 0; i < model.rest.size(); ++i) {
    worst = std::max(worst,
                     std::abs((state.position[i] - state.position[0]).norm() - (model.rest[i] - model.rest[0]).norm()));
  }
  EXPECT_LT(worst, 0.02 * radius);
  EXPECT_LT(std::abs(solver->fluid("water").pressure), 5.0);
}

/// With what has flowed, and with the pressure of the step before.
TEST(Fluid, GoesOnBitForBitFromASnapshotAndAStateFile) {
  const Model model = cylinder();
  Fluid open = diatomic;
  open.conductance = 1e-8;
  const Scene scene = piston_scene(model, filled(model, open), 0.4);
  const std::string path = path_for("fluid.state");
  for (const char* backend : {"reference", "cpu"}) {
    const auto first = make_solver(backend, model, scene);
    ASSERT_TRUE(first->step(40, 1e-4).ok());
    save_state(*first, path);
    ASSERT_TRUE(first->step(40, 1e-4).ok());
    const auto second = make_solver(backend, model, scene);
    load_state(*second, path);
    ASSERT_TRUE(second->step(40, 1e-4).ok());
    EXPECT_EQ(second->snapshot(), first->snapshot()) << backend;
    EXPECT_EQ(second->fluid("gas"), first->fluid("gas")) << backend;
    EXPECT_LT(first->fluid("gas").volume, full_volume);
  }
}

TEST(Fluid, IsRecordedWithItsChanges) {
  const Model model = cylinder();
  const std::string path = path_for("fluid.rec");
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene = piston_scene(model, filled(model, diatomic), 0.4);
    scene.add_tool("ball", {.shape = Sphere{0.005}, .pose = {.position = {0.1, 0, 0}}});
    const auto recorded = make_solver(backend, model, scene);
    Recorder recorder(*recorded, scene);
    recorder.step(10, 1e-4);
    scene.tool("ball").move_to({.position = {0.0, 0.01, 0.03}});
    scene.set_volume("gas", 0.97 * full_volume);
    recorder.step(10, 1e-4);
    Fluid open = diatomic;
    open.conductance = 1e-8;
    scene.set_fluid("gas", open);
    recorder.step(10, 1e-4);
    scene.remove_volume("gas");
    recorder.step(3, 1e-4);
    VolumeConstraint other = filled(model, {}, 0.95 * full_volume);
    other.name = "other";
    scene.constrain_volume(other);
    recorder.step(10, 1e-4);
    save_recording(recorder.recording(), path);
    Scene again(model);
    const auto replayed = make_solver(backend, model, again);
    const Recording recording = read_recording(path);
    Replay(recording, *replayed, again).run();
    EXPECT_EQ(replayed->snapshot(), recorded->snapshot()) << backend;
    EXPECT_EQ(again.volume_constraints().size(), 1u);
  }
}

TEST(Fluid, RefusesWhatMakesNoSense) {
  const Model model = cylinder();
  Scene scene(model);
  const auto refused = [&](const Fluid& fluid) {
    return message_of([&] { scene.constrain_volume(filled(model, fluid)); });
  };
  EXPECT_EQ(refused({.law = FluidLaw::gas, .outer_pressure = 0.0}),
            "constrain_volume: expected Fluid::outer_pressure above 0 Pa, got 0");
  EXPECT_NE(refused({.exponent = 0.5}).find("exponent of 1 or more, got 0.5"), std::string::npos);
  EXPECT_NE(refused({.conductance = -1.0}).find("conductance of 0"), std::string::npos);
  EXPECT_NE(refused({.law = FluidLaw::curve, .curve = {{1.0, 0.0}}}).find("two points or more"), std::string::npos);
  EXPECT_NE(refused({.law = FluidLaw::curve, .curve = {{0.5, 10.0}, {1.0, 20.0}}}).find("(1, 20) as point 1"),
            std::string::npos);
  scene.constrain_volume(filled(model, {}));
  EXPECT_NE(message_of([&] { scene.constrain_volume(filled(model, {})); }).find("\"gas\" is in use"),
            std::string::npos);
  EXPECT_NE(message_of([&] { scene.set_volume("gas", 0.0); }).find("a volume above 0"), std::string::npos);
  EXPECT_NE(message_of([&] { scene.set_fluid("water", {}); }).find("it has: gas"), std::string::npos);
  EXPECT_NE(message_of([&] { scene.remove_volume("water"); }).find("it has: gas"), std::string::npos);
  const Scene with_gas = piston_scene(model, filled(model, diatomic));
  for (const char* backend : {"gl", "gl-compute"}) {
    const auto names = backend_names();
    if (std::ranges::find(names, backend) == names.end() || !why_unavailable(backend).empty()) continue;
    EXPECT_NE(message_of([&] { make_solver(backend, model, with_gas); }).find("a fluid that is not incompressible"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace phymul::test
