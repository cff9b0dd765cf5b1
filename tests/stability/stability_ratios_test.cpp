// SPDX-License-Identifier: MIT
//
// Contrasts of stiffness and mass, stiff and nearly incompressible materials, units mistaken: the step limit stays
// right, runs stay bounded, suspect units are named.

#include "stability_fixture.h"

namespace phymul::test {
namespace {

constexpr double side = 0.03;

/// Largest displacement over the spacing after noise of 1e-7 spacings has had time to grow; infinite: ran away.
double grown(const Model& model, const TopologyOptions& topology, double share_of_limit, int steps) {
  const Scene scene(model);
  const auto solver = make_solver("reference", model, scene, topology, any_step_uncut());
  solver->reset(displaced(model, 1e-7, 1));
  if (!solver->step(steps, share_of_limit * solver->stable_step()).ok()) {
    return std::numeric_limits<double>::infinity();
  }
  return displacement_norms(model, solver->read()).max / mean_spacing(model);
}

/// Beyond the limit by 1 % noise grows by a tenth a step, undamped.
void expect_limit_within_two_percent(const Model& model, const TopologyOptions& topology, const std::string& what) {
  EXPECT_LT(grown(model, topology, 0.98, 300), 1e-5) << what;
  EXPECT_GT(grown(model, topology, 1.02, 300), 1e-3) << what;
}

/// One particle (springs, k in N/m), or the material of one end of the cube.
Model with_stiff_part(const Method& method, double ratio) {
  Model model = tissue_cube(method, side, 2);
  if (!method.material) {
    model.stiffness[13] *= ratio;
    return model;
  }
  model.components.push_back({.name = "stiff", .exclusive = false, .cell_refs = {0}});
  Material tissue = soft_tissue(method.poisson);
  tissue.young *= ratio;
  set_material(model, tissue, "stiff");
  return model;
}

Model with_masses(Model model, double ratio) {
  for (std::size_t i = 0; i < model.mass.size(); i += 3) model.mass[i] *= ratio;
  return model;
}

TEST(StabilityRatios, LimitIsRightForEveryContrastOfStiffnessAndMass) {
  for (const Method& method : stability_methods()) {
    if (!is_conservative(method)) continue;
    for (const double ratio : {1e2, 1e4, 1e6}) {
      const std::string what = method.name + ", ratio " + std::to_string(ratio);
      expect_limit_within_two_percent(with_stiff_part(method, ratio), method.options, "stiffness, " + what);
      const Model plain = tissue_cube(method, side, 2);
      expect_limit_within_two_percent(with_masses(plain, ratio), method.options, "mass, " + what);
      expect_limit_within_two_percent(with_masses(plain, 1.0 / ratio), method.options, "light, " + what);
      expect_limit_within_two_percent(with_masses(with_stiff_part(method, ratio), ratio), method.options,
                                      "both, " + what);
    }
  }
}

TEST(StabilityRatios, LimitIsRightForNearlyIncompressibleAndForAnyStiffness) {
  for (const double poisson : {0.0, 0.45, 0.49, 0.499}) {
    for (const double young : {10.0, 10e3, 1e9}) {
      const Model model = with_material(make_block({side, side, side}, 2, 2, 2), {young, poisson, 1000.0});
      expect_limit_within_two_percent(model, {}, "nu " + std::to_string(poisson) + ", E " + std::to_string(young));
    }
  }
}

/// The limit falls as 1 / sqrt(E) and 1 / sqrt(kappa): 0.499 costs a step 8 times shorter than 0.3.
TEST(StabilityRatios, TheLimitIsWhatTheMaterialCosts) {
  const auto limit = [](double young, double poisson) {
    const Model model = with_material(make_block({side, side, side}, 2, 2, 2), {young, poisson, 1000.0});
    return stable_step(estimate_spectrum(build_topology(model), model.rest), 1.0);
  };
  EXPECT_NEAR(limit(10.0, 0.3) / limit(1e9, 0.3), 1e4, 10.0);
  EXPECT_NEAR(limit(10e3, 0.3) / limit(10e3, 0.499), 12.0, 6.0);
}

class StabilityContrasts : public OnBackend {};

/// Sharp contrasts at half the limit: bounded, and momentum kept to the backend's rounding.
TEST_P(StabilityContrasts, RunsStayBoundedAndKeepMomentum) {
  for (const char* name : {"springs 18", "material, nu 0.3", "material, nu 0.45"}) {
    const Method method = method_named(name);
    for (const double ratio : {1e-4, 1e4}) {
      const Model model = with_masses(with_stiff_part(method, 1e4), ratio);
      const Scene scene(model);
      const auto solver = make(model, scene, method.options);
      solver->reset(displaced(model, 0.02, 2));
      ASSERT_TRUE(is_ok(solver->step(is_slow() ? 200 : 2000, 0.5 * solver->stable_step()))) << name;
      double mass_speed = 0.0;
      const State end = solver->read();
      for (std::size_t i = 0; i < model.mass.size(); ++i) mass_speed += model.mass[i] * end.velocity[i].norm();
      EXPECT_LE(solver->momentum().linear.norm(), (is_reference() ? 1e-11 : 2e-4) * mass_speed) << name;
      // Light particles fly while heavy ones stand: still within the body.
      EXPECT_LT(displacement_norms(model, end).max, 0.5 * side) << name;
    }
  }
}

PHYMUL_ON_EVERY_BACKEND(StabilityContrasts);

}  // namespace
}  // namespace phymul::test
