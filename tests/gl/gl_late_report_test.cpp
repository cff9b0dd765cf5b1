// SPDX-License-Identifier: MIT
//
// GlOptions::late_report: the same states, reports a call later, failures not lost. Beside a solver that reports at
// once, which has the code of steps in common with it, and beside the float mirror, which has none.
#include "support/gl_twins.h"

namespace phymul::test {
namespace {

class GlLateReport : public OnBothDevices {
 protected:
  GlLateReport() : model_(make_block({0.03, 0.02, 0.02}, 3, 2, 2)) {
    set_material(model_, soft_tissue());
    scene_.emplace(model_);
    scene_->fix("x0").gravity({0, 0, -9.81});
    tables_ = tables_of(model_, {});
    options_.damping.factor = 0.99;
    options_.on_unstable = UnstableStep::allow;
    options_.rest_tolerance = 1e-4;
    options_.spectrum = estimate_spectrum(*tables_, tables_->rest);
    options_.gl.debug = true;
  }
  void SetUp() override {
    OnBothDevices::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    at_once_ = make(false);
    late_ = make(true);
    mirror_ = cpu::make_mirror_solver(tables_, *scene_, options_,
                                      late_->enumerated() ? FloatLayout::enumerated : FloatLayout::table);
    dt_ = 0.3 * late_->stable_step();
  }
  std::unique_ptr<gl::DeviceSolver> make(bool late) {
    options_.gl.late_report = late;
    return std::make_unique<gl::DeviceSolver>(GetParam(), tables_, *scene_, options_);
  }
  void reset(const State& state) const {
    at_once_->reset(state);
    late_->reset(state);
    mirror_->reset(state);
  }
  /// The bits on llvmpipe; elsewhere within what rounding makes of hundreds of damped steps.
  void expect_mirrors_state() const {
    const State state = late_->read(), mirror = mirror_->read();
    EXPECT_EQ(state.time, mirror.time);
    EXPECT_LE(largest_distance(state.position, mirror.position), 1e-5 * body_size(model_));
    if (late_->context()->info().renderer.starts_with("llvmpipe")) {
      EXPECT_EQ(difference(state, mirror), "");
    }
  }
  static void expect_same(const StepReport& late, const StepReport& before) {
    EXPECT_EQ(late.status, before.status);
    EXPECT_EQ(late.steps, before.steps);
    EXPECT_EQ(late.time, before.time);
    EXPECT_EQ(late.residual, before.residual);
    EXPECT_EQ(late.max_speed, before.max_speed);
    EXPECT_EQ(late.force_clamped, before.force_clamped);
    EXPECT_EQ(late.particle, before.particle);
  }

