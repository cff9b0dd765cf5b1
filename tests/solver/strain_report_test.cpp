// SPDX-License-Identifier: MIT
//
// What StepReport says of a body that is strained farther than its law is meant for.
#include <gtest/gtest.h>
#include <phymul/phymul.h>

#include "support/bodies.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

class StrainReport : public testing::TestWithParam<const char*> {
 protected:
  /// Of one short step from a uniform strain.
  StepReport report_at(const Mat3& F) {
    State state = rest_state(model_);
    for (Vec3& x : state.position) x = F * x;
    solver_->reset(state);
    return solver_->step(1, 1e-6 * solver_->stable_step());
  }

  Model model_ = with_material(make_tetrahedral_block({0.03, 0.03, 0.03}, 3, 3, 3, 0.2, 1));
  Scene scene_{model_};
  std::unique_ptr<Solver> solver_ = make_solver(GetParam(), model_, scene_);
};
INSTANTIATE_TEST_SUITE_P(Backends, StrainReport, testing::Values("reference", "cpu"));

TEST_P(StrainReport, CountsWhatIsBeyondTheLawAndWhatIsInverted) {
  const Index all = model_.particle_count();
  const auto expect = [&](const Vec3& stretch, Index beyond, Index inverted) {
    const StepReport report = report_at(stretch.asDiagonal());
    EXPECT_EQ(report.beyond_law, beyond) << stretch.transpose();
    EXPECT_EQ(report.inverted, inverted) << stretch.transpose();
    EXPECT_EQ(report.first_beyond, beyond > 0 ? 0 : -1) << stretch.transpose();
    return report;
  };
  expect({1, 1, 1}, 0, 0);
  expect({1.65, 1.65, 0.63}, 0, 0);
  expect({0.63, 0.63, 0.63}, 0, 0);
  EXPECT_TRUE(says(expect({1, 1, 0.2}, all, 0).message(), "strained beyond the law, first around particle 0"));
  expect({3, 1, 1}, all, 0);
  EXPECT_TRUE(says(expect({1, 1, -1}, all, all).message(), "inverted around 64"));
}

TEST_P(StrainReport, KeepsWhereAndWhenItBegan) {
  State state = rest_state(model_);
  state.position.back() += Vec3(0.05, 0.05, 0.05);
  solver_->reset(state);
  const double dt = 1e-3 * solver_->stable_step();
  const StepReport first = solver_->step(1, dt), later = solver_->step(5, dt);
  EXPECT_GT(first.beyond_law, 0);
  EXPECT_EQ(first.beyond_since, dt);
  EXPECT_EQ(later.first_beyond, first.first_beyond);
  EXPECT_EQ(later.beyond_since, dt);
  solver_->reset();
  EXPECT_EQ(solver_->step(1, dt).first_beyond, -1);
}

/// A bar is drawn out to two and a half times its length within 0.2 s.
Simulation drawn(const char* backend, const SolverOptions& options = {}) {
  const Model bar = with_material(make_tetrahedral_block({0.06, 0.02, 0.02}, 18, 6, 6, 0.1, 7), {5e3, 0.4, 1000});
  Simulation sim(with_spare_particles(bar, 300), {.backend = backend, .damping = {.rate = 50}, .solver = options});
  sim.scene().fix("x0").add({.type = LoadType::translation,
                             .particles = sim.model().group("x1"),
                             .events = {{0.0, 0.0}, {0.2, 0.09}},
                             .direction = {1, 0, 0}});
  return sim;
}

TEST_P(StrainReport, IsKnownAtRestAndOutlivesACut) {
  Simulation sim = drawn(GetParam());
  ASSERT_TRUE(sim.advance(0.21).ok());
  const StepReport at_rest = sim.run_to_rest().report, next = sim.advance(0.01);
  EXPECT_GT(next.beyond_law, 100);
  EXPECT_EQ(at_rest.beyond_law, next.beyond_law);
  EXPECT_NEAR(at_rest.growth, next.growth, 1e-3 * next.growth);
  CutSurface half = cut_plane({0.03, 0.0, 0.0}, {1.0, 0.0, 0.0});
  half.front = [](const Vec3& x) { return x.z() - 0.005; };
  ASSERT_TRUE(sim.cut(half));
  const StepReport after = sim.advance(0.01);
  EXPECT_EQ(after.first_beyond, next.first_beyond);
  EXPECT_EQ(after.beyond_since, next.beyond_since);
}

TEST(StrainReportOfSleep, IsThatOfABodyAwake) {
  Simulation awake = drawn("cpu"), asleep = drawn("cpu", {.sleep_tolerance = 1e-4});
  const Snapshot start = asleep.snapshot();
  StepReport reports[2];
  for (int k = 0; k < 8; ++k) {
    reports[0] = awake.advance(0.25);
    reports[1] = asleep.advance(0.25);
  }
  EXPECT_EQ(reports[1].max_speed, 0.0);
  EXPECT_GT(reports[0].beyond_law, 100);
  EXPECT_EQ(reports[1].beyond_law, reports[0].beyond_law);
  EXPECT_NEAR(reports[1].growth, reports[0].growth, 1e-3 * reports[0].growth);
  asleep.restore(start);
  EXPECT_EQ(asleep.advance(0.0).beyond_law, 0);
}

/// Undamped under ten times its weight, at half of the step limit, a beam that hangs from one end is torn out of its
/// law at the clamp. It is reported from then on, and is a failure before it has gone farther than a few metres.
TEST_P(StrainReport, ABodyThatIsCarriedAwayIsAFailure) {
  const Model beam = with_material(make_tetrahedral_block({0.2, 0.05, 0.05}, 8, 2, 2, 0.2, 1),
                                   {.young = 10e3, .poisson = 0.45, .density = 1000});
  Scene hung = Scene(beam).fix("x0").gravity({0, 0, -98.1});
  const auto solver = make_solver(GetParam(), beam, hung);
  StepReport report;
  for (int k = 0; k < 200 && report.ok(); ++k) report = solver->step(20, 0.5 * solver->stable_step());
  EXPECT_EQ(report.status, StepStatus::carried_away);
  EXPECT_GT(report.first_beyond, -1);
  EXPECT_LT(report.beyond_since, 0.9 * report.time);
  EXPECT_LT(largest_distance(solver->read().position, beam.rest), 5.0);
  EXPECT_TRUE(says(report.message(), "carried_away: particle"));
  const StepReport still = solver->step(1, 1e-9 * report.dt);  // passes time alone
  EXPECT_EQ(still.status, StepStatus::carried_away);
  EXPECT_EQ(still.beyond_law, report.beyond_law);
}

/// Nothing holds it: it may fly as far as it likes.
TEST_P(StrainReport, AFreeBodyMayGoAnywhere) {
  State state = rest_state(model_);
  for (Vec3& x : state.position) x += Vec3(100, 0, 0);
  state.position.back() += Vec3(0.05, 0.05, 0.05);
  solver_->reset(state);
  const StepReport report = solver_->step(1, 1e-3 * solver_->stable_step());
  EXPECT_GT(report.beyond_law, 0);
  EXPECT_TRUE(report.ok()) << report.message();
}

}  // namespace
}  // namespace phymul::test
