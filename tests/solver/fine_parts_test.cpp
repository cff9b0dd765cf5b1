// SPDX-License-Identifier: MIT
//
// SolverOptions::max_substeps: parts with small cells, and joints that are stiffer than the organ_tissue.
#include <phymul/phymul.h>

#include <gtest/gtest.h>
#include <algorithm>
#include <random>

#include "elastic/fine_parts.h"
#include "support/allocation_count.h"
#include "support/bodies.h"

namespace phymul::test {
namespace {

constexpr double organ_length = 0.08;  // m
const Material organ_tissue{5e3, 0.45, 1000.0};

Model organ(const Material& material = organ_tissue) {
  return with_material(make_body(solid_ellipsoid({0, 0, 0}, {organ_length, 0.06, 0.04}), {.spacing = 0.014}), material);
}

/// Above it a duct of the same material at a third of its spacing.
Model with_duct(const Material& material = organ_tissue) {
  const Solid solid = solid_capsule({-0.02, 0, 0.049}, {0.02, 0, 0.049}, 0.007);
  const Model lower = organ(material),
              upper = with_material(make_body(solid, {.spacing = 0.014 / 3.0, .most_volume_error = 0.3}), material);
  return merged({{"organ", &lower}, {"duct", &upper}});
}

/// Ties two places of the organ, and the duct to it, by springs that alone would shorten the step by ten times.
void add_lock(Scene& scene, double stiffness = 3e4) {
  const Model& model = scene.model();
  const auto nearest = [&](const Vec3& place) {
    std::vector<Index> all = every_particle(model);
    std::ranges::sort(all, {}, [&](Index i) { return (model.rest[i] - place).norm(); });
    return all;
  };
  const std::vector<Index> left = nearest({-0.02, 0, -0.04}), right = nearest({0.02, 0, -0.04}),
                           top = nearest({0, 0, 0.036}), middle = nearest({0, 0, 0.049});
  Joint joint{.springs = {}, .stiffness = stiffness};
  for (std::size_t k = 0; k < 9; ++k) {
    joint.springs.push_back({at_particle(left[k]), at_mean({right[2 * k], right[2 * k + 1]})});
    joint.springs.push_back({at_particle(top[k]), at_particle(middle[k])});
  }
  scene.add_joint("lock", joint);
}

std::vector<Index> left_end(const Model& model) {
  std::vector<Index> held;
  for (const Index i : every_particle(model)) {
    if (model.rest[i].x() < -0.018) held.push_back(i);
  }
  return held;
}

std::unique_ptr<Solver> local_solver(const char* backend, const Model& model, const Scene& scene, int substeps,
                                     double damping = 0.0, UnstableStep beyond = UnstableStep::refuse) {
  const SolverOptions options{.damping = {.rate = damping}, .on_unstable = beyond, .max_substeps = substeps};
  return make_solver(backend, model, scene, {}, options);
}

VecList scattered_vectors(std::size_t count, double size, std::uint32_t seed) {
  std::mt19937 bits(seed);
  VecList vectors(count);
  for (Vec3& v : vectors) {
    for (double& c : v) c = size * (static_cast<double>(bits()) / 4294967296.0 - 0.5);
  }
  return vectors;
}

State swinging(const Model& model) {
  State state;
  state.position = model.rest;
  for (const Vec3& x : model.rest)
    state.velocity.emplace_back(0.0, 0.0, x.x() > -0.018 ? 2.0 * std::pow(x.x() + 0.018, 2) : 0.0);
  return state;
}

TEST(FineParts, GiveALargerInertiaToRoughMotionsAlone) {
  const TopologyTextures t = build_topology(with_duct(), {});
  const FineParts parts = choose_fine_parts(t, {});
  const std::size_t n = parts.particle.size();
  ASSERT_GE(n, 150u);
  VecList f = scattered_vectors(n, 1.0, 3), g = scattered_vectors(n, 1.0, 4), of_f(n), of_g(n), nodes(parts.nodes());
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
  const Model plain = organ(), model = with_duct();
  Scene of_plain(plain), scene(model);
  const double alone = local_solver(GetParam(), plain, of_plain, 1)->stable_step();
  const double together = local_solver(GetParam(), model, scene, 1)->stable_step();
  EXPECT_LT(together, 0.5 * alone);
  const double free = local_solver(GetParam(), model, scene, 16)->stable_step();
  EXPECT_GT(free, 1.7 * together);
  const Model with_room = with_spare_particles(model, 10);
  const Scene of_room(with_room);
  EXPECT_NEAR(local_solver(GetParam(), with_room, of_room, 16)->stable_step(), free, 1e-3 * free);
  add_lock(scene);
  EXPECT_LT(local_solver(GetParam(), model, scene, 1)->stable_step(), 0.1 * alone);
  EXPECT_EQ(local_solver(GetParam(), model, scene, 16)->stable_step(), free);
}

TEST_P(FinePartsOn, IsBoundedBelowTheLimitAndDivergesAboveIt) {
  const Model model = with_duct();
  for (const bool glued : {false, true}) {
    Scene scene(model);
    if (glued) {  // springs of rest length 0
      Joint joint{.springs = {}, .stiffness = 1e5};
      for (Index k = 0; k < 12; ++k) {
        joint.springs.push_back({at_particle(7 * k), at_world(model.rest[7 * k]), 0.0});
      }
      scene.add_joint("glue", joint);
    } else {
      add_lock(scene);
    }
    for (const double share : {0.97, 1.06}) {
      const auto solver = local_solver(GetParam(), model, scene, 16, 0.0, UnstableStep::allow);
      State state = solver->read();
      const VecList noise = scattered_vectors(state.position.size(), 1e-6 * organ_length, 5);
      for (std::size_t i = 0; i < noise.size(); ++i) state.position[i] += noise[i];
      solver->reset(state);
      const StepReport report = solver->step(200, share * solver->stable_step());
      const double moved = largest_distance(solver->read().position, model.rest);
      if (share < 1.0) {
        EXPECT_TRUE(report.ok()) << report.cause;
        EXPECT_LT(moved, 1e-3 * organ_length);
      } else {
        EXPECT_TRUE(!report.ok() || moved > 1e-2 * organ_length) << moved;
      }
    }
  }
}

TEST_P(FinePartsOn, StandStillWhereAToolHoldsThem) {
  const Model model = with_duct();
  Scene scene(model);
  scene.add_tool("jaw", {.shape = Sphere{0.006}, .pose = {.position = {0, 0, 0.049}}});
  const auto solver = local_solver(GetParam(), model, scene, 8);
  scene.tool("jaw").grasp(0.0005);
  ASSERT_TRUE(solver->step(1, 0.1 * solver->stable_step()).ok());
  ASSERT_GT(solver->held("jaw"), 3);
  State state = solver->read();
  state.velocity = scattered_vectors(state.velocity.size(), 1e-6, 5);
  solver->reset(state);
  EXPECT_LT(solver->step(2000, 0.9 * solver->stable_step()).max_speed, 1e-5);
}

TEST(FineParts, RestShapesAreThoseOfShortSteps) {
  const Model model = with_duct();
  std::vector<VecList> shape;
  std::vector<double> force;
  for (const int substeps : {1, 16}) {
    Scene scene = Scene(model).fix(left_end(model)).gravity({0, 0, -1.0});
    add_lock(scene, 300.0);
    scene.add_tool("ball", {.shape = Sphere{.radius = 0.03}, .pose = {.position = {0.01, 0, 0.056 + 0.03 - 0.006}}});
    const auto solver = local_solver("cpu", model, scene, substeps, 40.0);
    const double dt = 0.5 * solver->stable_step();
    ASSERT_TRUE(solver->step(static_cast<int>(1.0 / dt), dt).ok());
    shape.push_back(solver->read().position);
    force.push_back(solver->tool_force("ball").force.z());
  }
  EXPECT_GT(std::abs(force[0]), 1e-3);
  EXPECT_NEAR(force[1], force[0], 2e-3 * std::abs(force[0]));
  EXPECT_LT(largest_distance(shape[1], shape[0]), 2e-3 * largest_distance(shape[0], model.rest));
}

/// Ratio of the largest change of the energy in so many undamped steps.
double largest_energy_change(const char* backend, int steps) {
  const Model model = with_duct();
  Scene scene = Scene(model).fix(left_end(model));
  add_lock(scene);
  const auto solver = local_solver(backend, model, scene, 16);
  const double dt = 0.5 * solver->stable_step();
  solver->start(swinging(model), dt);
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
  EXPECT_LT(largest_energy_change(GetParam(), GetParam() == std::string("cpu") ? 10000 : 1000), 1e-3);
}

TEST(LongFineParts, EnergyIsKept) {
  EXPECT_LT(largest_energy_change("cpu", 100000), 1e-3);
}

TEST(FineParts, KeepMomentum) {
  for (const bool duct : {false, true}) {
    const Model model =
        duct ? with_duct()
             : with_material(make_tetrahedral_block(Vec3::Constant(organ_length), 4, 4, 4, 0.2, 7), organ_tissue);
    Scene scene(model);
    add_lock(scene);
    const auto solver = local_solver("reference", model, scene, 16);
    State state = solver->read();
    state.velocity = scattered_vectors(state.velocity.size(), 1e-4, 11);
    solver->reset(state);
    const Momentum before = solver->momentum();
    double of_all = 0.0;
    for (std::size_t i = 0; i < state.velocity.size(); ++i) of_all += model.mass[i] * state.velocity[i].norm();
    ASSERT_TRUE(solver->step(100, 0.8 * solver->stable_step()).ok());
    EXPECT_LT((solver->momentum().linear - before.linear).norm(), 1e-12 * of_all);
    // Of the larger masses of fine parts it is conserved, and of these only the whole is known.
    if (!duct) {
      EXPECT_LT((solver->momentum().angular - before.angular).norm(), 1e-12 * organ_length * of_all);
    }
  }
}

TEST_P(FinePartsOn, GoesOnFromASnapshotBitForBitAndAllocatesNothing) {
  const Model model = with_duct();
  Scene scene = Scene(model).fix(left_end(model)).gravity({0, 0, -1.0});
  add_lock(scene);
  scene.add_tool("ball", {.shape = Sphere{.radius = 0.03}, .pose = {.position = {0.01, 0, 0.056 + 0.03 - 0.001}}});
  const auto solver = local_solver(GetParam(), model, scene, 16, 100.0),
             other = local_solver(GetParam(), model, scene, 16, 100.0);
  const double dt = 0.5 * solver->stable_step();
  ASSERT_TRUE(solver->step(100, dt).ok());
  const Snapshot snapshot = solver->snapshot();
  ASSERT_EQ(snapshot.parts.size(), 1u) << "the ball pushes the duct, or this shows little";
  other->restore(snapshot);
  const std::size_t before = allocation_count();
  ASSERT_TRUE(solver->step(20, dt).ok());
  EXPECT_EQ(allocation_count(), before);
  ASSERT_TRUE(other->step(20, dt).ok());
  EXPECT_EQ(solver->read().position, other->read().position);
}

TEST_P(FinePartsOn, TissueThatDissipatesMayHaveThem) {
  Material slow = organ_tissue;
  slow.retardation_time = 2e-3;
  slow.relaxation_strength = 0.5;
  slow.relaxation_time = 0.05;
  const Model model = with_duct(slow);
  Scene scene = Scene(model).fix(left_end(model));
  add_lock(scene);
  EXPECT_LT(local_solver(GetParam(), model, scene, 1)->stable_step(),
            0.3 * local_solver(GetParam(), model, scene, 16)->stable_step());
  const auto solver = local_solver(GetParam(), model, scene, 16);
  const double dt = 0.95 * solver->stable_step();
  solver->start(swinging(model), dt);
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 10; ++k) {
    ASSERT_TRUE(solver->step(100, dt).ok());
    const double now = solver->energy().total();
    EXPECT_LT(now, before);
    before = now;
  }
}

// SolverOptions::max_substeps under tools: a tumour at the top of a soft cube.

const Vec3 tumour_top(0.05, 0.05, 0.1);  // m

Model tumour_at_the_top() {
  Model model = with_material(make_tetrahedral_block({0.1, 0.1, 0.1}, 6, 6, 6, 0.2, 7), {5e3, 0.45, 1000.0});
  set_material(model, {500e3, 0.45, 1000.0}, [](const Vec3& place) { return (place - tumour_top).norm() < 0.0168; });
  return model;
}

/// Critical damping takes a shorter step than the one that it was chosen for.
TEST(LocalStepsUnderTools, ComeToRest) {
  SimulationOptions options{.backend = "cpu"};
  options.solver.max_substeps = 32;
  Simulation sim(tumour_at_the_top(), options);
  sim.scene().fix("z0").add_tool("ball",
                                 {.shape = Sphere{0.03}, .pose = {.position = tumour_top + Vec3(0, 0, 0.03 - 0.002)}});
  ASSERT_GT(sim.solver().substeps(), 2);
  const RestResult rest = sim.run_to_rest(5'000);
  EXPECT_TRUE(rest.converged()) << rest.message();
}

/// m/s, the largest in the 50 ms after a particle that was pulled by 5 mm is let go.
double speed_of_release(const char* backend, const Model& model, int substeps) {
  Scene scene = Scene(model).fix("z0");
  const Index pulled = model.particles_in([](const Vec3& at) { return (at - tumour_top).norm() < 0.012; }).front();
  const auto pose = [&](double by) { return ToolPose{.position = model.rest[pulled] + Vec3(0, 0, 0.0035 + by)}; };
  scene.add_tool("jaw", {.shape = Sphere{0.003}, .pose = pose(0.0)});
  const auto solver = make_solver(backend, model, scene, {}, {.damping = {.rate = 40.0}, .max_substeps = substeps});
  scene.tool("jaw").grasp(0.001);
  const double dt = 0.5 * solver->stable_step();
  const int steps = static_cast<int>(0.5 / dt);
  for (int k = 0; k < steps; ++k) {
    scene.tool("jaw").move_to(pose(5e-3 * std::min(1.0, 2.0 * k / steps)));
    EXPECT_TRUE(solver->step(1, dt).ok());
  }
  EXPECT_EQ(solver->held("jaw"), 1);
  scene.tool("jaw").release();
  double speed = 0.0;
  for (double t = 0.0; t < 0.05; t += dt) {
    const StepReport report = solver->step(1, dt);
    EXPECT_TRUE(report.ok() && !report.force_clamped);
    speed = std::max(speed, report.max_speed);
  }
  return speed;
}

TEST(LocalStepsUnderTools, LetGoWithoutAKick) {
  const Model model = tumour_at_the_top();
  for (const char* const backend : {"reference", "cpu"}) {
    EXPECT_LT(speed_of_release(backend, model, 32), 1.3 * speed_of_release(backend, model, 1)) << backend;
  }
}

}  // namespace

}  // namespace phymul::test
