// SPDX-License-Identifier: MIT
//
// Kept volumes on the GL backends: against the float mirror bit by bit where the renderer allows (llvmpipe), against
// the double reference and their own volume within bounds, and in all that batches, reports and devices do.
#include <algorithm>
#include <cmath>

#include "model/closed_surface.h"
#include "support/gl_bodies.h"
#include "support/run_scenes.h"

namespace phymul::test {
namespace {

/// Positions are rounded: displacements of u_max shift a surface of area A by as much as u_max 2^-24, if all of them
/// were rounded outward. Bound of the share of V that is missing after a step: twice that, A u_max 2^-23 / V (the other
/// half for the sums). The largest over these tests was 0.1 of it.
double volume_bound(const Scene& scene, std::size_t row, const State& state) {
  const VolumeConstraint& kept = scene.volume_constraints()[row];
  double area = 0.0, largest = 0.0;
  for (const auto& [a, b, c] : kept.triangles) {
    area += 0.5 * (state.position[b] - state.position[a]).cross(state.position[c] - state.position[a]).norm();
    for (const Index i : {a, b, c}) {
      largest = std::max(largest, (state.position[i] - scene.model().rest[i]).norm());
    }
  }
  return 0x1p-23 * area * largest / kept.volume;
}

double volume_error(const Scene& scene, std::size_t row, const State& state) {
  const VolumeConstraint& kept = scene.volume_constraints()[row];
  return std::abs(enclosed_volume(kept.triangles, state.position) / kept.volume - 1.0);
}

class GlVolume : public GlBlockTest {
 protected:
  void expect_kept(const Scene& scene, const State& state) {
    for (std::size_t row = 0; row < scene.volume_constraints().size(); ++row) {
      const double bound = volume_bound(scene, row, state), error = volume_error(scene, row, state);
      EXPECT_LE(error, bound) << row;
      EXPECT_LE(error, 1e-6) << row;
      largest_ = std::max(largest_, error);
      if (bound > 0.0) worst_ = std::max(worst_, error / bound);
    }
  }
  void TearDown() override {
    if (worst_ > 0.0) std::printf("[ VOLUMES  ] off by at most %.2g, %.2g of the bound\n", largest_, worst_);
    GlBlockTest::TearDown();
  }

