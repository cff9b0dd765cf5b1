// SPDX-License-Identifier: MIT
//
// Fluids that flow from one volume into another (Fluid::opens_into). Most cases are syringes: boxes without stiffness
// whose end "x1" slides as a piston or is held.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include "model/enclosed_volume.h"
#include "support/cut_walls.h"
#include "support/run_scenes.h"
#include "support/text_file.h"

namespace phymul::test {
namespace {

constexpr double syringe_length = 0.04, syringe_area = 4e-4, syringe_volume = syringe_area * syringe_length;
constexpr double plunger_mass = 0.02;  // kg

/// Bodies "a", "b", ... side by side, with the masses of fluid_test.cpp's cylinder.
Model syringes(int count) {
  Model one = make_block({syringe_length, 0.02, 0.02}, 1, 2, 2);
  for (double& k : one.stiffness) k = 0.0;
  VecList gradient(one.rest.size());
  volume_gradient(surface_triangles(one), one.rest, gradient);
  for (const Index i : one.group("x1")) one.mass[i] = plunger_mass * gradient[i].x() / syringe_area;
  std::vector<Model> models;
  for (int k = 0; k < count; ++k) models.push_back(moved(one, {0, 0.1 * k, 0}));
  std::vector<NamedBody> bodies;
  for (int k = 0; k < count; ++k) bodies.push_back({std::string(1, static_cast<char>('a' + k)), &models[k]});
  return merge_models(bodies);
}

VolumeConstraint content(const Model& model, const std::string& name, double volume, const Fluid& fluid = {}) {
  VolumeConstraint all{.triangles = {}, .volume = volume, .applied_to = {}, .name = name, .fluid = fluid};
  const std::vector<Index>& own = model.group(name);
  for (const auto& t : surface_triangles(model)) {
    if (std::ranges::find(own, t[0]) != own.end()) all.triangles.push_back(t);
  }
  return all;
}

/// The ends "x1" of `sliding` can move along x alone; `pressures`, Pa, push them.
Scene syringe_scene(const Model& model, const std::string& sliding, const std::vector<double>& pressures = {}) {
  Scene scene(model);
  for (std::size_t k = 0; model.has_group(std::string(1, static_cast<char>('a' + k)) + "/x0"); ++k) {
    const std::string name(1, static_cast<char>('a' + k));
    scene.fix(name + "/x0");
    if (sliding.find(name) == std::string::npos) {
      scene.fix(name + "/x1");
      continue;
    }
    Load slides{.type = LoadType::translation, .events = {{0.0, 0.0}}, .direction = {0, 1, 0}};
    slides.particles = model.group(name + "/x1");
    slides.axes = {Axis::free, Axis::held, Axis::held};
    scene.add(slides);
    if (k >= pressures.size() || pressures[k] == 0.0) continue;
    const double p = pressures[k];
    scene.add(pull(model, (name + "/x1").c_str(), {p < 0.0 ? 1.0 : -1.0, 0, 0},
                   {{0, std::abs(p) * syringe_area / plunger_mass}}, LoadType::acceleration));
  }
  return scene.copy();
}

Fluid into(const std::string& name, double conductance, Fluid fluid = {}) {
  fluid.conductance = conductance;
  fluid.opens_into = name;
  return fluid;
}

double fluid_sum(const Solver& solver, const std::string& names) {
  double sum = 0.0;
  for (const char name : names) sum += solver.fluid(std::string(1, name)).volume;
  return sum;
}

const Fluid isothermal_gas{.law = FluidLaw::gas, .outer_pressure = 2e4};

/// In rigid volumes p = P (m / V - 1), so that the difference of both falls by 1 + dt / tau a step, and as exp(-t /
/// tau) with tau = V / (2 G P); the order of the two and how the conductance is shared between them are all one.
TEST(ConnectedFluid, RigidGasesRelaxExponentially) {
  const Model model = syringes(2);
  const double G = 1e-8, tau = syringe_volume / (2.0 * G * 2e4), dt = tau / 1000.0;
  for (const char* backend : {"reference", "cpu"}) {
    for (const double backward : {0.0, 0.3, 1.0}) {
      Scene scene = syringe_scene(model, "");
      scene.constrain_volume(content(model, "a", 1.3 * syringe_volume, isothermal_gas));
      scene.constrain_volume(content(model, "b", 0.8 * syringe_volume, into("a", backward * G, isothermal_gas)));
      scene.set_fluid("a", into("b", (1.0 - backward) * G, isothermal_gas));
      const auto solver = make_solver(backend, model, scene);
      const double sum = 1.3 * syringe_volume + 0.8 * syringe_volume, start = 2e4 * 0.5;
      for (int k = 1; k <= 2000; ++k) {
        ASSERT_TRUE(solver->step(1, dt).ok());
        ASSERT_EQ(fluid_sum(*solver, "ab"), sum) << k;
        const double difference = solver->fluid("a").pressure - solver->fluid("b").pressure;
        ASSERT_NEAR(difference / start, std::pow(1.0 + dt / tau, -k), backend[0] == 'c' ? 1e-5 : 1e-9) << k;
        ASSERT_NEAR(difference / start, std::exp(-k * dt / tau), 0.5 * dt / tau) << k;
      }
    }
  }
}

/// One pressed by a plate gives to the other what the difference of the pressures drives, whatever the conductance.
TEST(ConnectedFluid, PressedBagFillsTheOther) {
  constexpr double radius = 0.02;
  const Model one = wall_of(sphere_surface(radius, 4), 20e3, 0.45, 1e-3), two = moved(one, {0.1, 0, 0});
  const Model model = merge_models(std::vector<NamedBody>{{"a", &one}, {"b", &two}});
  for (const double conductance : {2e-7, 1e-2}) {
    Scene scene(model);
    const double full = enclosed_volume(surface_triangles(one), one.rest) * 1.05;
    scene.constrain_volume(content(model, "b", full));
    scene.constrain_volume(content(model, "a", full, into("b", conductance)));
    const Quaternion down(Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()));
    scene.add_tool("below", {.shape = Box{{0.03, 0.03, 0.01}}, .pose = {.position = {0, 0, -radius - 0.012}}});
    scene.add_tool("above", {.shape = Box{{0.03, 0.03, 0.01}}, .pose = {.position = {0, 0, radius + 0.012}}});
    const auto solver = make_solver("cpu", model, scene, {}, damped(30.0));
    const double dt = 0.5 * solver->stable_step(), sum = full + full;
    scene.tool("below").move_to({.position = {0, 0, -0.6 * radius - 0.01}});
    scene.tool("above").move_to({.position = {0, 0, 0.6 * radius + 0.01}});
    const auto steps = static_cast<int>(1.0 / dt);
    double before = full, most = 0.0;
    for (int k = 0; k < steps; ++k) {
      ASSERT_TRUE(solver->step(1, dt).ok());
      ASSERT_EQ(fluid_sum(*solver, "ab"), sum);
      const FluidState& b = solver->fluid("b");
      const double drop = solver->fluid("a").pressure - b.pressure;
      most = std::max(most, drop);
      if (conductance < 1e-6) {
        ASSERT_NEAR(b.volume - before, dt * conductance * drop, 1e-9 * full);
      }
      before = b.volume;
    }
    const double p = solver->fluid("b").pressure;
    std::printf("dt %g steps %d p %g %g most %g V %g %g\n", dt, steps, solver->fluid("a").pressure, p, most,
                solver->fluid("a").volume / full, solver->fluid("b").volume / full);
    EXPECT_GT(solver->fluid("b").volume, 1.02 * full);
    EXPECT_NEAR(solver->fluid("a").pressure, p, 1e-3 * p);
    const State state = solver->read();
    for (const char* name : {"a", "b"}) {
      EXPECT_NEAR(enclosed_volume(content(model, name, 1.0).triangles, state.position) / solver->fluid(name).volume,
                  1.0, 1e-6);
    }
  }
}

/// Under pistons that press at 500, 300 and 0 Pa, G (500 - 300) and G (300 - 0) m^3/s flow on.
TEST(ConnectedFluid, FlowsAlongAChain) {
  const Model model = syringes(3);
  const double G = 1e-9;
  for (const Fluid& fluid : {Fluid{}, Fluid{.law = FluidLaw::gas, .outer_pressure = 1e6}}) {
    Scene scene = syringe_scene(model, "abc", {500.0, 300.0, 0.0});
    for (const char* name : {"c", "b", "a"}) {
      const Fluid own = *name == 'c' ? fluid : into(*name == 'b' ? "c" : "b", G, fluid);
      scene.constrain_volume(content(model, name, syringe_volume, own));
    }
    const auto solver = make_solver("reference", model, scene, {}, damped(50.0));
    ASSERT_TRUE(solver->step(3000, 1e-4).ok());
    double before[3];
    for (int k = 0; k < 3; ++k) before[k] = solver->fluid(std::string(1, static_cast<char>('a' + k))).volume;
    ASSERT_TRUE(solver->step(2000, 1e-4).ok());
    const double rates[3] = {-200.0 * G, -100.0 * G, 300.0 * G};
    for (int k = 0; k < 3; ++k) {
      const double now = solver->fluid(std::string(1, static_cast<char>('a' + k))).volume;
      EXPECT_NEAR((now - before[k]) / 0.2, rates[k], 1e-2 * 300.0 * G) << k;
    }
    EXPECT_EQ(fluid_sum(*solver, "abc"), syringe_volume + syringe_volume + syringe_volume);
  }
}

/// Whether pressed out by its piston or sucked out by another one. What is left is above 0, and it fills again.
TEST(ConnectedFluid, RunsDryAndFillsAgain) {
  const Model model = syringes(2);
  for (const double pressure : {3000.0, -3000.0}) {
    Scene scene = syringe_scene(model, "ab", pressure > 0.0 ? std::vector{pressure, 0.0} : std::vector{0.0, pressure});
    scene.constrain_volume(content(model, "b", 0.5 * syringe_volume));
    scene.constrain_volume(content(model, "a", 0.5 * syringe_volume, into("b", 1e-6)));
    const auto solver = make_solver("reference", model, scene, {}, damped(50.0));
    ASSERT_TRUE(solver->step(5000, 1e-4).ok());
    std::printf("%g: a %g b %g p %g %g\n", pressure, solver->fluid("a").volume, solver->fluid("b").volume,
                solver->fluid("a").pressure, solver->fluid("b").pressure);
    EXPECT_EQ(fluid_sum(*solver, "ab"), syringe_volume);
    EXPECT_GT(solver->fluid("a").volume, 0.0);
    EXPECT_LT(solver->fluid("a").volume, 1e-3 * syringe_volume);
    for (std::size_t k = 0; k < scene.loads().size(); ++k) {
      Load load = scene.loads()[k];
      if (load.type != LoadType::acceleration) continue;
      load.direction = -load.direction;
      scene.replace(k, load);
    }
    ASSERT_TRUE(solver->step(5000, 1e-4).ok());
    std::printf("%g: a %g b %g p %g %g\n", pressure, solver->fluid("a").volume, solver->fluid("b").volume,
                solver->fluid("a").pressure, solver->fluid("b").pressure);
    EXPECT_EQ(fluid_sum(*solver, "ab"), syringe_volume);
    EXPECT_GT(solver->fluid("a").volume, 0.99 * syringe_volume);
  }
}

/// A bag that another one sucks flat, which is itself sucked through an opening to the outside.
TEST(ConnectedFluid, BagIsSuckedFlat) {
  const Model one = wall_of(sphere_surface(0.02, 4), 20e3, 0.45, 1e-3), two = moved(one, {0.1, 0, 0});
  const Model model = merge_models(std::vector<NamedBody>{{"a", &one}, {"b", &two}});
  for (const bool rigid : {false, true}) {
    Scene scene(model);
    const double full = enclosed_volume(surface_triangles(one), one.rest);
    if (rigid) scene.fix("b");
    scene.constrain_volume(content(model, "b", full));
    scene.constrain_volume(content(model, "a", full, into("b", 1e-6)));
    scene.set_fluid("b", {.conductance = 1e-8, .outlet_pressure = -2000.0});
    const auto solver = make_solver("reference", model, scene, {}, damped(30.0));
    const double dt = 0.5 * solver->stable_step();
    for (int k = 0; k < 20; ++k) {
      const StepReport report = solver->step(100, dt);
      EXPECT_TRUE(report.ok()) << report.message();
      std::printf("%d a %g b %g p %g %g\n", rigid, solver->fluid("a").volume / full, solver->fluid("b").volume / full,
                  solver->fluid("a").pressure, solver->fluid("b").pressure);
      if (!report.ok()) break;
    }
    scene.set_fluid("b", {});
    for (int k = 0; k < 5; ++k) {
      const StepReport report = solver->step(100, dt);
      EXPECT_TRUE(report.ok()) << report.message();
      std::printf("%d a %g b %g p %g %g\n", rigid, solver->fluid("a").volume / full, solver->fluid("b").volume / full,
                  solver->fluid("a").pressure, solver->fluid("b").pressure);
    }
  }
}

}  // namespace
}  // namespace phymul::test
