// SPDX-License-Identifier: MIT
//
// Neighbourhoods without a direction: springs of no length, bases on a line, particles with too few neighbours, and
// neighbours taken away from a stretched body.
#include <cstdio>

#include <phymul/check.h>

#include "stability_fixture.h"
#include "support/message_of.h"

namespace phymul::test {
namespace {

class StabilityBases : public OnBackend {
 protected:
  /// Steps a body from a state; every report must be good and every number finite.
  static State stepped(const Model& model, const TopologyOptions& topology, const State& start, int steps) {
    const Scene scene(model);
    const auto solver = make(model, scene, topology, {.damping = {.factor = 0.98}});
    solver->reset(start);
    EXPECT_TRUE(is_ok(solver->step(steps, 0.5 * solver->stable_step())));
    State end = solver->read();
    EXPECT_TRUE(is_finite(end));
    return end;
  }
};

TopologyOptions springs() {
  return {.law = Law::springs};
}

/// At rest they coincide: `check` names them; a spring between them has rest length 0 and pulls them together.
TEST_P(StabilityBases, CoincidentParticlesAreNamedAndStayFinite) {
  Model model = without_cells(make_block({0.02, 0.02, 0.02}, 2, 2, 2, 18));
  model.rest[1] = model.rest[0];
  bool named = false;
  for (const Finding& finding : find_flaws(model)) named = named || finding.flaw == Flaw::duplicate_point;
  EXPECT_TRUE(named);
  State state = rest_state(model);
  state.position[1] += Vec3::Constant(1e-3);
  const State end = stepped(model, springs(), state, 2000);
  EXPECT_LT((end.position[1] - end.position[0]).norm(), 1e-3);
}

/// A base whose corners pass through a line while it moves: no NaN on the way, and back to rest.
TEST_P(StabilityBases, ABasePassesThroughALineInFlight) {
  const Model model = make_tetrahedron(0.01);
  State state = rest_state(model);
  // Particle 3's base (0, 1, 2): its corner 2 starts beyond the line through 0 and 1, and comes back across it.
  const Vec3 middle = 0.5 * (model.rest[0] + model.rest[1]);
  state.position[2] = middle - 0.3 * (model.rest[2] - middle);
  EXPECT_LT(distance_from_rest_shape(model, stepped(model, {}, state, 4000).position), 0.01);
  state.position[2] = middle;  // exactly on it
  EXPECT_LT(distance_from_rest_shape(model, stepped(model, {}, state, 4000).position), 0.01);
}

PHYMUL_ON_EVERY_BACKEND(StabilityBases);

double highest_eigenvalue(const Model& model, const TopologyOptions& options) {
  return estimate_spectrum(build_topology(model, options), model.rest).largest;
}

/// Thin triples raise the largest eigenvalue; the thresholds leave them out.
TEST(StabilityThinBases, ThresholdsKeepTheStepLimit) {
  Model model = make_block({0.03, 0.03, 0.03}, 3, 3, 3, 18);
  TopologyOptions kept, all;
  all.bases = BaseSelection::all;
  const double clean = highest_eigenvalue(model, kept);
  for (const double squeeze : {0.1, 1e-2, 1e-4, 1e-6}) {
    // Particle 1 moves next to the line between two of its neighbours: triples with it become thin.
    Model thin = model;
    thin.rest[1].y() += squeeze * 0.01;
    thin.rest[1].z() += squeeze * 0.01;
    EXPECT_LE(highest_eigenvalue(thin, kept), 1.2 * clean) << squeeze;
  }
  Model jittered = model;
  jitter(jittered, 0.2, 7);
  const double with_thin = highest_eigenvalue(jittered, all), without = highest_eigenvalue(jittered, kept);
  std::printf("largest eigenvalue of a jittered lattice over the clean one: thresholded %.2f, all triples %.2f\n",
              without / clean, with_thin / clean);
  EXPECT_LT(without, 3.0 * clean);
}

/// A cut: tables built anew from the rest shape without some neighbours. Nothing jumps at rest, the step limit hardly
/// moves, and a stretched body goes on from where it was.
TEST(StabilityCut, NeighboursTakenAwayWhileStretched) {
  Model whole = make_block({0.03, 0.02, 0.02}, 3, 2, 2, 18);
  Model cut = whole;
  const auto is_left = [&](Index i) { return whole.rest[i].x() < 0.015; };
  RaggedList kept;
  for (Index i = 0; i < whole.particle_count(); ++i) {
    std::vector<Index> row;
    for (const Index* j = whole.neighbours.begin(i); j != whole.neighbours.end(i); ++j) {
      // Cut half way through: the upper half keeps its bonds.
      if (is_left(i) == is_left(*j) || whole.rest[i].z() > 0.005) row.push_back(*j);
    }
    kept.push_row(row.begin(), row.end());
  }
  cut.neighbours = kept;
  ASSERT_LT(cut.neighbours.entry.size(), whole.neighbours.entry.size());
  const TopologyOptions options{.on_sparse = SparseParticle::springs};
  const Scene before(whole), after(cut);
  const auto solver = make_solver("reference", whole, before, options),
             next = make_solver("reference", cut, after, options);
  EXPECT_LE(largest_norm(forces_at(next->topology(), cut.rest)), 1e-13 * whole.stiffness[0] * mean_spacing(whole));
  EXPECT_NEAR(next->stable_step(), solver->stable_step(), 0.5 * solver->stable_step());
  State state = rest_state(whole);
  for (Vec3& p : state.position) p.x() *= 1.3;
  solver->reset(state);
  ASSERT_TRUE(solver->step(50, 0.5 * solver->stable_step()).ok());
  next->reset(solver->read());
  EXPECT_TRUE(next->step(2000, 0.5 * next->stable_step()).ok());
  EXPECT_LT(displacement_norms(cut, next->read()).max, 0.03);
}

}  // namespace
}  // namespace phymul::test
