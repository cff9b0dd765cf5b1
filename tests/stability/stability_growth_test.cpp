// SPDX-License-Identifier: MIT
//
// Reactions that take no energy into account: they grow, or swing ever wider, as fast as their eigenvalues say; the
// spectrum names them; damping holds the slow ones.
#include <gtest/gtest.h>

#include <cstdio>

#include "stability_methods.h"
#include "support/growth_rate.h"
#include "support/sanitized.h"

namespace phymul::test {
namespace {

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
