// SPDX-License-Identifier: MIT
//
// Fluids that flow from one volume into another (Fluid::opens_into). Most cases are syringes: boxes without stiffness
// whose end "x1" slides as a piston or is held.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include "interaction/fluid_exchange.h"
#include "model/closed_surface.h"
#include "support/run_scenes.h"
#include "support/text_file.h"
#include "support/wall_cases.h"

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
  const double G = 1e-8, tau = syringe_volume / (2.0 * G * 2e4), dt = tau / 500.0;
  for (const char* backend : {"reference", "cpu"}) {
    for (const double backward : {0.0, 0.3, 1.0}) {
      Scene scene = syringe_scene(model, "");
      scene.constrain_volume(content(model, "a", 1.3 * syringe_volume, isothermal_gas));
      scene.constrain_volume(content(model, "b", 0.8 * syringe_volume, into("a", backward * G, isothermal_gas)));
      scene.set_fluid("a", into("b", (1.0 - backward) * G, isothermal_gas));
      const auto solver = make_solver(backend, model, scene);
      const double sum = 1.3 * syringe_volume + 0.8 * syringe_volume, start = 2e4 * 0.5;
      for (int k = 1; k <= 1000; ++k) {
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
    double before = full;
    for (int k = 0; k < steps; ++k) {
      ASSERT_TRUE(solver->step(1, dt).ok());
      ASSERT_EQ(fluid_sum(*solver, "ab"), sum);
      const FluidState& b = solver->fluid("b");
      const double drop = solver->fluid("a").pressure - b.pressure;
      if (conductance < 1e-6) {
        ASSERT_NEAR(b.volume - before, dt * conductance * drop, 1e-9 * full);
      }
      before = b.volume;
    }
    const double p = solver->fluid("b").pressure;
    EXPECT_GT(solver->fluid("b").volume, 1.02 * full);
    EXPECT_NEAR(solver->fluid("a").pressure, p, 1e-3 * p);
    const State state = solver->read();
    for (const char* name : {"a", "b"}) {
      EXPECT_NEAR(enclosed_volume(content(model, name, 1.0).triangles, state.position) / solver->fluid(name).volume,
                  1.0, 1e-6);
    }
  }
}

/// From a through b and c into d, whose pistons press at 500, 300, 200 and 0 Pa.
TEST(ConnectedFluid, FlowsAlongAChain) {
  const Model model = syringes(4);
  const double G = 1e-9;
  for (const Fluid& fluid : {Fluid{}, Fluid{.law = FluidLaw::gas, .outer_pressure = 1e6}}) {
    Scene scene = syringe_scene(model, "abcd", {500.0, 300.0, 200.0, 0.0});
    for (const char* name : {"a", "c", "d", "b"}) scene.constrain_volume(content(model, name, syringe_volume, fluid));
    scene.set_fluid("a", into("b", G, fluid)).set_fluid("b", into("c", G, fluid)).set_fluid("c", into("d", G, fluid));
    const auto solver = make_solver("reference", model, scene, {}, damped(20.0));
    ASSERT_TRUE(solver->step(600, 5e-4).ok());
    const State before = solver->read();
    ASSERT_TRUE(solver->step(400, 5e-4).ok());
    const double rates[] = {-200.0 * G, -100.0 * G, 200.0 * G, 100.0 * G};
    for (int row = 0; row < 4; ++row) {
      const FluidState& was = before.fluids[row];
      EXPECT_NEAR((solver->fluid(was.name).volume - was.volume) / 0.2, rates[row], 2.0 * G) << was.name;
    }
    EXPECT_EQ(fluid_sum(*solver, "abcd"), 4.0 * syringe_volume);
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
    ASSERT_TRUE(solver->step(1000, 5e-4).ok());
    EXPECT_EQ(fluid_sum(*solver, "ab"), syringe_volume);
    EXPECT_GT(solver->fluid("a").volume, 0.0);
    EXPECT_LT(solver->fluid("a").volume, 1e-3 * syringe_volume);
    for (std::size_t k = 0; k < scene.loads().size(); ++k) {
      Load load = scene.loads()[k];
      if (load.type != LoadType::acceleration) continue;
      load.direction = -load.direction;
      scene.replace(k, load);
    }
    ASSERT_TRUE(solver->step(1000, 5e-4).ok());
    EXPECT_EQ(fluid_sum(*solver, "ab"), syringe_volume);
    EXPECT_GT(solver->fluid("a").volume, 0.99 * syringe_volume);
  }
}

/// Sucked through another one by an opening to the outside, a bag runs dry. With the opening closed it keeps what it
/// has.
TEST(ConnectedFluid, BagIsSuckedThroughAnother) {
  const Model one = wall_of(sphere_surface(0.02, 3), 20e3, 0.45, 1e-3), two = moved(one, {0.1, 0, 0});
  const Model model = merge_models(std::vector<NamedBody>{{"a", &one}, {"b", &two}});
  Scene scene(model);
  const double full = enclosed_volume(surface_triangles(one), one.rest), G = 2e-8;
  scene.fix("b");
  scene.constrain_volume(content(model, "b", full));
  scene.constrain_volume(content(model, "a", full, into("b", 1e-6)));
  scene.set_fluid("b", {.conductance = G, .outlet_pressure = -2000.0});
  const auto solver = make_solver("reference", model, scene, {}, damped(30.0));
  const double dt = 0.5 * solver->stable_step();
  double before = full;
  for (int k = 0; solver->fluid("a").volume > 0.1 * full; ++k) {
    ASSERT_TRUE(solver->step(1, dt).ok());
    const double leaves = dt * G * (solver->fluid("b").pressure + 2000.0);
    ASSERT_NEAR(before - solver->fluid("a").volume, leaves, 1e-9 * full);
    ASSERT_NEAR(leaves, dt * 1e-6 * (solver->fluid("a").pressure - solver->fluid("b").pressure), 1e-9 * full);
    before = solver->fluid("a").volume;
    ASSERT_LT(k, 2000);
  }
  ASSERT_TRUE(solver->step(200, dt).ok());
  EXPECT_LT(solver->fluid("a").volume, 1e-9 * full);
  EXPECT_NEAR(solver->fluid("b").pressure, -2000.0, 1.0);
  scene.set_fluid("b", {});
  ASSERT_TRUE(solver->step(200, dt).ok());
  EXPECT_NEAR(solver->fluid("a").pressure, solver->fluid("b").pressure, 1e-3);
}

/// What opens into a bag that is cut flows out as through an opening to the outside, and so does what a cut one opens
/// into; beside an opening that there is.
TEST(ConnectedFluid, CutBagIsTheOutside) {
  const Model one = wall_of(sphere_surface(0.05, 5), 20e3, 0.4, 2e-3), two = moved(one, {0.2, 0, 0});
  const Model body = with_spare_particles(merge_models(std::vector<NamedBody>{{"a", &one}, {"b", &two}}), 300);
  const double full = 1.1 * enclosed_volume(surface_triangles(one), one.rest), G = 1e-6;
  const auto run = [&](const Fluid& of_a, const Fluid& of_b, bool opened) {
    Simulation sim(body, {.backend = "cpu", .damping = {.rate = 20}});
    sim.scene().constrain_volume(content(body, "a", full)).constrain_volume(content(body, "b", full));
    sim.scene().set_fluid("a", of_a).set_fluid("b", of_b);
    EXPECT_TRUE(sim.cut(cut_plane({0.21, 0.0, 0.0}, {1.0, 0.1, 0.1})));
    EXPECT_TRUE(sim.scene().is_open(1) && !sim.scene().is_open(0));
    EXPECT_TRUE(sim.advance(0.05).ok());
    EXPECT_EQ(sim.solver().fluid("b").volume, full);
    EXPECT_EQ(sim.solver().fluid("a").volume != full, opened);
    return sim.solver().fluid("a");
  };
  const FluidState out = run({.conductance = G}, {}, true);
  EXPECT_LT(out.volume, 0.999 * full);
  EXPECT_EQ(run(into("b", G), {}, true), out);
  EXPECT_EQ(run({}, into("a", G), true), out);
  run({}, {}, false);
  const FluidState mean = run({.conductance = 2.0 * G, .outlet_pressure = 50.0}, {}, true);
  EXPECT_NEAR(run({.conductance = G, .outlet_pressure = 100.0}, into("a", G), true).volume, mean.volume, 1e-12 * full);
}

/// By any number of threads, from a snapshot, a state file and a recording in which links come and go; and a link that
/// is closed is none.
TEST(ConnectedFluid, GoesOnBitForBit) {
  const Model model = syringes(3);
  const std::string path = path_for("connected.state"), recorded_at = path_for("connected.rec");
  for (const char* backend : {"reference", "cpu"}) {
    Scene scene = syringe_scene(model, "abc", {5000.0, 300.0, 0.0});
    scene.constrain_volume(content(model, "a", syringe_volume, isothermal_gas));
    scene.constrain_volume(content(model, "b", syringe_volume));
    const Scene apart = scene.copy();
    scene.set_fluid("b", into("a", 0.0));
    const auto first = make_solver(backend, model, scene);
    const auto alone = make_solver(backend, model, apart);
    Recorder recorder(*first, scene);
    recorder.step(20, 1e-4);
    ASSERT_TRUE(alone->step(20, 1e-4).ok());
    EXPECT_EQ(first->snapshot().state.position, alone->snapshot().state.position);
    EXPECT_EQ(first->fluid("a"), alone->fluid("a"));
    scene.set_fluid("b", into("a", 1e-8));
    recorder.step(20, 1e-4);
    scene.constrain_volume(content(model, "c", syringe_volume, into("b", 1e-8)));
    recorder.step(20, 1e-4);
    // b, into which c opened, goes, and comes anew.
    scene.set_fluid("c", {}).set_fluid("b", {}).remove_volume("b");
    scene.constrain_volume(content(model, "b", 0.9 * syringe_volume, into("c", 1e-8)));
    scene.set_fluid("c", into("a", 1e-8)).set_fluid("a", into("b", 1e-8, isothermal_gas));
    recorder.step(20, 1e-4);
    save_recording(recorder.recording(), recorded_at);
    Scene again(model);
    const auto replayed = make_solver(backend, model, again);
    Replay(read_recording(recorded_at), *replayed, again).run();
    EXPECT_EQ(replayed->snapshot(), first->snapshot()) << backend;
    EXPECT_EQ(again.volume_constraints().back().fluid, scene.volume_constraints().back().fluid);

    save_state(*first, path);
    const Snapshot here = first->snapshot();
    ASSERT_TRUE(first->step(50, 1e-4).ok());
    std::unique_ptr<Solver> other;
    for (const int threads : {1, 3}) {
      other = make_solver(backend, model, scene, {}, {.threads = threads});
      load_state(*other, path);
      ASSERT_TRUE(other->step(50, 1e-4).ok());
      EXPECT_EQ(other->snapshot(), first->snapshot()) << backend << threads;
      other->restore(here);
      ASSERT_TRUE(other->step(50, 1e-4).ok());
      EXPECT_EQ(other->snapshot(), first->snapshot()) << backend << threads;
    }
    // In a remainder they are as closed ones; and a scene may begin with fluids that open into later ones.
    ASSERT_TRUE(first->step(1, 5e-8).ok());
    const State after_remainder = first->read();
    Recorder later(*first, scene);
    later.step(10, 1e-4);
    Scene third(model);
    const auto begun = make_solver(backend, model, third);
    Replay(later.recording(), *begun, third).run();
    EXPECT_EQ(begun->snapshot(), first->snapshot()) << backend;
    scene.set_fluid("a", isothermal_gas).set_fluid("b", {}).set_fluid("c", {});
    ASSERT_TRUE(other->step(1, 5e-8).ok());
    EXPECT_EQ(other->fluid("a"), after_remainder.fluids[0]) << backend;
    EXPECT_EQ(other->read().velocity, after_remainder.velocity) << backend;
  }
}

TEST(ConnectedFluid, RefusesWhatMakesNoSense) {
  const Model model = syringes(2);
  Scene scene = syringe_scene(model, "ab");
  const auto a = [&](const Fluid& fluid) { return content(model, "a", syringe_volume, fluid); };
  EXPECT_TRUE(refuses([&] { scene.constrain_volume(a(into("b", 1e-9))); }, "constrain_volume: ", "opens_into is \"b\"",
                      "add that one first", "set_fluid"));
  EXPECT_TRUE(refuses([&] { scene.constrain_volume(a(into("a", 1e-9))); }, "expected another volume"));
  scene.constrain_volume(a({})).constrain_volume(content(model, "b", syringe_volume, into("a", 0.0)));
  EXPECT_TRUE(refuses([&] { scene.set_fluid("a", into("a", 1e-9)); }, "set_fluid: \"a\"", "another volume"));
  EXPECT_TRUE(refuses([&] { scene.set_fluid("a", into("c", 1e-9)); }, "set_fluid: \"a\"", "opens_into is \"c\""));
  Fluid both = into("b", 1e-9);
  both.outlet_pressure = 5.0;
  EXPECT_TRUE(refuses([&] { scene.set_fluid("a", both); }, "outlet_pressure of 0", "got 5"));
  EXPECT_TRUE(refuses([&] { scene.remove_volume("a"); }, "remove_volume: \"b\" opens into \"a\"", "set_fluid"));
  scene.set_fluid("a", into("b", 1e-9)).set_fluid("b", {}).remove_volume("a").remove_volume("b");
  EXPECT_TRUE(scene.volume_constraints().empty());
}

/// Of volumes whose law, stiffness and filling are at random: what each is left with is what fits into it at its
/// pressure, and sums are exact; also where 1e13 times more would flow in a step than there is. Nearly all have a root
/// before one would be inside out.
TEST(ConnectedFluid, ExchangeFindsTheRoot) {
  std::mt19937 bits(3);
  const Fluid laws[] = {
      {}, isothermal_gas, {.law = FluidLaw::curve, .curve = {{0.5, 8000}, {0.8, 2000}, {0.81, 100}, {1.001, -5000}}}};
  int lost = 0;
  for (int round = 0; round < 2000; ++round) {
    FluidExchange group;
    const int count = 2 + static_cast<int>(bits() % 4);
    group.allocate(count);
    double sum = 0.0;
    for (int k = 0; k < count; ++k) {
      const double size = 1e-5 * std::pow(10.0, uniform(bits)),
                   yield = 1e4 * size * std::pow(10.0, 3.0 * uniform(bits));
      const double much = size * (1.0 + 0.9 * uniform(bits));
      group.volumes.push_back({.push = {.fluid = laws[bits() % 3], .volume = much, .dt = 1e-4},
                               .reached = size,
                               .along = {yield, uniform(bits) * 0.3 * yield * yield / size, 0.0},
                               .p = 1e4 * uniform(bits)});
      sum += much;
      if (k > 0) group.links.push_back({k, static_cast<int>(bits() % k), std::pow(10.0, -7.0 + 8.0 * uniform(bits))});
    }
    const bool found = group.solve() < 0;
    lost += !found;
    for (const FluidExchange::Volume& own : group.volumes) {
      ASSERT_NEAR(found ? own.fits(own.p).volume : own.left, own.left, 1e-9 * sum) << round;
      sum -= own.left;
    }
    ASSERT_TRUE(sum == 0.0 || !found) << round;
  }
  EXPECT_LE(lost, 45);
}

struct Pair : FluidExchange {
  Fluid laws[2];
  Pair(const Volume& from, const Volume& to) : laws{from.push.fluid, to.push.fluid} {
    allocate(2);
    links = {{0, 1, 1.0}};
    for (const Volume& own : {from, to}) {
      const FluidPush& push = own.push;
      volumes.push_back({.push = {.fluid = laws[volumes.size()], .volume = push.volume, .dt = 1.0},
                         .reached = own.reached,
                         .along = own.along});
    }
  }
};

/// A second volume, rigid, wants more than the first can give along its gradient: what is flat at 0.75, what holds a
/// thousandth, and what is rigid too. What is inside out has nothing. One that cannot exceed 1.25 takes no more.
TEST(ConnectedFluid, VolumesGiveWhatTheyHave) {
  const Fluid water, air{.law = FluidLaw::gas, .outer_pressure = 1e3};
  const FluidExchange::Volume sucks{.push = {.fluid = air, .volume = 1.0}, .reached = 3.0},
      full{.push = {.fluid = water, .volume = 3.0}, .reached = 2.0, .along = {1.0, 0.0, 0.0}};
  Pair flat({.push = {.fluid = water, .volume = 1.01}, .reached = 1.0, .along = {1.0, 1.0, 0.0}}, sucks);
  ASSERT_EQ(flat.solve(), -1);
  EXPECT_NEAR(flat.volumes[0].left, 1.0, 1e-12);
  EXPECT_NEAR(flat.volumes[1].left, 1.01, 1e-12);
  EXPECT_NEAR(flat.volumes[0].p - flat.volumes[1].p, 0.01, 1e-9);
  Pair empty({.push = {.fluid = water, .volume = 1.0}, .reached = 1.0, .along = {1.0, 0.0, 0.0}}, sucks);
  ASSERT_EQ(empty.solve(), -1);
  EXPECT_NEAR(empty.volumes[0].left, 1e-3, 1e-12);
  Pair rigid({.push = {.fluid = water, .volume = 1.0}, .reached = 1.0},
             {.push = {.fluid = water, .volume = 2.0}, .reached = 2.0 + 1e-9});
  ASSERT_EQ(rigid.solve(), -1);
  EXPECT_EQ(rigid.volumes[1].left, 2.0);
  Pair inverted({.push = {.fluid = water, .volume = 1.0}, .reached = -0.5, .along = {1.0, 0.0, -4.0}}, sucks);
  EXPECT_EQ(inverted.solve(), 0);
  Pair bursting({.push = {.fluid = water, .volume = 1.0}, .reached = 1.0, .along = {1.0, -1.0, 0.0}}, full);
  bursting.volumes[1].along[0] = 1e-3;
  EXPECT_EQ(bursting.solve(), 0);
}

}  // namespace
}  // namespace phymul::test
