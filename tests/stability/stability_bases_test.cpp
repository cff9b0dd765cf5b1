// SPDX-License-Identifier: MIT
//
// Neighbourhoods without a direction: springs of no length, bases on a line, particles with too few neighbours, and
// neighbours taken away from a stretched body.
#include <phymul/check.h>

#include <gtest/gtest.h>
#include <cstdio>

#include "stability_fixture.h"
#include "stability_methods.h"
#include "support/mechanics.h"
#include "support/sanitized.h"

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

// Reactions that take no energy into account: they grow, or swing ever wider, as fast as their eigenvalues say; the
// spectrum names them; damping holds the slow ones.

const std::vector<std::pair<const char*, Reaction>>& reactions_without_energy() {
  static const std::vector<std::pair<const char*, Reaction>> all{
      {"full", Reaction::full}, {"shared", Reaction::shared}, {"barycentric", Reaction::barycentric}};
  return all;
}

std::shared_ptr<const TopologyTextures> tables_of(const Body& body, Reaction reaction) {
  const TopologyOptions options{.reaction = reaction, .on_sparse = SparseParticle::springs};
  return std::make_shared<const TopologyTextures>(build_topology(body.model, options));
}

/// Six bodies and more; the cylinder, whose dense matrix takes seconds, is in the atlas.
std::vector<Body> small_bodies() {
  std::vector<Body> all = bodies();
  std::erase_if(all, [](const Body& body) { return body.model.particle_count() > (sanitized ? 40 : 100); });
  return all;
}

TEST(StabilityGrowth, RatesAreThoseOfTheEigenvalues) {
  for (const auto& [name, reaction] : reactions_without_energy()) {
    int growing = 0;
    for (const Body& body : small_bodies()) {
      SCOPED_TRACE(std::string(name) + ", " + body.name);
      const auto tables = tables_of(body, reaction);
      const GrowthRate rate = growth_rate(body.model, tables);
      const Spectrum spectrum = estimate_spectrum(*tables, body.model.rest);
      if (rate.predicted == 0.0) {
        EXPECT_EQ(spectrum.most_negative, 0.0);
        continue;
      }
      ++growing;
      std::printf("%s, %s: grows by %.2g omega_max, measured %.4f of that\n", name, body.name.c_str(),
                  rate.predicted / rate.highest, rate.measured / rate.predicted);
      EXPECT_NEAR(rate.measured, rate.predicted, 0.02 * rate.predicted);
      // What the report and the cut go by.
      EXPECT_TRUE(spectrum.most_negative < 0.0 || spectrum.largest_imaginary > 0.0);
      EXPECT_EQ(spectrum.most_negative < 0.0, reaction == Reaction::full);
    }
    EXPECT_GE(growing, reaction == Reaction::full ? 5 : 3) << name;
  }
}

/// Noise of a ten-thousandth of a spacing after 20,000 steps at half the limit.
double noise_after(const Body& body, Reaction reaction, double damping_factor) {
  const Scene scene(body.model);
  const SolverOptions options{.damping = {.factor = damping_factor}, .on_unstable = UnstableStep::allow};
  const auto solver = make_solver("cpu", tables_of(body, reaction), scene, options);
  solver->reset(displaced(body.model, 1e-4, 1));
  const StepReport report = solver->step(sanitized ? 4000 : 20000, 0.5 * solver->stable_step());
  if (!report.ok()) return std::numeric_limits<double>::infinity();
  return report.max_speed / (mean_spacing(body.model) / solver->stable_step());
}

TEST(StabilityGrowth, UndampedFlutterGrowsAndDampedFlutterDies) {
  const Body body{"jittered", jittered_block()};
  for (const Reaction reaction : {Reaction::shared, Reaction::barycentric}) {
    const double undamped = noise_after(body, reaction, 1.0), damped = noise_after(body, reaction, 0.9);
    std::printf("speed after the run, spacings a step: undamped %.2g, d = 0.9 %.2g\n", undamped, damped);
    EXPECT_GT(undamped, 1e-2);
    EXPECT_LT(damped, 1e-7);
  }
  // Damping does not hold the full reaction: its growth per step is more than damping takes.
  EXPECT_EQ(noise_after(body, Reaction::full, 0.9), std::numeric_limits<double>::infinity());
}

/// The gradients stay as still as their rounding, undamped: 40,000 steps from noise of a millionth of a spacing.
TEST(StabilityGrowth, ConservativeBodiesDoNotGrowUndamped) {
  for (const Method& method : stability_methods()) {
    if (!is_conservative(method)) continue;
    Model model = tissue_cube(method, 0.02, 2);
    const Scene scene(model);
    const auto solver = make_solver("reference", model, scene, method.options);
    solver->reset(displaced(model, 1e-6, 1));
    const StepReport report = solver->step(sanitized ? 2000 : 40000, 0.5 * solver->stable_step());
    EXPECT_TRUE(report.ok()) << method.name;
    // Springs along edges alone are a mechanism, which drifts.
    EXPECT_LT(displacement_norms(model, solver->read()).max, 1e-3 * mean_spacing(model)) << method.name;
  }
}

}  // namespace
}  // namespace phymul::test
