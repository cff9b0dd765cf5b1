// SPDX-License-Identifier: MIT
//
// Materials that dissipate on the GL backends: against the float mirror bit by bit where the renderer allows
// (llvmpipe), within the rounding bound, and what other bodies pay for it. Closed forms, energy and snapshots:
// tests/solver/dissipation_test.cpp and dissipation_runs_test.cpp, on every backend.
#include "elastic/dissipation.h"
#include "support/bounded_forces.h"
#include "support/gl_bodies.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

class GlDissipation : public TwinsOnBothDevices {};

PHYMUL_ON_BOTH_DEVICES(GlDissipation);

/// `kinds`: 1 has a rate, 2 a branch.
Material dissipating(int kinds, Material material = soft_tissue()) {
  if ((kinds & 1) != 0) material.retardation_time = 2e-3;
  if ((kinds & 2) != 0) {
    material.relaxation_strength = 1.5;
    material.relaxation_time = 0.01;
  }
  return material;
}

std::vector<Body> of_two_materials(const Material& soft, const Material& harder) {
  return {{"tetrahedra", with_harder_half(make_tetrahedral_block({0.03, 0.02, 0.02}, 4, 2, 3, 0.2, 5), soft, harder)},
          {"hexahedra", with_harder_half(make_block({0.03, 0.02, 0.02}, 4, 3, 2), soft, harder)},
          {"strip", with_harder_half(make_strip(0.04, 0.02, 6, 3), soft, harder)}};
}

/// The half where x is least is harder, and dissipates less.
std::vector<Body> dissipating_bodies(int kinds) {
  Material harder = dissipating(kinds, {50e3, 0.2, 1500.0});
  harder.relaxation_time *= 0.3;
  return of_two_materials(dissipating(kinds), harder);
}

/// Steps of other lengths, in calls of one step and of several batches; stiffness that is scaled on the way.
TEST_P(GlDissipation, IsTheMirrorsBitByBitAndTheReferences) {
  for (const int kinds : {1, 2, 3}) {
    for (const Body& body : dissipating_bodies(kinds)) {
      SCOPED_TRACE(body.name + ", kinds " + std::to_string(kinds));
      Scene scene = Scene(body.model).fix("x0").gravity({0, -9.81, 0});
      const auto tables = tables_of(body.model, {});
      const GlTrio trio = trio_of(tables, scene);
      trio.reset(random_state(body.model, 0.05, 0.0, 5));
      const double dt = 0.2 * trio.reference->stable_step();
      int call = 0;
      for (const auto& [steps, share] :
           {std::pair(1, 1.0), std::pair(1, 0.6), std::pair(sanitized ? 9 : 60, 1.0), std::pair(30, 0.7)}) {
        if (++call == 4) scene.scale_stiffness(1.8);
        trio.step(steps, share * dt, "call " + std::to_string(call));
        EXPECT_LE(trio.apart(), 1e-5 * body_size(body.model)) << "call " << call;
        const Energy a = trio.twins.gl->energy(), b = trio.reference->energy();
        EXPECT_NEAR(a.elastic, b.elastic, 1e-5 * b.elastic);
        EXPECT_NEAR(a.kinetic, b.kinetic, 1e-4 * (b.elastic + b.kinetic));
      }
    }
  }
}

