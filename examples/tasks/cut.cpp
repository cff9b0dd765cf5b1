// SPDX-License-Identifier: MIT
//
// A slab under traction is cut half through while it moves; then a lump is taken out beside the cut.
#include <phymul/bodies.h>
#include <phymul/phymul.h>

#include <cstdio>

int main() try {
  phymul::SimulationOptions options;
  options.damping.rate = 10.0;
  phymul::Model slab = phymul::make_tetrahedral_block({0.1, 0.1, 0.05}, 12, 12, 6, 0.2, 1);
  set_material(slab, {.young = 10e3, .poisson = 0.45, .density = 1000});
  phymul::Simulation sim(with_spare_particles(std::move(slab), 200), options);
  phymul::Load pull;
  pull.type = phymul::LoadType::translation;
  pull.particles = sim.model().group("x1");
  pull.direction = {1, 0, 0};
  pull.events = {{0.0, 0.0}, {0.2, 0.01}};  // m at s
  sim.scene().fix("x0").add(pull);
  if (!sim.advance(0.3).ok()) return 1;

  phymul::CutSurface cut = phymul::cut_plane({0.05, 0, 0}, {1, 0, 0});
  cut.front = [](const phymul::Vec3& x) { return x.y() - 0.05; };
  sim.cut(cut);
  if (!sim.advance(0.5).ok()) return 1;

  const phymul::VecList after = sim.solver().read().position;
  double opening = 0.0;  // m, of what lay at one place before
  for (const phymul::BodyCut::Copy& copy : sim.cuts().back()->copies) {
    opening = std::max(opening, (after[copy.particle] - after[copy.of]).norm());
  }
  std::printf("cut: %zu spare particles used, the mouth opens by %.1f mm\n", sim.cuts().back()->copies.size(),
              1e3 * opening);

  const phymul::VecList now = sim.solver().read().position;
  sim.remove_cells(sim.model().cells_in(
      [](const phymul::Vec3& x) { return (x - phymul::Vec3(0.08, 0.0, 0.025)).norm() < 0.02; }, now));
  if (!sim.advance(0.3).ok()) return 1;
  std::printf("%zu cells removed: %.0f ml are left, in %zu piece(s)\n", sim.removed_cells().size(),
              1e6 * volume(sim.model(), sim.model().rest), connected_bodies(sim.model()).size());
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
