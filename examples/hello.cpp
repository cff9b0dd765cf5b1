// SPDX-License-Identifier: MIT
#include <phymul/phymul.h>

#include <cstdio>

int main() try {
  phymul::Simulation sim(phymul::make_block({0.2, 0.05, 0.05}, 16, 4, 4),
                         {.material = phymul::Material{.young = 30e3, .poisson = 0.3, .density = 1000}});
  sim.scene().fix("x0").gravity({0, 0, -9.81});

  const phymul::RestResult rest = sim.run_to_rest();
  std::printf("%s; sags %.1f mm\n", rest.message().c_str(), 1e3 * sim.max_displacement());
  phymul::write_vtu(sim.model(), sim.state(), "sagged.vtu");  // for ParaView
  return rest.converged() ? 0 : 1;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
