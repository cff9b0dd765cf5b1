// SPDX-License-Identifier: MIT
//
// Scene::scale_stiffness: the stiffness of materials, changed between steps.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <iostream>

#include "elastic/local_steps.h"
#include "elastic/scaled_tables.h"
#include "support/allocation_count.h"
#include "support/bodies.h"
#include "support/every_backend.h"
#include "support/message_of.h"
#include "support/outside_backend.h"

namespace phymul::test {
namespace {

constexpr double first = 2.5, second = 0.4;  // of all, then of the tumour alone

/// The half of x below 0.4 of the body's length.
Model with_tumour(Model model, const Material& tissue, const Material& tumour) {
  set_material(model, tissue);
  const double middle = 0.4 * body_size(model);
  set_material(model, tumour, [=](const Vec3& place) { return place.x() < middle; });
  return model;
}

struct Tissues {
  Material tissue{10e3, 0.3, 1000.0}, tumour{30e3, 0.45, 1100.0};
  Tissues scaled(double of_tissue, double of_tumour) const {
    Tissues other = *this;
    other.tissue.young *= of_tissue;
    other.tumour.young *= of_tumour;
    return other;
  }
};

struct ScaledBody {
  std::string name;
  std::function<Model(const Tissues&)> make;
  TopologyOptions options;
};

std::vector<ScaledBody> cases() {
  const auto of = [](const Model& model) {
    return [model](const Tissues& t) { return with_tumour(model, t.tissue, t.tumour); };
  };
  const Model tetrahedra = make_tetrahedral_block({0.05, 0.02, 0.02}, 5, 2, 2, 0.2, 3);
  return {{"lattice", of(make_block({0.1, 0.02, 0.02}, 30, 5, 5)), {}},
          {"tetrahedra", of(tetrahedra), {}},
          {"fibres",
           [=](Tissues t) {
             t.tissue.fibre_ratio = 4.0;
             Model model = with_tumour(tetrahedra, t.tissue, t.tumour);
             for (Cell& cell : model.cells) cell.fibre = {0, 1, 0};
             return model;
           },
           {}},
          {"stiffening",
           [=](Tissues t) {
             t.tissue.stiffening = like_cortex;
             return with_tumour(tetrahedra, t.tissue, t.tumour);
           },
           {}},
          {"strip", of(make_strip(0.04, 0.02, 10, 5)), {}},
          {"points",
           [](const Tissues& t) {
             Model points = with_material(without_cells(make_block({0.03, 0.02, 0.02}, 6, 4, 4)), t.tissue);
             return points.add_group("x1", {points.particle_count() - 1});
           },
           {}}};
}

Load pull_on(const Model& model) {
  return {.type = LoadType::acceleration,
          .particles = model.group("x1"),
          .events = {{0.0, 5.0}},
          .direction = model.dimension == 2 ? Vec3(1, 1, 0) : Vec3(1, 1, 0.5)};
}

class LiveStiffness : public OnEveryBackend {};
PHYMUL_ON_EVERY_BACKEND(LiveStiffness);

/// A body changed while it moves, against one built with that stiffness and started from the same state.
TEST_P(LiveStiffness, IsThatOfASolverMadeAnew) {
  const double bound = GetParam() == "reference" ? 1e-11 : 3e-5;  // of the largest displacement
  for (const ScaledBody& c : cases()) {
    SCOPED_TRACE(c.name);
    const Tissues tissues;
    const Model model = c.make(tissues);
    const bool points = c.name == "points";
    Scene scene = Scene(model).add(pull_on(model));
    const auto solver = make_solver(GetParam(), model, scene, c.options);
    const double dt = 0.3 * solver->stable_step();
    ASSERT_TRUE(solver->step(20, dt).ok());
    for (const bool of_one : {false, true}) {
      if (of_one && points) continue;
      of_one ? scene.scale_stiffness(tissues.tumour, second) : scene.scale_stiffness(first);
      const Model made_so = c.make(tissues.scaled(first, of_one ? second : first));
      Scene other = Scene(made_so).add(pull_on(made_so));
      const auto anew = make_solver(GetParam(), made_so, other, c.options);
      anew->reset(solver->read());
      const double of_both = solver->stable_step() / anew->stable_step();
      EXPECT_LE(of_both, 1.0 + 1e-3) << "a bound";
      EXPECT_GE(of_both, of_one ? 0.0 : 1.0 - 1e-3);
      EXPECT_NEAR(solver->energy().elastic, anew->energy().elastic, 1e-6 * anew->energy().elastic);
      ASSERT_TRUE(all_step(60, dt, solver, anew));
      const State now = solver->read(), wanted = anew->read();
      const double largest = largest_distance(wanted.position, model.rest);
      EXPECT_GT(largest, 1e-6);
      EXPECT_LT(largest_distance(wanted.position, now.position), bound * largest) << (of_one ? "of one" : "of all");
    }
  }
}

/// Forces and energy of the public functions, with the scene's factors.
TEST(LiveStiffnessOfABody, IsThatOfOneBuiltSo) {
  for (const ScaledBody& c : cases()) {
    SCOPED_TRACE(c.name);
    const bool points = c.name == "points";
    const Tissues tissues;
    const Model model = c.make(tissues), made_so = c.make(tissues.scaled(first, points ? first : second));
    Scene scene(model);
    scene.scale_stiffness(first);
    if (!points) scene.scale_stiffness(tissues.tumour, second);
    const TopologyTextures own = build_topology(model, c.options), other = build_topology(made_so, c.options);
    const VecList x = random_positions(model, 0.1, 3);
    VecList found(x.size()), wanted(x.size());
    elastic_forces(own, x, found, scene.stiffness_factors());
    elastic_forces(other, x, wanted);
    EXPECT_GT(largest_norm(wanted), 0.0);
    EXPECT_LT(largest_distance(found, wanted), 1e-12 * largest_norm(wanted));
    const double energy = elastic_energy(other, x);
    EXPECT_NEAR(elastic_energy(own, x, scene.stiffness_factors()), energy, 1e-12 * energy);
  }
}

/// The bound of the step over that of a body built so: never above 1, which would be unstable, and near it.
TEST(LiveStiffnessOfABody, BoundsItsStepClosely) {
  double least = 1.0, mean = 0.0;
  int count = 0;
  for (const ScaledBody& c : cases()) {
    if (c.name == "points") continue;  // has one material
    SCOPED_TRACE(c.name);
    const Tissues tissues;
    const Model model = c.make(tissues);
    Scene scene(model);
    const auto solver = make_solver("reference", model, scene, c.options);
    for (const double of_tissue : {1e-3, 1.0, 1e2}) {
      for (const double of_tumour : {1e-4, 0.1, 0.5, 1.0, 3.0, 30.0, 1e4}) {
        scene.scale_stiffness(of_tissue).scale_stiffness(tissues.tumour, of_tumour);
        const Model made_so = c.make(tissues.scaled(of_tissue, of_tumour));
        const TopologyTextures tables = build_topology(made_so, c.options);
        const double exact = stable_step(estimate_spectrum(tables, tables.rest), 1.0);
        const double share = solver->stable_step() / exact;
        EXPECT_LT(share, 1.0 + 1e-4) << of_tissue << ", " << of_tumour;
        EXPECT_GT(share, 0.7) << of_tissue << ", " << of_tumour;
        least = std::min(least, share);
        mean += share;
        ++count;
      }
    }
  }
  std::cout << "share of the step of a body built so: " << least << " or more, " << mean / count << " in the mean\n";
}

/// A tip so soft that its factor says nothing about the body's step.
TEST(LiveStiffnessOfABody, OfASoftTipCostsNoSteps) {
  const Material body{100e3, 0.3, 1000.0}, tip{10.0, 0.3, 1000.0};
  Model model = with_material(make_block({0.1, 0.02, 0.02}, 20, 4, 4), body);
  set_material(model, tip, [](const Vec3& place) { return place.x() > 0.08; });
  Scene scene(model);
  const auto solver = make_solver("reference", model, scene);
  const double limit = solver->stable_step();
  scene.scale_stiffness(tip, 1e4);
  EXPECT_GT(solver->stable_step(), 0.95 * limit);
  EXPECT_LT(solver->stable_step(), limit * (1.0 + 1e-3));
}

/// Several materials in a row, each stiffened by itself.
TEST(LiveStiffnessOfABody, OfManyMaterialsIsBoundedClosely) {
  constexpr int materials = 8;
  const auto young = [](int k, int stiffened) { return (5e3 + 1e3 * k) * (k == stiffened ? 20.0 : 1.0); };
  const auto make = [&](int stiffened) {
    Model model = make_block({0.16, 0.02, 0.02}, 24, 3, 3);
    for (int k = 0; k < materials; ++k) {
      set_material(model, {young(k, stiffened), 0.3, 1000.0}, [=](const Vec3& x) { return x.x() >= 0.02 * k - 1e-9; });
    }
    return model;
  };
  const Model model = make(-1);
  ASSERT_EQ(model.materials.size(), materials);
  Scene scene(model);
  const auto solver = make_solver("reference", model, scene);
  for (int k = 0; k < materials; ++k) {
    scene.scale_stiffness({}).scale_stiffness({young(k, -1), 0.3, 1000.0}, 20.0);
    const TopologyTextures tables = build_topology(make(k));
    const double share = solver->stable_step() / stable_step(estimate_spectrum(tables, tables.rest), 1.0);
    EXPECT_LT(share, 1.0 + 1e-4) << k;
    EXPECT_GT(share, 0.9) << k;
  }
}

/// Of a material beside one 60 times as stiff at every vertex. Where the first gets stiffer, steps are shorter, in
/// which substeps hide less of the second.
/// Of two materials, the second so many times as stiff.
Model checkerboard(int across, double jitter, unsigned seed, double poisson, double ratio) {
  Model model = with_material(make_tetrahedral_block({0.1, 0.1, 0.1}, across, across, across, jitter, seed),
                              {5e3, poisson, 1000.0});
  set_material(model, {5e3 * ratio, poisson, 1000.0}, [&](const Vec3& at) {
    const Vec3 cell = 10.0 * across * at;
    return (static_cast<int>(cell.x()) + static_cast<int>(cell.y()) + static_cast<int>(cell.z())) % 2 == 0;
  });
  return model;
}

TEST(LiveStiffnessOfABody, BoundsItsStepWithSubstepsToo) {
  const TopologyTextures t = build_topology(checkerboard(6, 0.2, 7, 0.45, 136.0));
  const auto steps = choose_local_steps(t, estimate_spectrum(t, t.rest), 32);
  ASSERT_TRUE(steps && !steps->substeps.empty());
  for (const double less : {0.83, 0.1, 0.02}) {
    std::vector<double> factors;
    for (const bool is_stiff : steps->chosen) factors.push_back(is_stiff ? less : 1.0);
    ScaledTables scaled;
    LocalSteps weaker = *steps;
    weaker.stiff = part_of(scaled.of(t, factors), steps->chosen);
    weaker.stiff_rate *= less;
    weaker.margin *= steps->rate(factors) / weaker.rate();  // so that its step is the same
    EXPECT_LE(largest_rate(scaled.of(t, factors), weaker), steps->rate(factors)) << less;
    EXPECT_LT(steps->rate(factors), 1.5 * steps->rate()) << less;
  }
}

TEST_P(LiveStiffness, OfFactorsOfOneChangesNoBit) {
  for (const ScaledBody& c : cases()) {
    SCOPED_TRACE(c.name);
    const Model model = c.make({});
    Scene plain = Scene(model).add(pull_on(model)), scaled = plain.copy();
    scaled.scale_stiffness(1.0);
    const auto one = make_solver(GetParam(), model, plain, c.options);
    const auto other = make_solver(GetParam(), model, scaled, c.options);
    ASSERT_TRUE(all_step(50, 0.5 * one->stable_step(), one, other));
    EXPECT_EQ(one->snapshot(), other->snapshot());
  }
}

/// The lowest way of a particle along z, m.
double sag_of(Simulation& sim) {
  double lowest = 0.0;
  const VecList x = sim.state().position;
  for (std::size_t i = 0; i < x.size(); ++i) lowest = std::min(lowest, x[i].z() - sim.model().rest[i].z());
  return lowest;
}

/// Soft tissue hangs four times as far from a hold that is a quarter as stiff, and the step may be twice as long.
TEST_P(LiveStiffness, ReachesSolveStaticAndTheStep) {
  Simulation sim(with_material(make_tetrahedral_block({0.05, 0.02, 0.02}, 5, 2, 2, 0.2, 3)), {.backend = GetParam()});
  sim.scene().fix("x0").gravity({0, 0, -1e-3});
  const double limit = sim.solver().stable_step();
  const auto sag = [&] {
    EXPECT_EQ(sim.solve_static().status, RestStatus::converged);
    return sag_of(sim);
  };
  const double before = sag();
  sim.scene().scale_stiffness(0.25);
  EXPECT_NEAR(sag(), 4.0 * before, 1e-4 * std::abs(before));
  EXPECT_NEAR(sim.solver().stable_step(), 2.0 * limit, 1e-12 * limit);
  sim.scene().scale_stiffness(std::span<const double>());
  EXPECT_NEAR(sag(), before, 1e-4 * std::abs(before));
  EXPECT_EQ(sim.solver().stable_step(), limit);
}

TEST_P(LiveStiffness, IsReplayedBitForBit) {
  const Model model = cases()[1].make({});
  Simulation sim(model, {.backend = GetParam()});
  sim.scene().add(pull_on(model)).scale_stiffness(1.5);
  sim.record();
  ASSERT_TRUE(sim.advance(0.01).ok());
  sim.scene().scale_stiffness(Tissues().tumour, 4.0);
  ASSERT_TRUE(sim.advance(0.01).ok());
  sim.scene().scale_stiffness(std::span<const double>());
  ASSERT_TRUE(sim.advance(0.01).ok());
  sim.scene().scale_stiffness(0.5);
  ASSERT_TRUE(sim.advance(0.01).ok());
  Simulation again(model, {.backend = GetParam()});
  again.replay(sim.recording());
  EXPECT_EQ(again.snapshot(), sim.snapshot());
  EXPECT_EQ(again.scene().stiffness_factors(), sim.scene().stiffness_factors());
}

class LiveStiffnessOnProcessor : public testing::TestWithParam<std::string> {};
PHYMUL_ON_BACKENDS(LiveStiffnessOnProcessor, std::vector<std::string>({"reference", "cpu"}));

/// A driver of GL may allocate whenever it likes.
TEST_P(LiveStiffnessOnProcessor, AllocatesNothingInSteps) {
  const Model model = cases()[1].make({});
  Scene scene(model);
  scene.scale_stiffness(2.0);
  const auto solver = make_solver(GetParam(), model, scene, {}, {.threads = 1});
  ASSERT_TRUE(solver->step(1, 0.5 * solver->stable_step()).ok());
  for (const double factor : {3.0, 1.0}) {
    scene.scale_stiffness(Tissues().tumour, factor);
    const std::size_t before = allocation_count();
    ASSERT_TRUE(solver->step(4, 0.5 * solver->stable_step()).ok());
    EXPECT_EQ(allocation_count(), before);
  }
}

/// Asleep under its weight, then half as stiff: it sags twice as far.
TEST(LiveStiffnessAndSleep, AChangeWakes) {
  Simulation sim(with_material(make_tetrahedral_block({0.12, 0.03, 0.03}, 24, 6, 6, 0.2, 7)),
                 {.backend = "cpu", .solver = {.damping = {.rate = 200.0}, .sleep_tolerance = 1e-4}});
  sim.scene().fix("z0").gravity({0, 0, -1.0});
  const auto sag_after = [&](double seconds) {
    EXPECT_TRUE(sim.advance(seconds).ok());
    return sag_of(sim);
  };
  const double before = sag_after(0.3);
  EXPECT_EQ(sag_after(0.02), before) << "nothing moves any more, or this shows nothing";
  sim.scene().scale_stiffness(0.5);
  EXPECT_NEAR(sag_after(0.4), 2.0 * before, 0.05 * std::abs(before));
}

TEST(LiveStiffnessOfAScene, RefusesWhatItCannotMean) {
  const Model model = cases()[1].make({});
  Scene scene(model);
  for (const double factor : {0.0, -1.0, 1e7, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(refuses([&] { scene.scale_stiffness(factor); }, "expected a factor from 1e-6 to 1e6"));
  }
  EXPECT_TRUE(refuses(
      [&] {
        scene.scale_stiffness(Material{5e3, 0.3, 1000.0}, 2.0);
      },
      "Young's moduli are 30000, 10000 Pa; got another one, of 5000 Pa"));
  const std::vector<double> three(3, 1.0);
  EXPECT_TRUE(refuses([&] { scene.scale_stiffness(three); }, "a factor for each of 2 material(s), or none, got 3"));
  EXPECT_TRUE(scene.stiffness_factors().empty());

  scene.scale_stiffness({2.0, 3.0});
  EXPECT_EQ(scene.stiffness_factors(), (std::vector<double>{2.0, 3.0}));
  EXPECT_TRUE(refuses([&] { scene.scale_stiffness({2.0}); }, "a factor for each of 2 material(s), or none, got 1"));
  scene.scale_stiffness({});
  EXPECT_TRUE(scene.stiffness_factors().empty());

  const Model plain = make_block({0.03, 0.02, 0.02}, 3, 2, 2);
  Scene without(plain);
  EXPECT_TRUE(refuses([&] { without.scale_stiffness(2.0); }, "expected a model with a material"));
}

TEST(LiveStiffnessOfAScene, IsRefusedWhereItWouldBeIgnored) {
  const Model model = cases()[1].make({});
  Scene scene(model);
  scene.scale_stiffness(2.0);
  const auto topology = std::make_shared<const TopologyTextures>(build_topology(model));
  EXPECT_TRUE(refuses([&] { OutsideBackend(topology, scene); }, "scales the stiffness of materials"));
  scene.scale_stiffness(1.0);
  OutsideBackend solver(topology, scene);
  EXPECT_TRUE(solver.step(1, 1e-6).ok());
  scene.scale_stiffness(2.0);
  EXPECT_EQ(solver.step(1, 1e-6).status, StepStatus::not_supported);
}

}  // namespace
}  // namespace phymul::test