  double largest_ = 0.0, worst_ = 0.0;  // error, over its bound
};

PHYMUL_ON_BOTH_DEVICES(GlVolume);

/// Squeezed to four fifths, under gravity, 300 steps.
TEST_P(GlVolume, IsKeptUnderLoadWithTheMirrorsBits) {
  Scene lossy = Scene(model_).fix("x0").gravity({0, 0, -9.81}), measure = Scene(model_).constrain_volume();
  lossy.add(pull(model_, "x1", {-1, 0, 0}, {{0, 0}, {200 * dt_, 0.006}}));
  Scene scene = lossy.copy().constrain_volume();
  const GlTwins twins = this->twins(scene);
  const auto reference = make_solver("reference", tables_, scene, options_);
  const auto alone = make_solver("reference", tables_, lossy, options_);
  double lost = 0.0;
  for (int k = 0; k < 12; ++k) {
    const StepReport a = twins.gl->step(25, dt_), b = twins.mirror->step(25, dt_);
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_NEAR(a.residual, b.residual, 1e-4 * b.residual);  // of a GPU that divides to 2.5 units
    EXPECT_NEAR(a.max_speed, b.max_speed, 1e-4 * b.max_speed);
    ASSERT_TRUE(all_step(25, dt_, reference, alone));
    twins.expect_same_bits("call " + std::to_string(k));
    const State state = twins.gl->read();
    expect_kept(scene, state);
    lost = std::max(lost, volume_error(measure, 0, alone->read()));
    EXPECT_LE(largest_distance(state.position, reference->read().position), 1e-5 * 0.006);
  }
  EXPECT_GT(lost, 5e-4);
}

/// Two bodies, one of whose volume is to be 2 % more than at rest, 1.4 km from the origin, with a ball pressed into
/// one and a jaw that holds some of the other, and feels what the volume does to that.
TEST_P(GlVolume, SeveralBodiesAndToolsFarFromTheOrigin) {
  const Vec3 origin(800, -600, 1000);
  const Model block = make_block({0.02, 0.02, 0.02}, 4, 4, 4), flat = make_block({0.03, 0.02, 0.01}, 6, 4, 2);
  const Model one = with_material(moved(block, origin)), two = with_material(moved(flat, origin + Vec3(0.05, 0, 0)));
  const Model both = merged({{"one", &one}, {"two", &two}});
  Scene scene = Scene(both).fix("one/z0").fix("two/z0").constrain_volume("one").constrain_volume("two");
  VolumeConstraint more = scene.volume_constraints()[1];
  more.volume *= 1.02;
  scene.clear().fix("one/z0").fix("two/z0").constrain_volume("one").constrain_volume(more);
  scene.add_tool("ball",
                 {.shape = Sphere{0.005}, .pose = {.position = origin + Vec3(0.01, 0.01, 0.0252)}, .friction = 0.3});
  scene.add_tool("jaw", {.shape = Box{{0.03, 0.002, 0.0015}}, .pose = {.position = origin + Vec3(0.065, 0.01, 0.011)}});
  options_.spectrum.reset();
  const auto tables = tables_of(both, {});
  const GlTwins twins(tables, scene, options_, GetParam());
  const auto reference = make_solver("reference", tables, scene, twins.options());
  const double dt = 0.4 * reference->stable_step();
  double moved = 0.0, off = 0.0;
  for (int k = 0; k < 10; ++k) {
    scene.tool("ball").move_to({.position = origin + Vec3(0.01, 0.01, 0.025 - 2e-4 * k)});
    if (k == 4) scene.tool("jaw").grasp(1e-4);
    if (k == 6) scene.tool("jaw").move_to({.position = origin + Vec3(0.065, 0.009, 0.0115), .velocity = {0, 0.01, 0}});
    for (Solver* const solver : std::initializer_list<Solver*>{twins.gl.get(), twins.mirror.get(), reference.get()}) {
      ASSERT_TRUE(solver->step(20, dt).ok());
    }
    if (k < 4) twins.expect_same_bits("call " + std::to_string(k));
    const State a = twins.gl->read(), b = reference->read();
    expect_kept(scene, a);
    const Vec3 felt = twins.gl->tool_force("jaw").mean_force, exact = reference->tool_force("jaw").mean_force;
    EXPECT_LE((felt - exact).norm(), 1e-3 * exact.norm() + 1e-4) << k;
    moved = std::max(moved, largest_distance(b.position, both.rest));
    off = std::max(off, largest_distance(a.position, b.position));
    EXPECT_EQ(a.tools.at(1).held.empty(), k < 4);
  }
  EXPECT_GT(twins.gl->tool_force("ball").force.norm(), 0.0);
  std::printf("[ VOLUMES  ] off the reference by at most %.2g of the motion\n", off / moved);
  EXPECT_GT(moved, 1e-3);
  EXPECT_LE(off, 1e-5 * moved);
}

/// Free in space, thrown, turning and out of shape. Momentum moves as far as floats let it: the bound is eight times
/// the largest of what llvmpipe gave.
TEST_P(GlVolume, KeepsLinearAndAngularMomentumOfAFreeBody) {
  Scene scene = Scene(model_).constrain_volume();
  options_.damping.rate = 0.0;
  const GlTwins twins = this->twins(scene);
  State state = rest_state(model_);
  std::mt19937 bits(9);
  double scale = 0.0;
  for (std::size_t i = 0; i < model_.rest.size(); ++i) {
    state.velocity[i] = Vec3(0.3, -0.1, 0.2) + Vec3(0, 0, 20).cross(model_.rest[i]) + 0.1 * random_vector(bits, 3);
    scale += model_.mass[i] * state.velocity[i].norm();
  }
  twins.reset(state);
  const Momentum start = twins.gl->momentum();
  ASSERT_TRUE(all_step(150, 0.5 * dt_, twins.gl, twins.mirror));
  twins.expect_same_bits("a free body");
  const Momentum end = twins.gl->momentum();
  const double arm = body_size(model_), linear = (end.linear - start.linear).norm() / scale,
               angular = (end.angular - start.angular).norm() / (scale * arm);
  std::printf("[ VOLUMES  ] momentum moved by %.2g, angular by %.2g\n", linear, angular);
  EXPECT_LE(linear, 1e-6);
  EXPECT_LE(angular, 1e-6);
  expect_kept(scene, twins.gl->read());
}

/// A batch that ends before its last step is done again up to there: at rest, and where a particle runs away.
TEST_P(GlVolume, BatchesDoneAgainKeepTheVolume) {
  Scene scene = Scene(model_).fix("z0").gravity({0, 0, -9.81}).constrain_volume();
  options_.rest_tolerance = 1e-4;
  options_.damping.rate = 200.0;
  const GlTwins resting = twins(scene);
  const RestResult a = resting.gl->run_to_rest(20000, dt_), b = resting.mirror->run_to_rest(20000, dt_);
  ASSERT_TRUE(a.converged() && b.converged());
  EXPECT_NEAR(a.report.steps, b.report.steps, 0.05 * b.report.steps);
  expect_kept(scene, resting.gl->read());
  if (a.report.steps == b.report.steps) resting.expect_same_bits("at rest");

  options_.damping.rate = 0.0;
  const GlTwins failing = twins(scene);
  const StepReport failed = failing.gl->step(250, 8.0 * dt_), too = failing.mirror->step(250, 8.0 * dt_);
  ASSERT_FALSE(failed.ok());
  ASSERT_GT(failed.steps, 3);
  if (!failing.same_bits_expected()) return;
  EXPECT_EQ(failed.status, too.status);
  ASSERT_EQ(failed.steps, too.steps);
  failing.expect_same_bits("after the failure");
}

/// All is held, and an end is moved in from the 40th step on: nothing is left to make up for it.
TEST_P(GlVolume, OneThatCannotBeRestoredIsReportedAndTheStepNotTaken) {
  Scene scene = Scene(model_).fix(every_particle(model_)).constrain_volume();
  scene.add(pull(model_, "x1", {1, 0, 0}, {{0, 0}, {40 * dt_, 0}, {60 * dt_, -0.001}}));
  const GlTwins twins = this->twins(scene);
  const StepReport a = twins.gl->step(60, dt_), b = twins.mirror->step(60, dt_);
  EXPECT_EQ(a.status, StepStatus::volume_lost) << a.message();
  EXPECT_EQ(b.status, StepStatus::volume_lost) << b.message();
  EXPECT_EQ(a.steps, b.steps);
  EXPECT_GE(a.steps, 39);
  EXPECT_EQ(a.particle, scene.volume_constraints()[0].triangles[0][0]);
  EXPECT_TRUE(says(a.message(), "all of them are held"));
  twins.expect_same_bits("before the loss");
  const State kept = twins.gl->read();
  EXPECT_EQ(twins.gl->step(1, dt_).status, StepStatus::volume_lost);
  EXPECT_EQ(twins.gl->read(), kept);
  // Nothing is kept any more, so nothing is lost.
  scene.clear().gravity({0, 0, -1});
  EXPECT_TRUE(twins.gl->step(5, dt_).ok());
}

/// Held whole by two tools, and carried forty of its sizes away: rounding is no loss, a hundredth of the volume is.
TEST_P(GlVolume, OfWhatIsHeldWholeIsLostOnlyWhereItChanges) {
  const double size = 0.01;  // m
  const Model cube = make_block(Vec3::Constant(size), 1, 2, 2);
  const Vec3 ends[] = {{0, 0.5 * size, 0.5 * size}, {size, 0.5 * size, 0.5 * size}};
  const Vec3 far = 40.0 * size * Vec3(0.6, -0.48, 0.64);
  Scene scene = Scene(cube).constrain_volume();
  for (const Vec3& end : ends) {
    const std::string name = end.x() > 0.0 ? "high" : "low";
    scene.add_tool(name, {.shape = Box{{0.1 * size, 0.6 * size, 0.6 * size}}, .pose = {.position = end}});
    scene.tool(name).grasp(0.0);
  }
  options_.spectrum.reset();
  const GlTwins twins(tables_of(cube, {}), scene, options_, GetParam());
  ASSERT_TRUE(twins.gl->step(1, 1e-4).ok() && twins.mirror->step(1, 1e-4).ok());
  scene.tool("low").move_to({.position = ends[0] + far});
  for (const double lost : {0.0, 1e-2}) {
    scene.tool("high").move_to({.position = ends[1] + far - lost * size * Vec3::UnitX()});
    const StepReport a = twins.gl->step(1, 1e-4), b = twins.mirror->step(1, 1e-4);
    EXPECT_EQ(a.status, lost == 0.0 ? StepStatus::ok : StepStatus::volume_lost) << a.message();
    EXPECT_EQ(a.status, b.status);
    EXPECT_LT((twins.gl->read().position.front() - far).norm(), 1e-6 * far.norm());
  }
}

/// Volumes come, change and go while a solver runs.
TEST_P(GlVolume, AChangedSceneIsFollowed) {
  Scene scene = Scene(model_).fix("x0").gravity({0, 0, -9.81});
  const GlTwins twins = this->twins(scene);
  for (int k = 0; k < 4; ++k) {
    if (k == 1) {
      scene.constrain_volume();
      EXPECT_GT(volume_error(scene, 0, twins.gl->read()), 1e-6);
    }
    if (k == 2) {
      VolumeConstraint more = scene.volume_constraints()[0];
      more.volume *= 1.01;
      scene.clear().fix("x0").gravity({0, 0, 5}).constrain_volume(more);
    }
    if (k == 3) scene.clear().fix("x0").gravity({0, 0, 5});
    ASSERT_TRUE(all_step(15, dt_, twins.gl, twins.mirror));
    twins.expect_same_bits("call " + std::to_string(k));
    expect_kept(scene, twins.gl->read());
  }
}

TEST_P(GlVolume, CopiesAndLostDevicesGoOn) {
  Scene scene = Scene(model_).fix("x0").gravity({0, 0, -9.81}).constrain_volume();
  const auto solver = make(scene), untouched = make(scene);
  copy_and_lose(*solver, *untouched);
  expect_kept(scene, solver->read());
}

TEST_P(GlVolume, ASceneWithoutKeptVolumesPaysNothing) {
  Scene without = Scene(model_).fix("z0").gravity({0, 0, -1}), with = without.copy().constrain_volume();
  options_.profile = true;
  const auto plain = make(without), keeping = make(with);
  ASSERT_TRUE(all_step(8, dt_, plain, keeping));
  const auto runs = runs_of(*plain), more = runs_of(*keeping);
  for (const auto& [name, count] : runs) EXPECT_EQ(name.find("kept"), std::string::npos) << name;
  EXPECT_NE(runs, more);
  EXPECT_TRUE(std::ranges::any_of(more, [](const auto& pass) { return pass.first.starts_with("kept"); }));
  EXPECT_NE(keeping->read(), plain->read());
  // The one that keeps no more does what the other does, and gives its bits.
  with.clear().fix("z0").gravity({0, 0, -1});
  expect_alike(*keeping, *plain, dt_);
}

/// Of 9,600 and 16,896 facets: 600 sums, of which each lane of the one group takes several, and 1,056, which are left
/// to many groups.
TEST_P(GlVolume, ManyFacetsAreSummed) {
  for (const int side : {48, 64}) {
    const Model slab = make_block({0.01 * side, 0.01 * side, 0.01}, side, side, 1);
    Scene scene = Scene(slab).fix("x0").constrain_volume();
    ASSERT_EQ(scene.volume_constraints()[0].triangles.size(), static_cast<std::size_t>(4 * side * (side + 2)));
    const GlTwins twins(tables_of(slab, {}), scene, options_, GetParam());  // any spectrum: none comes to rest
    twins.reset(random_state(slab, 0.01, 0.05, 3));  // nothing so small that a renderer takes it for 0
    ASSERT_TRUE(all_step(4, 1e-3, twins.gl, twins.mirror));
    EXPECT_GT(largest_distance(twins.gl->read().position, slab.rest), 5e-5);
    twins.expect_same_bits(std::to_string(side) + " a side");
    expect_kept(scene, twins.gl->read());
  }
}

}  // namespace
}  // namespace phymul::test
