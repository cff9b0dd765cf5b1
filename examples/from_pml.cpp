// SPDX-License-Identifier: MIT
//
// A body from PML, what acts on it from LML, a film for ParaView: from_pml BODY.pml LOADS.lml [SECONDS]
#include <phymul/phymul.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::puts("usage: from_pml BODY.pml LOADS.lml [SECONDS]");
    return argc == 2 && std::string_view(argv[1]) == "--help" ? 0 : 1;
  }
  const double seconds = argc > 3 ? std::atof(argv[3]) : 1.0;

  phymul::Model model = phymul::read_pml(argv[1]);  // lengths in mm, unless PmlOptions says otherwise
  for (const std::string& note : model.notes) std::printf("note: %s\n", note.c_str());
  phymul::set_material(model, {.young = 10e3, .poisson = 0.3, .density = 1000});  // Pa, 1, kg/m^3

  phymul::Scene scene(model);
  scene.add(phymul::read_lml(argv[2], model));

  phymul::SolverOptions options;
  options.damping.rate = 20;  // 1/s
  const auto solver = phymul::make_solver("auto", model, scene, {}, options);

  // Frames 10 ms apart; the step is a whole part of that, and at most half of the stable one.
  constexpr double frame = 0.01;
  const int steps = static_cast<int>(frame / (0.5 * solver->stable_step())) + 1;
  phymul::VtkSeries film("from_pml");
  film.write(model, solver->read());
  for (double time = 0.0; time < seconds;) {
    const phymul::StepReport report = solver->step(steps, frame / steps);
    if (!report.ok()) {
      std::puts(report.message().c_str());
      return 1;
    }
    time = report.time;
    film.write(model, solver->read());
  }
  const phymul::DisplacementNorms moved = displacement_norms(model, solver->read());
  std::printf("%zu frames; the farthest particle moved %.2f mm; open from_pml.pvd\n", film.frames(), 1e3 * moved.max);
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
