// SPDX-License-Identifier: MIT
//
// Bodies of Law::particle_averaged close to the step limit: long undamped motion, and a punch by half a spacing.
#include <cmath>

#include "stability_fixture.h"

namespace phymul::test {
namespace {

/// A beam of tetrahedra under a twentieth of gravity, from rest, swings for 100,000 steps. Single precision; the total
/// is 0 at first, so that its change is told against the largest kinetic energy.
TEST(StabilityAveraged, EnergyIsKeptForLongCloseToTheLimit) {
  const Model model = with_material(make_tetrahedral_block({0.2, 0.05, 0.05}, 16, 4, 4, 0.2, 1),
                                    {.young = 10e3, .poisson = 0.3, .density = 1000.0});
  Scene scene = Scene(model).fix("x0").gravity({0, 0, -0.5});
  const auto solver = make_solver("cpu", model, scene);
  double kinetic = 0.0, drift = 0.0;
  for (int k = 0; k < (sanitized ? 20 : 1000); ++k) {
    ASSERT_TRUE(solver->step(100, 0.9 * solver->stable_step()).ok());
    const Energy now = solver->energy();
    kinetic = std::max(kinetic, now.kinetic);
    drift = std::max(drift, std::abs(now.total()));
  }
  EXPECT_LT(drift, 1e-3 * kinetic);
  RecordProperty("drift", std::to_string(drift / kinetic));
}

/// All at once, and held: the rest shape does not depend on the step.
TEST(StabilityAveraged, APunchRestsInTheSameShapeCloseToTheLimit) {
  for (const double poisson : {0.3, 0.45}) {
    const Model model =
        with_material(make_block({0.1, 0.1, 0.05}, 10, 10, 5), {.young = 10e3, .poisson = poisson, .density = 1000.0});
    Load punch{.type = LoadType::translation, .events = {{0.0, 0.005}}, .direction = {0, 0, -1}};
    for (Index i = 0; i < model.particle_count(); ++i) {
      const Vec3 from_middle = model.rest[i] - Vec3(0.05, 0.05, 0.05);
      if (from_middle.cwiseAbs().maxCoeff() < 0.021 && from_middle.z() > -0.001) punch.particles.push_back(i);
    }
    Scene scene = Scene(model).fix("z0").add(punch);
    const auto solver = make_solver("cpu", model, scene, {}, damped(40.0));
    const auto rest_at = [&](double share) {
      solver->reset();
      EXPECT_TRUE(solver->run_to_rest(4000, share * solver->stable_step()).converged());
      return solver->read().position;
    };
    const VecList at_half = rest_at(0.5), close_to_limit = rest_at(0.9);
    EXPECT_LE(position_error(model, close_to_limit, at_half).global_ratio, 1e-4);
  }
}

}  // namespace
}  // namespace phymul::test
