// SPDX-License-Identifier: MIT
//
// The vector backend: forces within the rounding bound for every term and instruction set, the same bits for any number
// of threads, no allocation in a step.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <thread>

#include "support/allocation_count.h"
#include "support/bodies.h"
#include "support/cpu_forces.h"
#include "support/message_of.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

/// conservative_variants() and the reactions that have no energy.
std::vector<Variant> all_variants() {
  std::vector<Variant> all = conservative_variants();
  for (const auto& [name, reaction] :
       {std::pair{"full", Reaction::full}, std::pair{"shared", Reaction::shared},
        std::pair{"barycentric", Reaction::barycentric}, std::pair{"averaged", Reaction::averaged}}) {
    Variant v;
    v.name = name;
    v.options.reaction = reaction;
    v.options.volume_stiffness = 50.0;
    all.push_back(v);
    v.name += " all";
    v.options.volume_stiffness = 0.0;
    v.options.bases = BaseSelection::all;
    all.push_back(v);
  }
  return all;
}

/// bodies(), and lattices of more particles than a slice has lanes.
std::vector<Body> all_bodies() {
  std::vector<Body> all = bodies();
  all.push_back({"lattice", make_block({0.06, 0.05, 0.06}, 6, 5, 6)});
  all.push_back({"uneven lattice", make_block({0.06, 0.08, 0.045}, 6, 5, 6)});
  return all;
}

struct Case {
  std::string name;
  Model model;
  std::shared_ptr<const TopologyTextures> tables;
};

template <class Visit>
void for_each_case(const Visit& visit) {
  for (const Body& body : all_bodies()) {
    for (const Variant& variant : all_variants()) {
      const bool lattice = body.name.ends_with("lattice");
      if (lattice && !variant.material) continue;
      const Model model = prepared(variant, body);
      visit(Case{body.name + ", " + variant.name, model,
                 std::make_shared<const TopologyTextures>(build_topology(model, variant.options))});
    }
  }
}

TEST(CpuBackend, ForcesAreWithinTheRoundingBound) {
  ShareOfBound shares;
  for_each_case([&](const Case& body) {
    const Scene scene(body.model);
    for (const double amount : {0.001, 0.1, 0.3}) {
      shares.look(body.tables, scene, random_displacements(body.model, amount, 11), body.name);
    }
  });
  shares.expect_some();
}

/// All others at rest: rows of a slice go by the widest ratio among them.
TEST(CpuBackend, ForcesBesideAFarParticleAreWithinTheRoundingBound) {
  const Model model = make_block({0.06, 0.06, 0.06}, 6, 6, 6, 26);
  const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, {.law = Law::springs}));
  const Scene scene(model);
  ShareOfBound shares;
  for (const double way : {0.4, 4.0, 1e4}) {
    for (const Index moved : {0, model.particle_count() / 3, model.particle_count() / 2, model.particle_count() - 1}) {
      VecList u(model.rest.size(), Vec3::Zero());
      u[moved] = (way * mean_spacing(model) * Vec3(1.0, -0.5, 0.25)).cast<float>().cast<double>();
      shares.look(tables, scene, u, std::to_string(way) + " of " + std::to_string(moved));
    }
  }
}

/// Bases on a line have no normals: which way rounding makes them point must not matter.
TEST(CpuBackend, ABodyOnALineHasTheForcesOfDoublePrecision) {
  const Model model = make_block({0.02, 0.02, 0.02}, 1, 1, 1);
  const Scene scene(model);
  const Vec3 line = Vec3(1, 2, 4).normalized();  // along which the corners are equally far apart
  VecList x = model.rest;
  for (Vec3& place : x) place = line.dot(place) * line;
  const TopologyOptions some{}, all{.reaction = Reaction::averaged, .bases = BaseSelection::all};
  for (const TopologyOptions& options : {some, all}) {
    const auto tables = std::make_shared<const TopologyTextures>(build_topology(model, options));
    const VecList exact = forces_at(*tables, x);
    const double largest = largest_norm(exact);
    for (const cpu::simd::Kernels* kernels : cpu::simd::usable_kernels()) {
      const InstructionSet chosen(kernels->name);
      const VecList found = forces_of(*make_solver("cpu", tables, scene, any_step()), x);
      EXPECT_LT(largest_distance(found, exact), 1e-5 * largest) << kernels->name;
    }
  }
}

