// SPDX-License-Identifier: MIT
#include <phymul/phymul.h>

#include <cstdio>

int main(int, char** argv) try {
  const phymul::Model model = phymul::read_pml(argv[1]);
  phymul::Scene scene(model);
  scene.gravity({0, 0, -9.81});
  const auto solver = phymul::make_solver("auto", model, scene);
  const phymul::StepReport report = solver->step(10, 0.25 * solver->stable_step());
  std::printf("phymul %s: %d particles, %d steps\n", PHYMUL_VERSION, model.particle_count(), report.steps);
  for (const std::string& backend : phymul::backend_names()) {
    std::printf("%s: %s\n", backend.c_str(), phymul::why_unavailable(backend).c_str());
  }
  return report.ok() ? 0 : 1;
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
