// SPDX-License-Identifier: MIT
//
// What StepReport says of a body that is strained farther than its law is meant for.
#include <gtest/gtest.h>

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
