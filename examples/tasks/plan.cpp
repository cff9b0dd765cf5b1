// SPDX-License-Identifier: MIT
//
// An organ that is as fine as an error of 20 % needs, and no finer, in a loop at 100 Hz.
#include <phymul/phymul.h>

#include <cstdio>

int main() try {
  const phymul::Solid organ = phymul::solid_ellipsoid({0, 0, 0}, {0.06, 0.04, 0.03});
  const auto fill = [](phymul::Simulation& sim) {
    sim.scene().fix(sim.model().particles_in([](const phymul::Vec3& at) { return at.x() < -0.03; }));
    sim.scene().gravity({0, 0, -4.0});
  };
  const phymul::SimulationOptions tissue{.material = {.young = 5e3, .poisson = 0.45, .density = 1000}};
  const phymul::Plan plan = phymul::plan(organ, tissue, fill, {.max_error = 0.2, .rate = 100});
  std::puts(plan.report().c_str());
  if (!plan.kept && !plan.most_accurate) return 1;  // nothing keeps the time
  phymul::Simulation sim = plan.kept ? plan.make() : plan.make(*plan.most_accurate);
  return sim.advance(0.01).ok() ? 0 : 1;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
