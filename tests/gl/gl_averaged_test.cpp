// SPDX-License-Identifier: MIT
//
// Law::particle_averaged on the GL backends: against the float mirror bit by bit where the renderer allows (llvmpipe),
// and against the double reference.
#include <algorithm>

#include "gl_single_steps.h"
#include "support/gl_block.h"
#include "support/gl_touching_bodies.h"
#include "support/message_of.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

class GlAveraged : public TwinsOnBothDevices {};

PHYMUL_ON_BOTH_DEVICES(GlAveraged);

std::shared_ptr<const TopologyTextures> averaged_tables(const Model& model) {
  return tables_of(model, {.law = Law::particle_averaged});
}

std::vector<Body> averaged_bodies() {
  std::vector<Body> all;
  const auto add = [&](std::string name, Model model) {
    set_material(model, soft_tissue());
    all.push_back({std::move(name), std::move(model)});
  };
  const Model tetrahedra = make_tetrahedral_block({0.03, 0.02, 0.02}, 4, 2, 3, 0.2, 5);
  const Model hexahedra = make_block({0.03, 0.02, 0.02}, 4, 3, 2);
  add("one tetrahedron", make_tetrahedron(0.01));
  add("tetrahedra", tetrahedra);
  add("hexahedra", hexahedra);
  add("jittered hexahedra", jittered_block());
  add("hexahedra and wedges", cylinder_275());
  add("strip", make_strip(0.04, 0.02, 6, 3));
  for (const auto& [name, model] : {std::pair("tetrahedra", &tetrahedra), std::pair("hexahedra", &hexahedra)}) {
    all.push_back(
        {name + std::string(" of two materials"), with_harder_half(*model, soft_tissue(0.45), {50e3, 0.2, 1500.0})});
  }
  return all;
}

TEST_P(GlAveraged, SingleStepsHaveTheMirrorsBits) {
  for (const Body& body : averaged_bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    expect_the_mirrors_bits(twins_of(averaged_tables(body.model), scene), body.model, sanitized ? 3 : 30, 0.015);
    if (IsSkipped()) return;
  }
}

/// The bound is wide (llvmpipe uses 0.011 of it), so forces are held to ten times the largest error measured there too:
/// 2.8e-7 of the body's largest force (llvmpipe 15, 2026-11-23).
TEST_P(GlAveraged, SingleStepsAreWithinTheRoundingBound) {
  SingleStepErrors worst;
  for (const Body& body : averaged_bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    const auto tables = averaged_tables(body.model);
    worst.measure(twins_of(tables, scene, uncut()), *tables, 5, 0.05);
  }
  worst.print();
  EXPECT_LE(worst.of_force, 3e-6);
}

/// Damped, under gravity; the limit is that of GlEquivalence for other laws.
TEST_P(GlAveraged, BodiesGoWhereTheReferenceGoes) {
  const int steps = sanitized ? 100 : 600;
  for (const Body& body : averaged_bodies()) {
    SCOPED_TRACE(body.name);
    Scene scene(body.model);
    scene.fix(body.name == "one tetrahedron" ? "base" : body.name == "hexahedra and wedges" ? "bottom" : "x0");
    scene.gravity({0, -9.81, 0});
    const auto tables = averaged_tables(body.model);
    const GlTrio trio = trio_of(tables, scene, {.damping = {.factor = 0.99}});
    const State start = random_state(body.model, 0.05, 0.0, 5);
    trio.reset(start);
    const double dt = 0.3 * trio.reference->stable_step();
    for (int done = 0; done < steps; done += 100) {
      trio.step(100, dt, "step " + std::to_string(done + 100));
      ASSERT_LE(trio.apart(), 1e-5 * body_size(body.model)) << "step " << done + 100;
    }
    std::printf("[ REFERENCE] %s: after %d steps apart by %.2g of the body's size\n", body.name.c_str(), steps,
                trio.apart() / body_size(body.model));
    const Energy a = trio.twins.gl->energy(), b = trio.reference->energy();
    EXPECT_NEAR(a.elastic, b.elastic, 1e-5 * b.elastic);
    EXPECT_GE(largest_distance(start.position, trio.reference->read().position), 1e-3 * body_size(body.model));
  }
}