/// A force whose square is beyond the range is not clamped, which would make nothing of it, but told.
TEST(CpuBackend, AForceBeyondTheRangeIsNotClamped) {
  const Model model = with_material(make_block({0.02, 0.02, 0.02}, 2, 2, 2), soft_tissue());
  const Scene scene(model);
  for (const cpu::simd::Kernels* kernels : cpu::simd::usable_kernels()) {
    const InstructionSet chosen(kernels->name);
    const auto solver = make_solver("cpu", model, scene);
    State state = rest_state(model);
    state.position[0].x() = -1e18;
    solver->reset(state);
    const StepReport report = solver->step(1, solver->stable_step());
    EXPECT_EQ(report.status, StepStatus::not_finite) << kernels->name << ": " << report.message();
  }
}

TEST(CpuBackend, NoForceAtRestOrAfterATranslation) {
  for_each_case([](const Case& body) {
    const Scene scene(body.model);
    VecList moved = body.tables->rest;
    for (Vec3& p : moved) p += Vec3(1.5, -0.25, body.model.dimension == 2 ? 0.0 : 8.0);
    for (const cpu::simd::Kernels* kernels : cpu::simd::usable_kernels()) {
      const InstructionSet chosen(kernels->name);
      const auto solver = make_solver("cpu", body.tables, scene, any_step());
      for (const Vec3& f : forces_of(*solver, body.tables->rest)) ASSERT_EQ(f, Vec3(0, 0, 0)) << body.name;
      for (const Vec3& f : forces_of(*solver, moved)) ASSERT_EQ(f, Vec3(0, 0, 0)) << body.name << ", moved";
    }
  });
}

Scene pulled(const Model& model) {
  const Load pull{.type = LoadType::translation,
                  .particles = model.group("x1"),
                  .events = {{0.0, 0.0}, {1.0, 0.1}},
                  .direction = {1, 0, 0}};
  return Scene(model)
      .fix("x0")
      .gravity({0, 0, -9.81})
      .add(pull)
      .add({.particles = model.group("y1"), .events = {{0.0, 0.01}}, .direction = {0, 1, 0}});
}

/// A lattice whose one half is five times stiffer.
Model stiffer_half() {
  Model model = with_material(make_block({0.12, 0.06, 0.06}, 12, 6, 6));
  model.add_group("left", model.particles_in([](const Vec3& X) { return X.x() < 0.065; }));
  set_material(model, {50e3, 0.3, 1000.0}, "left");
  return model;
}

/// Bodies of several clusters, with the terms of every kernel among them.
std::vector<Case> large_cases() {
  const auto make = [](std::string name, const Model& model, const TopologyOptions& options) {
    return Case{std::move(name), model, std::make_shared<const TopologyTextures>(build_topology(model, options))};
  };
  const int n = sanitized ? 11 : 14;
  const Vec3 size = Vec3::Constant(0.01 * n);
  const Model block = make_block(size, n, n, n, 14);
  const Model tetrahedra = make_tetrahedral_block(size, n, n, n, 0.2, 7);
  return {make("springs", tetrahedra, {.law = Law::springs, .volume_stiffness = 50.0}),
          make("shared", block, {.reaction = Reaction::shared, .bases = BaseSelection::all}),
          make("averaged", block, {.reaction = Reaction::averaged, .bases = BaseSelection::all}),
          make("conservative", tetrahedra, {}),
          make("tetrahedra", with_material(tetrahedra), {}),
          make("lattice", with_material(make_block(size, n + 6, n + 6, n + 6)), {}),
          make("two materials", stiffer_half(), {})};
}

TEST(CpuBackend, AnyNumberOfThreadsGivesTheSameBits) {
  for (const Case& body : large_cases()) {
    const Scene scene = pulled(body.model);
    for (const cpu::simd::Kernels* kernels : cpu::simd::usable_kernels()) {
      // Sanitizers look at one instruction set, because each takes them minutes.
      if (sanitized && kernels != cpu::simd::usable_kernels().front()) continue;
      const InstructionSet chosen(kernels->name);
      State first;
      for (const int threads : sanitized ? std::vector<int>{2, 1} : std::vector<int>{1, 2, 4, 7, 1}) {
        const auto solver = make_solver("cpu", body.tables, scene, any_step(threads));
        EXPECT_EQ(solver->device().substr(0, 2), std::to_string(threads) + " ") << body.name;
        State state = displaced(body.model, 0.05, 9);
        solver->reset(state);
        ASSERT_TRUE(is_ok(solver->step(5, 1e-5))) << body.name;
        solver->read(state);
        if (first.position.empty()) first = state;
        EXPECT_EQ(state, first) << body.name << ", " << kernels->name << ", " << threads << " threads";
      }
    }
  }
}

