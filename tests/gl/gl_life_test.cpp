// SPDX-License-Identifier: MIT
//
// A solver of the backend "gl" from the outside: copies and textures it hands out, its options, many of them in a row,
// and what becomes of it when its device goes away.
#include <unistd.h>

#include "support/gl_twins.h"
#include "support/heap_in_use.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

class GlLife : public GlTest {
 protected:
  GlLife() : model_(make_block({0.03, 0.02, 0.02}, 3, 2, 2)) {
    set_material(model_, soft_tissue());
    scene_.emplace(model_);
    scene_->gravity({0, 0, -9.81});
  }
  std::unique_ptr<gl::DeviceSolver> make(const SolverOptions& options = {}) const {
    return std::make_unique<gl::DeviceSolver>(GlBackend::fragment, tables_of(model_, {}), *scene_, options);
  }
  /// Waits as long as a device may take: collect() itself never does.
  static bool collected(Solver& solver, State& state) {
    for (int tries = 0; tries < 2000; ++tries) {
      if (solver.collect(state)) return true;
      usleep(1000);
    }
    return false;
  }
  Model model_;
  std::optional<Scene> scene_;
};

TEST_F(GlLife, CopiesComeInOrderAndTheFourthTakesTheThirdsPlace) {
  const auto solver = make();
  const double dt = 0.3 * solver->stable_step();
  State copy;
  EXPECT_FALSE(solver->collect(copy));
  std::vector<State> expected;
  for (int k = 0; k < 4; ++k) {
    ASSERT_TRUE(solver->step(2, dt).ok());
    solver->request_read();
    expected.push_back(solver->read());
  }
  ASSERT_TRUE(solver->step(2, dt).ok());
  for (const int k : {0, 1, 3}) {
    ASSERT_TRUE(collected(*solver, copy)) << k;
    EXPECT_EQ(copy, expected[k]) << k;
  }
  EXPECT_FALSE(solver->collect(copy));
  solver->request_read();
  solver->reset();
  EXPECT_FALSE(solver->collect(copy)) << "reset() drops copies on their way";
  solver->request_read();
  ASSERT_TRUE(collected(*solver, copy));
  EXPECT_EQ(copy, rest_state(model_));
}

TEST_F(GlLife, TexturesHoldDisplacements) {
  const auto solver = make();
  const State start = random_state(model_, 0.1, 0.0, 8);
  solver->reset(start);
  const std::vector<Float4> u = texels_of(*solver->context(), solver->position_buffer());
  for (std::size_t i = 0; i < model_.rest.size(); ++i) {
    const Vec3 place = model_.rest[i] + Vec3(u[i][0], u[i][1], u[i][2]);
    EXPECT_LE((place - start.position[i]).norm(), 1e-7 * body_size(model_)) << i;
  }
}

TEST_F(GlLife, ShadersMayComeFromAFolder) {
  const Environment folder("PHYMUL_GLSL", "/nonexistent");
  EXPECT_TRUE(refuses([&] { make(); }, "/nonexistent/"));
}

TEST_F(GlLife, StatesBeyondSinglePrecisionAreRefused) {
  const auto solver = make();
  State far = rest_state(model_);
  far.velocity[7].y() = 1e200;
  EXPECT_TRUE(refuses([&] { solver->reset(far); }, "particle 7 has a displacement or velocity beyond single"));
  EXPECT_EQ(solver->read(), rest_state(model_));
}

TEST_F(GlLife, AHundredSolversComeAndGo) {
  const SolverOptions options{.spectrum = estimate_spectrum(*tables_of(model_, {}), model_.rest),
                              .gl = {.debug = true}};
  double before = 0.0;
  for (int k = 0; k < 100; ++k) {
    std::shared_ptr<gl::Context> context;
    {
      const auto solver = make(options);
      context = solver->context();
      ASSERT_TRUE(solver->step(3, 0.3 * solver->stable_step()).ok());
      solver->position_buffer();
      solver->request_read();
      solver->read();
    }
    ASSERT_EQ(message_of([&] { context->throw_debug_errors(); }), "(no error)") << k;
    if (k == 30) before = heap_in_use();
  }
  const double grown = heap_in_use() - before;
  std::printf("[  MEMORY  ] grew by %.0f KiB over the last 70 solvers\n", grown / 1024.0);
  EXPECT_LT(grown, 8e6);
}

TEST_F(GlLife, ALostDeviceIsReportedAndTheSolverGoesOnFromTheNewestState) {
  const auto solver = make(), untouched = make();
  const double dt = 0.3 * solver->stable_step();
  ASSERT_TRUE(solver->step(20, dt).ok());
  const State kept = solver->read();
  ASSERT_TRUE(solver->step(20, dt).ok());
  solver->context()->mark_lost();
  const StepReport lost = solver->step(5, dt);
  EXPECT_EQ(lost.status, StepStatus::device_lost);
  EXPECT_EQ(lost.steps, 0);
  EXPECT_EQ(lost.time, kept.time);
  EXPECT_EQ(solver->read(), kept);
  ASSERT_TRUE(solver->step(20, dt).ok());
  ASSERT_TRUE(untouched->step(40, dt).ok());
  EXPECT_EQ(solver->read(), untouched->read()) << "twenty steps, the loss, and twenty from there";
}

TEST_F(GlLife, ADeviceThatDoesNotComeBackStaysLostUntilAResetFindsOne) {
  const auto solver = make();
  const double dt = 0.3 * solver->stable_step();
  ASSERT_TRUE(solver->step(5, dt).ok());
  const State kept = solver->read();
  {
    const Environment none("PHYMUL_EGL", "device:999");
    solver->context()->mark_lost();
    EXPECT_EQ(solver->step(5, dt).status, StepStatus::device_lost);
    EXPECT_EQ(solver->step(5, dt).status, StepStatus::device_lost);
    EXPECT_EQ(solver->read(), kept);
    EXPECT_EQ(solver->position_buffer().texture, 0u);
    EXPECT_NE(message_of([&] { solver->reset(); }), "(no error)");
  }
  solver->reset(kept);
  EXPECT_TRUE(solver->step(5, dt).ok());
}

}  // namespace
}  // namespace phymul::test
