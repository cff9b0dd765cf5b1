// SPDX-License-Identifier: MIT
//
// Contacts by fragments, beside what every GL backend must do (GlBodyContact, GlContactRuns): the bits of compute
// shaders, and the phases of the sweeps, whose number the host guesses.

#include "support/gl_touching_bodies.h"

namespace phymul::test {
namespace {

class GlFragmentContact : public GlTest {
 protected:
  std::string needs() const override { return "gl"; }
};

std::unique_ptr<gl::DeviceSolver> solver_of(const Model& model, const Scene& scene, SolverOptions options,
                                            GlBackend backend = GlBackend::fragment) {
  options.gl.debug = true;
  options.profile = true;
  return std::make_unique<gl::DeviceSolver>(backend, tables_of(model, {}), scene, options);
}

std::int64_t runs_of_pass(Solver& solver, const std::string& pass) {
  for (const PassProfile& row : solver.profile()) {
    if (row.name == pass) return row.runs;
  }
  return 0;
}

/// A cube that falls on a slab, about to touch it.
struct Falling {
  explicit Falling(double gap = 0.0004) : model(stacked(gap)), scene(model), state(rest_state(model)) {
    scene.gravity({3, 1, -9.81}).fix("low/z0").contacts({.friction = 0.3});
    for (const Index i : model.group("high")) state.velocity[i] = Vec3(0.05, 0.02, -0.3);
  }
  Model model;
  Scene scene;
  State state;
};

/// From states of motions in which bodies touch, both backends take the same steps. On another renderer sums may be
/// rounded another way.
void expect_bits_of_compute(const Model& model, Scene& scene, int steps_before, const char* what) {
  const auto drawn = solver_of(model, scene, damped(10.0));
  const auto computed = solver_of(model, scene, damped(10.0), GlBackend::compute);
  const double dt = 0.4 * drawn->stable_step();
  ASSERT_TRUE(computed->step(steps_before, dt).ok()) << what;
  const State start = computed->read();
  State end[2];
  for (const bool draws : {false, true}) {
    gl::DeviceSolver& solver = draws ? *drawn : *computed;
    solver.reset(start);
    for (const int steps : {1, 5, 10}) ASSERT_TRUE(solver.step(steps, dt).ok()) << what;
    end[draws] = solver.read();
  }
  EXPECT_GT(runs_of_pass(*drawn, "contact_phase_pass"), 16 * 8) << what;  // they touch
  if (!drawn->context()->info().renderer.starts_with("llvmpipe")) return;
  EXPECT_EQ(difference(end[1], end[0]), "") << what;
}

TEST_F(GlFragmentContact, BitsAreThoseOfComputeShaders) {
  PHYMUL_SKIP_OR_FAIL(why_not_here("gl-compute"));
  Falling falling;
  expect_bits_of_compute(falling.model, falling.scene, 40, "a cube on a slab");
  falling.scene.contacts({.friction = 0.0, .margin = 3e-4, .rounds = 3});
  expect_bits_of_compute(falling.model, falling.scene, 40, "without friction, another margin");
  falling.scene.constrain_volume("high");
  falling.scene.add_tool("ball", {.shape = Sphere{0.004}, .pose = {.position = {0.0122, 0.0131, 0.0241}}});
  falling.scene.add_tool("jaw", {.shape = Box{{0.001, 0.001, 0.001}}, .pose = {.position = {0.007, 0.008, 0.0205}}});
  falling.scene.tool("jaw").grasp(0.0005);
  expect_bits_of_compute(falling.model, falling.scene, 60, "with tools and a kept volume");
}

/// Particles without a surface meet triangles, and are none's corners.
TEST_F(GlFragmentContact, BitsAreThoseOfComputeShadersInABodyWithoutTriangles) {
  PHYMUL_SKIP_OR_FAIL(why_not_here("gl-compute"));
  const Model loose = without_cells(moved(make_block({0.01, 0.01, 0.01}, 2, 2, 2), {0.0072, 0.0081, 0.0112}));
  Model model = joined_bodies(make_block({0.025, 0.025, 0.01}, 5, 5, 2), loose);
  std::ranges::fill(model.mass, 1.25e-4);
  std::ranges::fill(model.stiffness, 25.0);
  Scene scene = Scene(model).gravity({3, 1, -9.81}).fix("low/z0").contacts({.friction = 0.3});
  expect_bits_of_compute(model, scene, 40, "loose particles");
}

/// A strip whose ends are pressed together above its middle.
TEST_F(GlFragmentContact, BitsAreThoseOfComputeShadersInABodyThatTouchesItself) {
  PHYMUL_SKIP_OR_FAIL(why_not_here("gl-compute"));
  const Model strip = long_strip();
  Scene scene = Scene(strip).contacts({.self = true});
  PressedStrip(strip, 0.016).press(scene);
  expect_bits_of_compute(strip, scene, 280, "a strip");
}

/// A batch whose steps take more phases than the first guess is done again; who knows how many there are
/// takes each step once. Both come to the same.
TEST_F(GlFragmentContact, AGuessThatFallsShortGivesTheSameBits) {
  const Falling falling;
  const auto knowing = solver_of(falling.model, falling.scene, damped(10.0));
  const double dt = 0.4 * knowing->stable_step();
  knowing->reset(falling.state);
  ASSERT_TRUE(knowing->step(24, dt).ok());
  const State start = knowing->read();
  ASSERT_TRUE(knowing->step(3, dt).ok());
  knowing->reset(start);
  knowing->clear_profile();
  ASSERT_TRUE(knowing->step(6, dt).ok());
  EXPECT_EQ(runs_of_pass(*knowing, "contact_start_pass"), 6);
  const State end = knowing->read();
  const auto fresh = solver_of(falling.model, falling.scene, damped(10.0));
  fresh->reset(start);
  ASSERT_TRUE(fresh->step(6, dt).ok());
  EXPECT_EQ(difference(fresh->read(), end), "");
  EXPECT_GT(runs_of_pass(*fresh, "contact_start_pass"), 6 + 1);  // and one when it was made
}

/// As many as contacts are pressed one after another, not many more; a few where nothing touches.
TEST_F(GlFragmentContact, PhasesFollowWhatStepsTake) {
  Falling falling;
  const auto solver = solver_of(falling.model, falling.scene, damped(10.0));
  const double dt = 0.4 * solver->stable_step();
  solver->reset(falling.state);
  ASSERT_TRUE(solver->step(24, dt).ok());
  const auto phases_a_step = [&](int steps) {
    solver->clear_profile();
    EXPECT_TRUE(solver->step(steps, dt).ok());
    return static_cast<double>(runs_of_pass(*solver, "contact_phase_pass")) /
           static_cast<double>(runs_of_pass(*solver, "contact_start_pass"));
  };
  const double touching = phases_a_step(4);
  EXPECT_GT(touching, 16.0);
  EXPECT_LT(touching, 160.0);
  State apart = falling.state;
  for (const Index i : falling.model.group("high")) {
    apart.position[i] += Vec3(0, 0, 1);
    apart.velocity[i] = Vec3::Zero();
  }
  solver->reset(apart);
  for (int k = 0; k < 40; ++k) ASSERT_TRUE(solver->step(1, dt).ok());
  EXPECT_EQ(phases_a_step(4), 2.0);
}

/// Contacts that went and came again are those of a scene that always had them.
TEST_F(GlFragmentContact, ContactsComeAndGo) {
  Falling falling;
  const auto solver = solver_of(falling.model, falling.scene, damped(10.0));
  const double dt = 0.4 * solver->stable_step();
  solver->reset(falling.state);
  ASSERT_TRUE(solver->step(30, dt).ok());
  const State always = solver->read();
  falling.scene.no_contacts();
  solver->reset(falling.state);
  ASSERT_TRUE(solver->step(30, dt).ok());
  EXPECT_NE(difference(solver->read(), always), "");
  falling.scene.contacts({.friction = 0.0});
  ASSERT_TRUE(solver->step(2, dt).ok());
  falling.scene.contacts({.friction = 0.3});
  solver->reset(falling.state);
  ASSERT_TRUE(solver->step(30, dt).ok());
  EXPECT_EQ(difference(solver->read(), always), "");
}

}  // namespace
}  // namespace phymul::test
