// SPDX-License-Identifier: MIT
//
// A slab under traction is cut half through while it moves; then a lump is taken out beside the cut.
#include <phymul/bodies.h>
#include <phymul/phymul.h>

#include <cstdio>

namespace {

void hold(phymul::Simulation& sim) {
  phymul::Load pull;
  pull.type = phymul::LoadType::translation;
  pull.particles = sim.model().group("x1");
  pull.direction = {1, 0, 0};
  pull.events = {{0.0, 0.0}, {0.2, 0.01}};  // m at s
  sim.scene().fix("x0").add(pull);
}

}  // namespace

int main() try {
  phymul::SimulationOptions options;
  options.damping.rate = 10.0;
  phymul::Model slab = phymul::make_tetrahedral_block({0.1, 0.1, 0.05}, 12, 12, 6, 0.2, 1);
  set_material(slab, {.young = 10e3, .poisson = 0.45, .density = 1000});
  phymul::Simulation whole(std::move(slab), options);
  hold(whole);
  if (!whole.advance(0.3).ok()) return 1;

  phymul::CutSurface cut = phymul::cut_plane({0.05, 0, 0}, {1, 0, 0});
  cut.front = [](const phymul::Vec3& x) { return x.y() - 0.05; };
  std::vector<phymul::Index> copies;
  phymul::Simulation sim(cut_body(whole.model(), cut, &copies), options);
  hold(sim);
  phymul::State state = whole.state();
  for (const phymul::Index i : copies) {
    state.position.push_back(phymul::Vec3(state.position[i]));
    state.velocity.push_back(phymul::Vec3(state.velocity[i]));
  }
  sim.set_state(state);
  if (!sim.advance(0.5).ok()) return 1;
  const auto opening = [&] {
    double least = 1.0, most = 0.0;  // m, along x, of what lay in the plane at the mouth of the cut
    for (phymul::Index i = 0; i < sim.model().particle_count(); ++i) {
      const phymul::Vec3& X = sim.model().rest[i];
      if (std::abs(X.x() - 0.05) > 0.005 || X.y() > 0.001) continue;
      const double moved = sim.solver().read().position[i].x() - X.x();
      least = std::min(least, moved);
      most = std::max(most, moved);
    }
    return most - least;
  };
  std::printf("cut: %zu particles more, the mouth opens by %.1f mm\n", copies.size(), 1e3 * opening());

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
