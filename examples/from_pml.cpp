// SPDX-License-Identifier: MIT
//
// A body from PML, what acts on it from LML, a film for ParaView: from_pml BODY.pml LOADS.lml [SECONDS]
#include <phymul/phymul.h>

#include <cstdio>
#include <string_view>

int main(int argc, char** argv) try {
  if (argc < 3) {
    std::puts("usage: from_pml BODY.pml LOADS.lml [SECONDS]");
    return argc == 2 && std::string_view(argv[1]) == "--help" ? 0 : 1;
  }
  const double seconds = argc > 3 ? std::atof(argv[3]) : 1.0;

  phymul::Simulation sim(phymul::read_pml(argv[1]),  // lengths in mm, unless PmlOptions says otherwise
                         {.material = {.young = 10e3, .poisson = 0.3, .density = 1000}, .damping = {.rate = 20}});
  for (const std::string& note : sim.model().notes) std::printf("note: %s\n", note.c_str());
  sim.scene().add(phymul::read_lml(argv[2], sim.model()));

  phymul::VtkSeries film("from_pml");
  film.write(sim.model(), sim.state());
  while (sim.time() < seconds - 1e-9) {                                       // times are sums of steps
    if (const phymul::StepReport report = sim.advance(0.01); !report.ok()) {  // 10 ms between two frames
      std::puts(report.message().c_str());
      return 1;
    }
    film.write(sim.model(), sim.state());
  }
  std::printf("%zu frames; the farthest particle moved %.2f mm; open from_pml.pvd\n", film.frames(),
              1e3 * sim.max_displacement());
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