TEST(CpuBackend, ClustersHaveTheForcesOfTheWhole) {
  for (const Case& body : large_cases()) {
    const Scene scene(body.model);
    const VecList u = random_displacements(body.model, 0.1, 4), x = sum_of(body.tables->rest, u);
    const VecList exact = forces_at(*body.tables, x);
    const VecList found = forces_of(*make_solver("cpu", body.tables, scene, any_step(2)), x);
    const double scale = largest_norm(exact);
    ASSERT_LE(largest_distance(found, exact), 2e-6 * scale) << body.name;
  }
}

TEST(CpuBackend, StepsDoNotAllocate) {
  for (const Case& body : large_cases()) {
    const Scene scene = pulled(body.model);
    const auto solver = make_solver("cpu", body.tables, scene, any_step(2));
    solver->step(1, 1e-5);
    const std::size_t before = allocation_count();
    ASSERT_TRUE(solver->step(10, 1e-5).ok());
    EXPECT_EQ(allocation_count(), before) << body.name;
  }
}

TEST(CpuBackend, SmallBodiesRunOnOneThread) {
  const Model model = cylinder_275();
  const Scene scene(model);
  EXPECT_EQ(make_solver("cpu", model, scene)->device().substr(0, 9), "1 thread,");
}

/// The lightest step of 4,096 particles: some 35 us.
TEST(CpuBackend, SpringsOnAFewThousandParticlesRunOnTwoThreads) {
  const Model model = make_tetrahedral_block({0.075, 0.075, 0.075}, 15, 15, 15, 0.2, 7);
  const Scene scene(model);
  const auto solver = make_solver("cpu", model, scene, {.law = Law::springs});
  EXPECT_GE(std::stoul(solver->device()), std::min(2u, std::thread::hardware_concurrency())) << solver->device();
}

TEST(CpuBackend, RefusesWhatItCannotDo) {
  const Model model = make_tetrahedron(0.01);
  const Scene scene(model);
  {
    const InstructionSet unknown("mmx");
    EXPECT_TRUE(refuses([&] { make_solver("cpu", model, scene); }, "PHYMUL_CPU_ISA is \"mmx\""));
  }
  EXPECT_TRUE(refuses([&] { make_solver("cpu", model, scene, {}, any_step(-1)); }, "threads must be 0"));
  const auto solver = make_solver("cpu", model, scene);
  State far = rest_state(model);
  far.position[2].x() = 1e39;
  EXPECT_TRUE(refuses([&] { solver->reset(far); }, "beyond single precision"));
}

TEST(CpuBackend, BodiesTooSmallForSinglePrecisionAreForTheReference) {
  const Model model = make_tetrahedron(1e-9);
  const Scene scene(model);
  EXPECT_TRUE(refuses([&] { make_solver("cpu", model, scene); }, "a base of particle 0 spans"));
  const auto solver = make_solver("auto", model, scene);
  EXPECT_EQ(solver->name(), "reference");
  EXPECT_TRUE(says(solver->backend_reason(), "single precision holds"));
}

/// So many particles without neighbours that whole slices have none: nothing pulls them, and they fall.
TEST(CpuBackend, ParticlesWithoutNeighboursFall) {
  Model model = make_block({0.02, 0.02, 0.02}, 4, 4, 4);
  for (int k = 0; k < 40; ++k) {
    model.rest.emplace_back(0.1 + 0.01 * k, 0, 0);
    model.mass.push_back(model.mass.front());
    model.stiffness.push_back(model.stiffness.front());
    model.neighbours.offset.push_back(model.neighbours.offset.back());
  }
  Scene scene = Scene(model).gravity({0, 0, -1});
  const auto solver =
      make_solver("cpu", model, scene,
                  {.reaction = Reaction::shared, .bases = BaseSelection::all, .on_sparse = SparseParticle::free});
  const double dt = 1e-3;
  ASSERT_TRUE(is_ok(solver->step(100, dt)));
  const State state = solver->read();
  for (Index i = 0; i < model.particle_count(); ++i) {
    EXPECT_NEAR(state.position[i].z() - model.rest[i].z(), -0.5 * dt * dt * 100 * 101, 1e-7) << i;
  }
}

}  // namespace
}  // namespace phymul::test