/// Where the passes of a step are others: a ball is pressed into a slab under a cube whose volume is kept.
TEST_P(GlAveraged, ToolsContactsAndVolumesActOnIt) {
  Model model = stacked(1e-4);
  model.add_group("corner", model.cells[0].particles);
  set_material(model, {20e3, 0.4, 1200.0}, "corner");
  Scene scene = Scene(model).fix("low/z0").gravity({0, 0, -9.81}).contacts({}).constrain_volume("high");
  scene.add_tool("ball", {.shape = Sphere{0.004}, .pose = {.position = Vec3(0.005, 0.005, 0.0142)}, .friction = 0.3});
  SolverOptions damped{.damping = {.rate = 30.0}};
  const auto tables = averaged_tables(model);
  damped.spectrum = estimate_spectrum(*tables, tables->rest);
  gl::DeviceSolver solver(GetParam(), tables, scene, damped);
  const auto reference = make_solver("reference", tables, scene, damped);
  const double dt = 0.4 * reference->stable_step();
  double moved = 0.0, off = 0.0;
  for (int k = 0; k < 10; ++k) {
    scene.tool("ball").move_to({.position = Vec3(0.005, 0.005, 0.0142 - 2e-4 * k)});
    ASSERT_TRUE(all_step(20, dt, solver, reference));
    const State exact = reference->read();
    moved = std::max(moved, largest_distance(exact.position, model.rest));
    off = std::max(off, largest_distance(solver.read().position, exact.position));
  }
  EXPECT_GT(solver.tool_force("ball").force.norm(), 0.0);
  std::printf("[ REFERENCE] off by at most %.2g of the motion\n", off / moved);
  EXPECT_GT(moved, 5e-4);
  EXPECT_LE(off, 1e-5 * moved);
}

TEST_P(GlAveraged, RestIsAFixedPointToTheLastBit) {
  for (const Body& body : averaged_bodies()) {
    SCOPED_TRACE(body.name);
    const Scene scene(body.model);
    const GlTwins twins = twins_of(averaged_tables(body.model), scene);
    for (const Vec3& shift : {Vec3(0, 0, 0), Vec3(0.125, -0.25, 0)}) expect_rest_is_kept(twins, body.model, shift, 50);
  }
}

/// In 2-D no rounding leads out of the plane.
TEST_P(GlAveraged, AStripStaysInItsPlane) {
  const Model model = with_material(make_strip(0.04, 0.02, 6, 3), soft_tissue(0.45));
  const Scene scene(model);
  const GlTwins twins = twins_of(averaged_tables(model), scene);
  twins.gl->reset(random_state(model, 0.2, 0.0, 5));
  ASSERT_TRUE(twins.gl->step(100, 0.3 * twins.gl->stable_step()).ok());
  for (const Vec3& x : twins.gl->read().position) EXPECT_EQ(x.z(), 0.0);
}

TEST_P(GlAveraged, OnlyThisLawPaysForIt) {
  using Names = std::vector<std::string>;
  const Model block = make_block({0.03, 0.02, 0.02}, 4, 3, 2);
  const Names without = passes_of(block, GetParam());
  EXPECT_EQ(std::ranges::count(without, "domains_pass"), 0);
  const bool draws = GetParam() == GlBackend::fragment;
  EXPECT_EQ(passes_of(with_material(block), GetParam()),
            draws ? Names({"domains_pass", "step_pass"}) : Names({"terms_kernel", "step_kernel"}));
}

TEST_P(GlAveraged, ConstantsBeyondSinglePrecisionAreRefused) {
  const Model model = with_material(make_block({0.03, 0.02, 0.02}, 3, 2, 2), {1e40, 0.3, 1e36});
  const Scene scene(model);
  EXPECT_TRUE(refuses([&] { gl::DeviceSolver(GetParam(), averaged_tables(model), scene, {.spectrum = Spectrum{}}); },
                      "is beyond the range of single precision"));
}

}  // namespace
}  // namespace phymul::test
