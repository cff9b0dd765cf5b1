// SPDX-License-Identifier: MIT
//
// Trajectories of the float mirror against the double-precision reference.
#include <gtest/gtest.h>
#include <cmath>
#include <iostream>

#include "conformance/solver_conformance_fixture.h"
#include "mirror.h"
#include "mirror_forces.h"
#include "support/bodies.h"
#include "support/bounded_forces.h"
#include "support/message_of.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

/// A reference and a mirror of one scene over one set of tables.
struct Pair {
  std::unique_ptr<Solver> exact, mirror;
  double dt = 0.0;
};

Pair make_pair(const Scene& scene, const TopologyOptions& options, SolverOptions solver_options) {
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(scene.model(), options));
  solver_options.spectrum = estimate_spectrum(*tables, tables->rest);
  Pair pair{make_solver("reference", tables, scene, solver_options),
            cpu::make_mirror_solver(tables, scene, solver_options)};
  pair.dt = 0.5 * pair.exact->stable_step();
  return pair;
}

Model calibrated_cylinder(const Vec3& origin = Vec3::Zero()) {
  return with_material(moved(cylinder_275(), origin));
}

/// Lower end held, upper end pulled along z, gravity.
Scene pulled(const Model& model, double amount) {
  return Scene(model)
      .fix("bottom")
      .gravity({0, 0, -9.81})
      .add({.type = LoadType::translation,
            .particles = model.group("top"),
            .events = {{0.0, 0.0}, {0.2, amount}},
            .direction = {0, 0, 1}});
}

/// What is left out has the kernels of what is left, and thousands of rows more.
bool takes_seconds(const Variant& variant, const Body& body) {
  if (body.name == "tetrahedron" || body.name == "strip") return true;
  if (body.name == "tetrahedra") return variant.material || variant.options.law == Law::springs;
  return variant.name == "material" && !body.name.starts_with("block");
}

// Undamped bodies of many particles are chaotic; damped ones come back together.
TEST(Mirror, TwoThousandDampedStepsEndWhereTheReferenceEnds) {
  int runs = 0;
  double last_of_all = 0.0, worst_of_all = 0.0;
  for (const Body& body : bodies()) {
    for (const Variant& variant : conservative_variants()) {
      if (!takes_seconds(variant, body)) continue;
      const Model model = prepared(variant, body);
      Scene scene = Scene(model).fix(std::vector<Index>{0, 1, 2});
      const double rate = 0.02;                           // per step
      Pair pair = make_pair(scene, variant.options, {});  // for its step
      pair = make_pair(scene, variant.options, damped(rate / pair.dt));
      State start = displaced(model, 0.1, 5);
      for (Index i : {0, 1, 2}) start.position[i] = model.rest[i];
      pair.exact->reset(start);
      pair.mirror->reset(start);
      double first = 0.0, worst = 0.0;
      ++runs;
      for (int steps = 0; steps < 2000; steps += 100) {
        ASSERT_TRUE(pair.exact->step(100, pair.dt).ok()) << body.name << ", " << variant.name;
        ASSERT_TRUE(pair.mirror->step(100, pair.dt).ok()) << body.name << ", " << variant.name;
        const double apart = largest_distance(pair.exact->read().position, pair.mirror->read().position);
        if (steps == 0) first = apart;
        worst = std::max(worst, apart);
      }
      const double size = body_size(model);
      const double last = largest_distance(pair.exact->read().position, pair.mirror->read().position);
      EXPECT_LE(last, 1e-5 * size) << body.name << ", " << variant.name << ": " << first / size << " after 100 steps, "
                                   << worst / size << " at worst";
      last_of_all = std::max(last_of_all, last / size);
      worst_of_all = std::max(worst_of_all, worst / size);
    }
  }
  EXPECT_GT(runs, 20);
  std::cout << runs << " runs, apart by up to " << worst_of_all << " of the body's size, at the end by " << last_of_all
            << "\n";
}

TEST(Mirror, FarFromTheOriginNothingIsLost) {
  const Model model = calibrated_cylinder({1000.0, 0.0, 0.0});
  const Scene scene = pulled(model, 0.005);
  const Pair pair = make_pair(scene, {}, damped(20.0));
  ASSERT_TRUE(all_step(3000, pair.dt, pair.exact, pair.mirror));
  const double apart = largest_distance(pair.exact->read().position, pair.mirror->read().position) / body_size(model);
  std::cout << "apart by " << apart << " of the body's size\n";
  EXPECT_LE(apart, 1e-6);
}

TEST(Mirror, RestsAtTheStepOfTheReference) {
  const Model model = calibrated_cylinder();
  const Scene scene = pulled(model, 0.005);
  const Pair pair = make_pair(scene, {}, {.damping = {.rate = 20.0}, .rest_tolerance = 1e-6});
  const int warm = static_cast<int>(std::ceil(0.2 / pair.dt));
  ASSERT_TRUE(all_step(warm, pair.dt, pair.exact, pair.mirror));
  const RestResult exact = pair.exact->run_to_rest(20000, pair.dt), mirror = pair.mirror->run_to_rest(20000, pair.dt);
  EXPECT_TRUE(exact.converged() && mirror.converged());
  std::cout << "steps to rest: reference " << exact.report.steps << ", mirror " << mirror.report.steps << "\n";
  EXPECT_NEAR(exact.report.steps, mirror.report.steps, 2e-3 * exact.report.steps);
  EXPECT_LE(largest_distance(pair.exact->read().position, pair.mirror->read().position), 1e-5 * body_size(model));
}