  Model model_;
  std::optional<Scene> scene_;
  std::shared_ptr<const TopologyTextures> tables_;
  SolverOptions options_;
  std::unique_ptr<gl::DeviceSolver> at_once_, late_;
  std::unique_ptr<Solver> mirror_;
  double dt_ = 0.0;
};

PHYMUL_ON_BOTH_DEVICES(GlLateReport);

TEST_P(GlLateReport, TellsOfTheCallBefore) {
  reset(random_state(model_, 0.1, 0.1, 3));
  StepReport before = late_->step(0, dt_);
  EXPECT_EQ(before.steps, 0);
  before = {};
  for (const int steps : {1, 3, 40, 300, 2, 7}) {  // more than a batch, too
    const StepReport now = at_once_->step(steps, dt_), late = late_->step(steps, dt_);
    const StepReport mirror = mirror_->step(steps, dt_);
    EXPECT_TRUE(now.ok());
    EXPECT_NEAR(now.residual, mirror.residual, 1e-3 * mirror.residual);
    EXPECT_NEAR(now.max_speed, mirror.max_speed, 1e-3 * mirror.max_speed);
    EXPECT_EQ(now.force_clamped, mirror.force_clamped);
    EXPECT_EQ(late.steps, before.steps);
    EXPECT_EQ(late.residual, before.residual);
    EXPECT_EQ(late.max_speed, before.max_speed);
    EXPECT_EQ(late.force_clamped, before.force_clamped);
    before = now;
  }
  expect_same(late_->step(0, dt_), before);
  EXPECT_EQ(difference(late_->read(), at_once_->read()), "");
  expect_mirrors_state();
}

TEST_P(GlLateReport, WhoLooksAtTheStateSeesAllSteps) {
  reset(random_state(model_, 0.1, 0.1, 3));
  for (int call = 0; call < 4; ++call) {
    at_once_->step(3, dt_);
    late_->step(3, dt_);
    EXPECT_EQ(late_->energy().total(), at_once_->energy().total());
    at_once_->step(3, dt_);
    late_->step(3, dt_);
    EXPECT_EQ(late_->momentum().linear, at_once_->momentum().linear);
    at_once_->step(3, dt_);
    late_->step(3, dt_);
    const std::vector<Float4> u = texels_of(*late_->context(), late_->position_buffer());
    const State state = at_once_->read();
    for (std::size_t i = 0; i < model_.rest.size(); ++i) {
      EXPECT_LE((model_.rest[i] + Vec3(u[i][0], u[i][1], u[i][2]) - state.position[i]).norm(),
                1e-6 * body_size(model_));
    }
    EXPECT_EQ(difference(late_->read(), state), "");
    ASSERT_TRUE(mirror_->step(9, dt_).ok());
    expect_mirrors_state();
  }
}

TEST_P(GlLateReport, FailuresAreToldByTheNextCallWhichTakesNoStep) {
  State start = random_state(model_, 0.2, 0.0, 3);
  const double dt = 3.0 * late_->stable_step();
  for (const bool looked_at : {false, true}) {
    reset(start);
    const StepReport failed = at_once_->step(200, dt);
    ASSERT_EQ(failed.status, StepStatus::not_finite);
    ASSERT_GT(failed.steps, 0);
    int steps = 0;
    StepReport late;
    for (int call = 0; call < 50 && late.ok(); ++call) {
      late = late_->step(4, dt);
      steps += late.steps;
      if (looked_at) static_cast<void>(late_->read());
    }
    EXPECT_EQ(late.status, StepStatus::not_finite);
    EXPECT_EQ(late.particle, failed.particle);
    EXPECT_EQ(steps, failed.steps);
    EXPECT_EQ(late.time, failed.time);
    EXPECT_EQ(late.residual, failed.residual);
    EXPECT_EQ(difference(late_->read(), at_once_->read()), "");
    EXPECT_TRUE(late_->step(1, 1e-6 * dt).ok()) << "told once";
  }
}

TEST_P(GlLateReport, ScenesMayChangeAndResetForgets) {
  reset(random_state(model_, 0.1, 0.1, 3));
  for (int call = 0; call < 3; ++call) {
    at_once_->step(5, dt_);
    late_->step(5, dt_);
    mirror_->step(5, dt_);
    scene_->clear().gravity({0, 0, call == 1 ? 3.0 : -1.0});
    if (call == 0) scene_->fix("x1");
  }
  at_once_->step(5, dt_);
  late_->step(5, dt_);
  mirror_->step(5, dt_);
  EXPECT_EQ(difference(late_->read(), at_once_->read()), "");
  expect_mirrors_state();
  late_->step(5, dt_);
  late_->reset();
  EXPECT_EQ(late_->step(0, dt_).steps, 0);
  EXPECT_EQ(late_->read(), rest_state(model_));
}

TEST_P(GlLateReport, RunToRestWaits) {
  options_.damping.rate = 60.0;
  options_.damping.factor = 1.0;
  at_once_ = make(false);
  late_ = make(true);
  late_->step(3, dt_);
  at_once_->step(3, dt_);
  const RestResult a = at_once_->run_to_rest(20000, dt_), b = late_->run_to_rest(20000, dt_);
  EXPECT_TRUE(b.converged());
  EXPECT_EQ(b.report.steps, a.report.steps);
  EXPECT_EQ(difference(late_->read(), at_once_->read()), "");
}

TEST_P(GlLateReport, WithProgressEveryCallDoesAllItsSteps) {
  options_.progress = [](const StepProgress&) { return true; };
  options_.progress_seconds = 0.0;
  const auto told = make(true);
  for (int call = 0; call < 3; ++call) {
    EXPECT_EQ(told->step(20, dt_).steps, 20);
    ASSERT_TRUE(at_once_->step(20, dt_).ok());
  }
  EXPECT_EQ(difference(told->read(), at_once_->read()), "");
}

/// Far from the origin, where positions alone would lose the last bits of displacements.
TEST_P(GlLateReport, SnapshotsGoOnBitForBit) {
  for (Vec3& X : model_.rest) X += Vec3(1000.0, -2000.0, 500.0);
  scene_.emplace(model_);
  scene_->fix("x0").gravity({0, 0, -9.81});
  tables_ = tables_of(model_, {});
  for (const bool late : {false, true}) {
    const auto solver = make(late);
    solver->step(37, dt_);
    const Snapshot snapshot = solver->snapshot();
    solver->step(20, dt_);
    const Snapshot there = solver->snapshot();
    solver->restore(snapshot);
    EXPECT_EQ(solver->snapshot(), snapshot);
    solver->step(20, dt_);
    EXPECT_EQ(solver->snapshot(), there);
  }
}

}  // namespace
}  // namespace phymul::test
