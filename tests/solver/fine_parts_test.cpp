// SPDX-License-Identifier: MIT
//
// SolverOptions::max_substeps: parts with small cells, and joints that are stiffer than the tissue.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include <random>

#include "elastic/fine_parts.h"
#include "support/allocation_count.h"
#include "support/bodies.h"

namespace phymul::test {
namespace {

constexpr double edge = 0.1;  // m
const Material tissue{5e3, 0.45, 1000.0};

Model cube(const Material& material = tissue) {
  return with_material(make_tetrahedral_block({edge, edge, edge}, 5, 5, 5, 0.2, 7), material);
}

/// A cube, and above it a bar of the same material with cells a third as large.
Model with_bar(const Material& material = tissue) {
  const Model bar = with_material(make_tetrahedral_block({edge, 0.2 * edge, 0.2 * edge}, 15, 3, 3, 0.2, 7), material);
  const Model lower = cube(material), upper = moved(bar, {0.0, 0.0, 1.1 * edge});
  return merged({{"cube", &lower}, {"bar", &upper}});
}

/// Ties two places of the cube, and the bar to it, by springs that alone would shorten the step by more than ten times.
void lock(Scene& scene, double stiffness = 3e5) {
  Joint joint{.springs = {}, .stiffness = stiffness};
  const Index count = scene.model().particle_count();
  for (Index k = 0; k < 9; ++k) {
    const Index a = 37 + 2 * k;
    joint.springs.push_back({at_particle(a), at_mean({a + 144, a + 145})});
    if (count > 216) joint.springs.push_back({at_particle(198 + k), at_particle(count - 1 - 16 * k)});
  }
  scene.add_joint("lock", joint);
}

std::unique_ptr<Solver> solver_of(const char* backend, const Model& model, const Scene& scene, int substeps,
                                  double damping = 0.0, UnstableStep beyond = UnstableStep::refuse) {
  const SolverOptions options{.damping = {.rate = damping}, .on_unstable = beyond, .max_substeps = substeps};
  return make_solver(backend, model, scene, {}, options);
}

VecList random_vectors(std::size_t count, double size, std::uint32_t seed) {
  std::mt19937 bits(seed);
  VecList vectors(count);
  for (Vec3& v : vectors) {
    for (double& c : v) c = size * (static_cast<double>(bits()) / 4294967296.0 - 0.5);
  }
  return vectors;
}

State start_of(const Model& model) {
  State state;
  state.position = model.rest;
  for (const Vec3& x : model.rest) state.velocity.emplace_back(0.0, 0.0, 5.0 * x.x() * x.x());
  return state;
}

TEST(FineParts, GiveALargerInertiaToRoughMotionsAlone) {
  const TopologyTextures t = build_topology(with_bar(), {});
  const FineParts parts = choose_fine_parts(t, {});
  const std::size_t n = parts.particle.size();
  ASSERT_GE(n, 200u);
  ASSERT_LE(n, 300u);
  VecList f = random_vectors(n, 1.0, 3), g = random_vectors(n, 1.0, 4), of_f(n), of_g(n), nodes(parts.nodes());
  parts.changes<Vec3>(f, of_f, nodes);
  parts.changes<Vec3>(g, of_g, nodes);
  Vec3 sum = Vec3::Zero();
  double fg = 0.0, gf = 0.0, taken = 0.0, all = 0.0;
  for (std::size_t r = 0; r < n; ++r) {
    sum += of_f[r];
    fg += g[r].dot(of_f[r]) / parts.mass[r];
    gf += f[r].dot(of_g[r]) / parts.mass[r];
    taken -= f[r].dot(of_f[r]) / parts.mass[r];
    all += f[r].squaredNorm() / parts.mass[r];
  }
  EXPECT_LT(sum.norm(), 1e-12);
  EXPECT_NEAR(fg, gf, 1e-12 * all);
  EXPECT_GT(taken, 0.5 * all);
  EXPECT_LT(taken, (1.0 - 1.0 / parts.inertia) * all);
  for (std::size_t r = 0; r < n; ++r) f[r] = parts.mass[r] * Vec3(1.0, -2.0, 3.0);
  parts.changes<Vec3>(f, of_f, nodes);
  for (std::size_t r = 0; r < n; ++r) EXPECT_LT(of_f[r].norm(), 1e-12 * f[r].norm());
}

class FinePartsOn : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Cpu, FinePartsOn, testing::Values("reference", "cpu"),
                         [](const auto& backend) { return std::string(backend.param); });

TEST_P(FinePartsOn, NeitherSmallCellsNorALockSetTheStep) {
  const Model plain = cube(), model = with_bar();
  Scene of_plain(plain), scene(model);
  const double alone = solver_of(GetParam(), plain, of_plain, 1)->stable_step();
  EXPECT_LT(solver_of(GetParam(), model, scene, 1)->stable_step(), 0.45 * alone);
  const double free = solver_of(GetParam(), model, scene, 16)->stable_step();
  EXPECT_GT(free, 0.9 * alone);
  lock(scene);
  EXPECT_LT(solver_of(GetParam(), model, scene, 1)->stable_step(), 0.1 * alone);
  EXPECT_EQ(solver_of(GetParam(), model, scene, 16)->stable_step(), free);
}

TEST_P(FinePartsOn, IsBoundedBelowTheLimitAndDivergesAboveIt) {
  const Model model = with_bar();
  for (const bool glued : {false, true}) {
    Scene scene(model);
    if (glued) {  // springs of rest length 0
      const std::vector<Index> below = model.group("bar/z0");
      scene.attach({below.begin(), below.begin() + 16}, "cube", {.stiffness = 1e9});
    } else {
      lock(scene);
    }
    for (const double share : {0.97, 1.06}) {
      const auto solver = solver_of(GetParam(), model, scene, 16, 0.0, UnstableStep::allow);
      State state = solver->read();
      const VecList noise = random_vectors(state.position.size(), 1e-6 * edge, 5);
      for (std::size_t i = 0; i < noise.size(); ++i) state.position[i] += noise[i];
      solver->reset(state);
      const StepReport report = solver->step(2000, share * solver->stable_step());
      const double moved = largest_distance(solver->read().position, model.rest);
      if (share < 1.0) {
        EXPECT_TRUE(report.ok()) << report.cause;
        EXPECT_LT(moved, 1e-3 * edge);
      } else {
        EXPECT_TRUE(!report.ok() || moved > 1e-2 * edge) << moved;
      }
    }
  }
}

TEST_P(FinePartsOn, RestShapesAreThoseOfShortSteps) {
  const Model model = with_bar();
  std::vector<Index> held = model.group("cube/z0");
  for (const Index i : model.group("bar/x0")) held.push_back(i);
  std::vector<VecList> shape;
  std::vector<double> force;
  for (const int substeps : {1, 16}) {
    Scene scene = Scene(model).fix(held).gravity({0, 0, -1.0});
    lock(scene, 300.0);
    scene.add_tool("ball", {.shape = Sphere{.radius = 0.03},
                            .pose = {.position = {0.7 * edge, 0.1 * edge, 1.3 * edge + 0.03 - 0.002}}});
    const auto solver = solver_of(GetParam(), model, scene, substeps, 40.0);
    const double dt = 0.5 * solver->stable_step();
    ASSERT_TRUE(solver->step(static_cast<int>(1.5 / dt), dt).ok());
    shape.push_back(solver->read().position);
    force.push_back(solver->tool_force("ball").force.z());
  }
  EXPECT_GT(std::abs(force[0]), 1e-3);
  EXPECT_NEAR(force[1], force[0], 2e-3 * std::abs(force[0]));
  EXPECT_LT(largest_distance(shape[1], shape[0]), 2e-3 * largest_distance(shape[0], model.rest));
}

/// Ratio of the largest change of the energy in so many undamped steps.
double energy_change(const char* backend, int steps) {
  const Model model = with_bar();
  Scene scene = Scene(model).fix("cube/x0");
  lock(scene);
  const auto solver = solver_of(backend, model, scene, 16);
  const double dt = 0.5 * solver->stable_step();
  solver->start(start_of(model), dt);
  EXPECT_TRUE(solver->step(1, dt).ok());
  const double before = solver->energy().total();
  double differs = 0.0;
  for (int k = 0; k < 100; ++k) {
    EXPECT_TRUE(solver->step(steps / 100, dt).ok());
    differs = std::max(differs, std::abs(solver->energy().total() / before - 1.0));
  }
  testing::Test::RecordProperty("per_mille", std::to_string(1e3 * differs));
  return differs;
}

TEST_P(FinePartsOn, EnergyIsKept) {
  EXPECT_LT(energy_change(GetParam(), GetParam() == std::string("cpu") ? 10000 : 1000), 1e-3);
}

TEST(LongFineParts, EnergyIsKept) {
  EXPECT_LT(energy_change("cpu", 100000), 1e-3);
}

TEST(FineParts, KeepMomentum) {
  for (const bool bar : {false, true}) {
    const Model model = bar ? with_bar() : cube();
    Scene scene(model);
    lock(scene);
    const auto solver = solver_of("reference", model, scene, 16);
    State state = solver->read();
    state.velocity = random_vectors(state.velocity.size(), 0.02, 11);
    solver->reset(state);
    const Momentum before = solver->momentum();
    double of_all = 0.0;
    for (std::size_t i = 0; i < state.velocity.size(); ++i) of_all += model.mass[i] * state.velocity[i].norm();
    ASSERT_TRUE(solver->step(500, 0.8 * solver->stable_step()).ok());
    EXPECT_LT((solver->momentum().linear - before.linear).norm(), 1e-12 * of_all);
    // Of the larger masses of fine parts it is conserved, and of these only the whole is known.
    if (!bar) EXPECT_LT((solver->momentum().angular - before.angular).norm(), 1e-12 * edge * of_all);
  }
}

TEST_P(FinePartsOn, GoesOnFromASnapshotBitForBitAndAllocatesNothing) {
  const Model model = with_bar();
  Scene scene = Scene(model).fix("cube/z0").gravity({0, 0, -1.0});
  lock(scene);
  scene.add_tool("ball", {.shape = Sphere{.radius = 0.03},
                          .pose = {.position = {0.5 * edge, 0.1 * edge, 1.3 * edge + 0.03 - 0.002}}});
  const auto solver = solver_of(GetParam(), model, scene, 16, 100.0),
             other = solver_of(GetParam(), model, scene, 16, 100.0);
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(100, dt).ok());
  const Snapshot snapshot = solver->snapshot();
  ASSERT_EQ(snapshot.parts.size(), 1u) << "the ball pushes the bar, or this shows little";
  other->restore(snapshot);
  const std::size_t before = allocation_count();
  ASSERT_TRUE(solver->step(20, dt).ok());
  EXPECT_EQ(allocation_count(), before);
  ASSERT_TRUE(other->step(20, dt).ok());
  EXPECT_EQ(solver->read().position, other->read().position);
}

TEST_P(FinePartsOn, TissueThatDissipatesMayHaveThem) {
  Material slow = tissue;
  slow.retardation_time = 2e-3;
  slow.relaxation_strength = 0.5;
  slow.relaxation_time = 0.05;
  const Model model = with_bar(slow);
  Scene scene = Scene(model).fix("cube/x0");
  lock(scene);
  EXPECT_LT(solver_of(GetParam(), model, scene, 1)->stable_step(),
            0.3 * solver_of(GetParam(), model, scene, 16)->stable_step());
  const auto solver = solver_of(GetParam(), model, scene, 16);
  const double dt = 0.95 * solver->stable_step();
  solver->start(start_of(model), dt);
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 10; ++k) {
    ASSERT_TRUE(solver->step(100, dt).ok());
    const double now = solver->energy().total();
    EXPECT_LT(now, before);
    before = now;
  }
}

}  // namespace
}  // namespace phymul::test