// The default tolerance is below what a float can tell of a body pulled by its own spacing.
TEST(Mirror, ComesToRestAtItsOwnNoise) {
  const Model model = calibrated_cylinder();
  for (const double amount : {0.0005, 0.005}) {
    const Scene scene = pulled(model, amount);
    const Pair pair = make_pair(scene, {}, damped(20.0));
    ASSERT_TRUE(pair.mirror->step(static_cast<int>(std::ceil(0.2 / pair.dt)), pair.dt).ok());
    const RestResult rest = pair.mirror->run_to_rest(4000, pair.dt);
    EXPECT_TRUE(rest.converged()) << amount;
    std::cout << "pulled by " << amount << " m: " << rest.report.steps << " steps\n";
  }
}

TEST(Mirror, ComesToRestTurned) {
  const Model model = calibrated_cylinder();
  Scene scene = Scene(model).add({.type = LoadType::rotation,
                                  .particles = model.group("bottom"),
                                  .events = {{0.0, 0.0}, {0.5, 2.0}},
                                  .direction = {1, 0, 0}});
  const Pair pair = make_pair(scene, {}, damped(40.0));
  ASSERT_TRUE(pair.mirror->step(static_cast<int>(std::ceil(0.5 / pair.dt)), pair.dt).ok());
  const RestResult rest = pair.mirror->run_to_rest(4000, pair.dt);
  EXPECT_TRUE(rest.converged());
  std::cout << "turned by 2 rad: " << rest.report.steps << " steps\n";
}

TEST(Mirror, EnumeratedBasesMoveTheBodyAlike) {
  const Model model = jittered_block();
  const Scene scene(model);
  const TopologyOptions options{.reaction = Reaction::barycentric, .bases = BaseSelection::all};
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, options));
  const SolverOptions damped{.damping = {.factor = 0.9}};
  const auto table = cpu::make_mirror_solver(tables, scene, damped),
             enumerated = cpu::make_mirror_solver(tables, scene, damped, FloatLayout::enumerated);
  const State start = displaced(model, 0.05, 2);
  table->reset(start);
  enumerated->reset(start);
  ASSERT_TRUE(all_step(200, 0.4 * table->stable_step(), table, enumerated));
  EXPECT_LE(largest_distance(table->read().position, enumerated->read().position), 1e-6 * body_size(model));
}

// The float mirror passes what every backend must. The tests themselves are in solver_conformance_test.cpp.

BackendUnderTest mirror() {
  return {"mirror",
          [](const Model& model, const Scene& scene, const TopologyOptions& topology, const SolverOptions& options) {
            return cpu::make_mirror_solver(std::make_shared<const TopologyTextures>(build_topology(model, topology)),
                                           scene, options);
          },
          0x1p-24};
}

INSTANTIATE_TEST_SUITE_P(Float, SolverConformance, testing::Values(mirror()),
                         [](const auto& backend) { return backend.param.name; });

// The mirror's forces in float (mirror_forces.h) against those in double: within the rounding bound, and nothing at all
// at rest. The vector kernels of the backend "cpu" are tested in tests/cpu.

using cpu::Float3;

bool can_carry(const Variant& variant, const Body& body) {
  return !(variant.options.volume_stiffness > 0.0 && body.model.cells.empty());
}

struct Case {
  std::string name;
  Model model;
  TopologyTextures topology;
};

/// One body with every variant it can carry.
template <class Visit>
void for_each_variant(const Body& body, const Visit& visit) {
  for (const Variant& variant : all_variants()) {
    if (!can_carry(variant, body)) continue;
    const Model model = prepared(variant, body);
    visit(Case{body.name + ", " + variant.name, model, build_topology(model, variant.options)});
  }
}

/// Every body with every variant it can carry.
template <class Visit>
void for_each_case(const Visit& visit) {
  for (const Body& body : bodies()) for_each_variant(body, visit);
}

/// Displacements of random positions, rounded to float.
std::vector<Float3> random_displacements(const Model& model, double amount, std::uint32_t seed) {
  const VecList x = random_positions(model, amount, seed);
  std::vector<Float3> u;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 d = x[i] - model.rest[i];
    u.push_back({static_cast<float>(d.x()), static_cast<float>(d.y()), static_cast<float>(d.z())});
  }
  return u;
}

VecList widened(const std::vector<Float3>& list) {
  VecList wide;
  for (const Float3& v : list) wide.emplace_back(v.x, v.y, v.z);
  return wide;
}

