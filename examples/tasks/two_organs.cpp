// SPDX-License-Identifier: MIT
//
// Two organs of different stiffness that touch: the soft one comes to rest on the other.
#include <phymul/phymul.h>

#include <cstdio>

int main() try {
  const phymul::Model organ = phymul::make_block({0.04, 0.04, 0.02}, 4, 4, 2);
  const phymul::Material soft{.young = 8e3, .poisson = 0.4, .density = 1000};
  const phymul::Material stiff{.young = 40e3, .poisson = 0.4, .density = 1000};

  phymul::Simulation sim({{"liver", organ, stiff}, {"gallbladder", moved(organ, {0, 0, 0.022}), soft}},
                         {.solver = {.rest_tolerance = 1e-6}});  // bodies that touch tremble by more than the default
  sim.scene().fix("liver/z0").gravity({0, 0, -9.81}).contacts({.friction = 0.4, .self = false});
  const phymul::RestResult rest = sim.run_to_rest();

  std::printf("%s; the upper one sinks by %.2f mm\n", rest.message().c_str(), 1e3 * sim.max_displacement());
  return rest.converged() ? 0 : 1;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
