// SPDX-License-Identifier: MIT
#include <phymul/phymul.h>

#include <cstdio>

int main() try {
  phymul::Model model = phymul::make_cylinder(0.010, 0.040, 3, 8, 11);  // m; or read_pml("liver.pml"), read_mesh(...)
  phymul::set_material(model, {.young = 5e3, .poisson = 0.45, .density = 1000});  // Pa, 1, kg/m^3

  phymul::Scene scene(model);
  scene.fix("bottom").gravity({9.81, 0, 0});  // m/s^2: a beam that sags

  phymul::SolverOptions options;
  options.damping.rate = 20;  // 1/s
  const auto solver = phymul::make_solver("auto", model, scene, {}, options);

  const phymul::RestResult rest = solver->run_to_rest(200'000, 0.5 * solver->stable_step());
  if (!rest.converged()) {  // a failure, or the steps were used up
    std::puts(rest.message().c_str());
    return 1;
  }
  const phymul::State state = solver->read();
  std::printf("at rest after %.2f s, sagged %.1f mm\n", state.time, 1e3 * displacement_norms(model, state).max);
  phymul::write_vtu(model, state, "sagged.vtu");  // for ParaView
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