/// Largest error over bound of the forces at u; a failure where it is above 1.
double worst_force_ratio(const Case& body, const cpu::MirrorForces& forces, const std::vector<Float3>& u) {
  std::vector<Float3> force(u.size());
  forces.evaluate(u, force);
  const VecList wide = widened(u), found = widened(force);
  const VecList exact = forces_at(body.topology, sum_of(body.topology.rest, wide));
  const BoundedForces bounded(body.topology, wide);
  double worst = 0.0;
  for (Index i = 0; i < body.topology.particle_count; ++i) {
    const Bounded3 bound = bounded.force(i);
    const std::array<Bounded, 3> axes{bound.x, bound.y, bound.z};
    for (int axis = 0; axis < 3; ++axis) {
      const Bounded& b = axes[static_cast<std::size_t>(axis)];
      const double error = std::abs(found[i][axis] - exact[i][axis]);
      EXPECT_LE(error, b.error) << body.name << ", particle " << i << ", axis " << axis << ", force " << exact[i][axis];
      // The formulas themselves, apart from their rounding: the literals are rounded, and exact itself to 2^-53.
      EXPECT_LE(std::abs(b.value - exact[i][axis]), 0.1 * b.error);
      EXPECT_TRUE(std::isfinite(b.error)) << body.name << ", particle " << i;
      if (b.error > 0.0) worst = std::max(worst, error / b.error);
    }
  }
  return worst;
}

TEST(MirrorKernels, NoForceAtRest) {
  for_each_case([](const Case& body) {
    const cpu::MirrorForces forces(pack_floats(body.topology));
    const std::vector<Float3> u(body.model.rest.size());
    std::vector<Float3> force(u.size(), Float3{1, 1, 1});
    forces.evaluate(u, force);
    for (const Float3& f : force) EXPECT_EQ(f, Float3{}) << body.name;
  });
}

TEST(MirrorKernels, NoForceAfterATranslation) {
  for_each_case([](const Case& body) {
    const cpu::MirrorForces forces(pack_floats(body.topology));
    std::vector<Float3> u(body.model.rest.size(), Float3{1.5f, -0.3f, body.model.dimension == 2 ? 0.0f : 7.7f});
    std::vector<Float3> force(u.size(), Float3{1, 1, 1});
    forces.evaluate(u, force);
    for (const Float3& f : force) EXPECT_EQ(f, Float3{}) << body.name;
  });
}

constexpr std::uint32_t random_states = sanitized ? 5 : 100;

class MirrorKernelsOf : public testing::TestWithParam<std::size_t> {};

TEST_P(MirrorKernelsOf, ForcesAreWithinTheRoundingBound) {
  double worst = 0.0;
  for_each_variant(bodies()[GetParam()], [&](const Case& body) {
    const cpu::MirrorForces forces(pack_floats(body.topology));
    for (std::uint32_t state = 0; state < random_states; ++state) {
      const double amount = 0.05 + 0.25 * state / random_states;
      worst = std::max(worst, worst_force_ratio(body, forces, random_displacements(body.model, amount, state + 1)));
    }
  });
  // A bound that nothing comes near would hide mistakes.
  EXPECT_GT(worst, 0.01);
  std::cout << "worst error over bound " << worst << "\n";
}

INSTANTIATE_TEST_SUITE_P(Bodies, MirrorKernelsOf, testing::Range(std::size_t{0}, bodies().size()),
                         [](const auto& body) { return bodies()[body.param].name; });

TEST(MirrorKernels, SmallStrainsKeepTheirDigits) {
  double worst = 0.0;
  for_each_case([&](const Case& body) {
    const cpu::MirrorForces forces(pack_floats(body.topology));
    const std::vector<Float3> u = random_displacements(body.model, 1e-6, 3);
    worst = std::max(worst, worst_force_ratio(body, forces, u));
    const BoundedForces bounded(body.topology, widened(u));
    double largest = 0.0, error = 0.0;
    for (Index i = 0; i < body.topology.particle_count; ++i) {
      largest = std::max(largest, std::abs(bounded.force(i).x.value));
      error = std::max(error, bounded.force(i).x.error);
    }
    EXPECT_LE(error, 2e-3 * largest) << body.name;
  });
  std::cout << "worst error over bound " << worst << "\n";
}

TEST(MirrorKernels, EnumeratedBasesGiveTheForcesOfTheTable) {
  for (const Body& body : bodies()) {
    for (const Variant& variant : all_variants()) {
      const bool enumerable = variant.name.find(" all") != std::string::npos &&
                              variant.options.reaction != Reaction::conservative && body.model.dimension == 3;
      if (!enumerable) continue;
      const Case it{body.name + ", " + variant.name, body.model, build_topology(body.model, variant.options)};
      const cpu::MirrorForces forces(pack_floats(it.topology, FloatLayout::enumerated));
      std::vector<Float3> force(body.model.rest.size());
      forces.evaluate(std::vector<Float3>(force.size()), force);
      for (const Float3& f : force) EXPECT_EQ(f, Float3{}) << it.name;
      for (std::uint32_t state = 0; state < 10; ++state) {
        worst_force_ratio(it, forces, random_displacements(body.model, 0.05 + 0.025 * state, state + 1));
      }
    }
  }
}

}  // namespace

}  // namespace phymul::test