/// From standstill with strains of its own, in a step whose length rounds nothing: as CpuDissipation.
TEST_P(GlDissipation, ForcesAreWithinTheRoundingBound) {
  constexpr double dt = 0x1p-20, last_dt = 0x1p-12;
  double worst = 0.0;
  for (const int kinds : {1, 2, 3}) {
    for (const Body& body : dissipating_bodies(kinds)) {
      SCOPED_TRACE(body.name + ", kinds " + std::to_string(kinds));
      const Scene scene(body.model);
      const auto tables = tables_of(body.model, {});
      std::mt19937 bits(17);
      StrainMemory strains(tables->domains.size() * kept_strains(*tables).count());
      for (Strain& strain : strains) {
        for (double& e : strain) e = static_cast<float>(0.1 * uniform(bits));
      }
      const GlTwins twins = twins_of(tables, scene, uncut());
      Snapshot start;
      start.state = random_state(body.model, 0.1, 0.0, 5);
      VecList u = start.state.position;
      for (std::size_t i = 0; i < u.size(); ++i) u[i] = (u[i] - body.model.rest[i]).cast<float>().cast<double>();
      start.displacement = u;
      start.last_dt = last_dt;
      put_strains(strains, start);
      twins.gl->restore(start);
      Snapshot again = twins.gl->snapshot();
      EXPECT_EQ(again.parts, start.parts);
      ASSERT_TRUE(twins.gl->step(1, dt).ok());
      const VecList found = twins.gl->read().velocity;
      const BoundedForces bounded(*tables, u, BoundedForces::DissipatingStep{strains, dt, last_dt});
      worst = std::max(worst, share_of_bound(*tables, bounded, found, dt));
    }
  }
  std::printf("[   BOUND  ] worst error %.3f of the bound\n", worst);
  EXPECT_GT(worst, 0.001);
}

/// A step that is taken back, of a batch, leaves the strains of the last good one.
TEST_P(GlDissipation, BatchesThatEndEarlyKeepTheStrainsOfTheirLastStep) {
  const Model model = dissipating_bodies(3)[0].model;
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  const auto tables = tables_of(model, {});
  const GlTwins twins = twins_of(tables, scene, damped(200.0));
  const double dt = 0.5 * twins.gl->stable_step();
  const auto settle = [&](Solver& solver) {
    solver.reset(rest_state(model));
    return solver.run_to_rest(20000, dt);
  };
  const RestResult rest = settle(*twins.gl);
  ASSERT_TRUE(rest.converged()) << rest.message();
  ASSERT_GT(rest.report.steps, 100);
  // As many steps one by one: no batch of them is taken back.
  gl::DeviceSolver other(GetParam(), tables, scene, twins.options());
  for (int k = 0; k < rest.report.steps; ++k) ASSERT_TRUE(other.step(1, dt).ok());
  const Snapshot a = twins.gl->snapshot(), b = other.snapshot();
  EXPECT_EQ(difference(a.state, b.state), "");
  EXPECT_EQ(a.parts, b.parts);
}

/// The strains of a snapshot mean the same to every backend.
TEST_P(GlDissipation, SnapshotsGoOnInTheReference) {
  const Model model = dissipating_bodies(3)[1].model;
  const Scene scene(model);
  const auto tables = tables_of(model, {});
  const GlTwins twins = twins_of(tables, scene);
  twins.gl->reset(random_state(model, 0.05, 0.0, 7));
  const double dt = 0.3 * twins.gl->stable_step();
  ASSERT_TRUE(twins.gl->step(40, dt).ok());
  const auto reference = make_solver("reference", tables, scene, twins.options());
  reference->restore(twins.gl->snapshot());
  ASSERT_TRUE(all_step(40, dt, twins.gl, reference));
  const double apart = largest_distance(twins.gl->read().position, reference->read().position);
  EXPECT_LE(apart, 1e-6 * body_size(model));
  Snapshot forgetful = twins.gl->snapshot();
  forgetful.parts.clear();
  reference->restore(forgetful);
  ASSERT_TRUE(all_step(40, dt, twins.gl, reference));
  EXPECT_GT(largest_distance(twins.gl->read().position, reference->read().position), 1e-5 * body_size(model));
}

TEST_P(GlDissipation, OnlySuchBodiesPayForIt) {
  for (const int kinds : {0, 1, 2, 3}) {
    const std::vector<std::string> passes = passes_of(dissipating_bodies(kinds)[1].model, GetParam());
    using Names = std::vector<std::string>;
    if (GetParam() == GlBackend::compute) {
      EXPECT_EQ(passes, Names({"terms_kernel", "step_kernel"}));
    } else {
      EXPECT_EQ(passes, kinds == 0 ? Names({"domains_pass", "step_pass"})
                                   : Names({"domains_pass", "strains_pass", "step_pass"}));
    }
  }
}

