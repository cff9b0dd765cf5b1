// SPDX-License-Identifier: MIT
//
// A beam takes three loads, one after another: its rest shape under each without steps, then motion from there.
#include <phymul/phymul.h>

#include <cstdio>

int main() try {
  phymul::Simulation sim(phymul::make_tetrahedral_block({0.2, 0.05, 0.05}, 16, 4, 4, 0.2, 1),
                         {.material = phymul::Material{.young = 10e3, .poisson = 0.3, .density = 1000}});
  sim.scene().fix("x0");
  for (const double gravity : {0.1, 0.2, 0.3}) {
    sim.scene().gravity({0, 0, -gravity});
    const phymul::StaticResult rest = sim.solve_static();
    std::printf("%.1f m/s^2: %s; sags %.2f mm\n", gravity, rest.message().c_str(), 1e3 * sim.max_displacement());
    if (!rest.converged()) return 1;
  }
  sim.scene().gravity({0, 0, 0});
  return sim.advance(0.1).ok() ? 0 : 1;  // it swings back
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
