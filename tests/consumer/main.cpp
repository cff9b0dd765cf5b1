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
  bool all_ok = report.ok();
  for (const std::string& backend : phymul::backend_names()) {
    const std::string reason = phymul::why_unavailable(backend);
    if (reason.empty()) {
      const auto own = phymul::make_solver(backend, model, scene);
      const phymul::StepReport own_report = own->step(10, 0.25 * own->stable_step());
      all_ok = all_ok && own_report.ok();
      std::printf("%s: %d steps\n", backend.c_str(), own_report.steps);
    } else {
      std::printf("%s: %s\n", backend.c_str(), reason.c_str());
    }
  }
  return all_ok ? 0 : 1;
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