// Scene::scale_stiffness on the GL backends: against the float mirror bit by bit where the renderer allows (llvmpipe),
// against the double reference, and what a scene without factors pays for it.

class GlStiffness : public TwinsOnBothDevices {};

PHYMUL_ON_BOTH_DEVICES(GlStiffness);

const Material hard{50e3, 0.2, 1500.0};

std::vector<Body> bodies_of_two_materials() {
  return of_two_materials(soft_tissue(0.45), hard);
}

/// Factors that come, change, and go.
void change(Scene& scene, int call) {
  switch (call) {
    case 1:
      scene.scale_stiffness(0.3);
      break;
    case 2:
      scene.scale_stiffness(hard, 1.7);
      break;
    case 4:
      scene.scale_stiffness(1.0);
      break;
    case 5:
      scene.scale_stiffness(hard, 2.3);
      break;
    default:
      break;
  }
}

TEST_P(GlStiffness, IsTheMirrorsBitByBitAndTheReferences) {
  const int steps = sanitized ? 10 : 60;
  for (const Body& body : bodies_of_two_materials()) {
    SCOPED_TRACE(body.name);
    Scene scene = Scene(body.model).fix("x0").gravity({0, -9.81, 0});
    const auto tables = tables_of(body.model, {});
    const GlTrio trio = trio_of(tables, scene, {.damping = {.factor = 0.99}});
    trio.reset(random_state(body.model, 0.05, 0.0, 5));
    const double dt = 0.15 * trio.reference->stable_step();
    for (int call = 0; call < 7; ++call) {
      change(scene, call);
      trio.step(steps, dt, "call " + std::to_string(call));
      EXPECT_LE(trio.apart(), 1e-5 * body_size(body.model)) << "call " << call;
      const Energy a = trio.twins.gl->energy(), b = trio.reference->energy();
      EXPECT_NEAR(a.elastic, b.elastic, 1e-5 * b.elastic);
    }
  }
}

/// The same passes with factors and without; a scene whose factors were removed continues as one that never had any.
TEST_P(GlStiffness, AddsNoPassAndLeavesNothing) {
  const Model model = bodies_of_two_materials()[0].model;
  const auto tables = tables_of(model, {});
  Scene plain(model), scaled(model);
  const SolverOptions profiled{.spectrum = estimate_spectrum(*tables, tables->rest), .profile = true};
  gl::DeviceSolver one(GetParam(), tables, plain, profiled), other(GetParam(), tables, scaled, profiled);
  const double dt = 0.3 * one.stable_step();
  const State start = random_state(model, 0.05, 0.0, 5);
  const auto run = [&](gl::DeviceSolver& solver) {
    solver.reset(start);
    solver.clear_profile();
    EXPECT_TRUE(solver.step(40, dt).ok());
    return solver.read();
  };
  const State moved = run(one);
  scaled.scale_stiffness(0.5);
  EXPECT_NE(difference(run(other), moved), "");
  EXPECT_EQ(runs_of(other), runs_of(one));
  scaled.scale_stiffness(1.0);
  EXPECT_EQ(difference(run(other), moved), "");
  EXPECT_EQ(runs_of(other), runs_of(one));
}

/// Many more domains than a line of a texture has texels, of three materials.
TEST_P(GlStiffness, FactorsReachTheirDomains) {
  Model model = with_material(make_block({0.08, 0.05, 0.05}, 16, 10, 10));
  set_material(model, {20e3, 0.3, 1000.0}, [](const Vec3& x) { return x.x() < 0.03; });
  set_material(model, hard, [](const Vec3& x) { return x.z() < 0.02; });
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -9.81});
  scene.scale_stiffness({0.2, 3.0, 0.6});
  const GlTrio trio = trio_of(tables_of(model, {}), scene);
  trio.reset(random_state(model, 0.05, 0.0, 9));
  trio.step(10, 0.3 * trio.reference->stable_step());
  EXPECT_LE(trio.apart(), 1e-6 * body_size(model));
}

}  // namespace
}  // namespace phymul::test
