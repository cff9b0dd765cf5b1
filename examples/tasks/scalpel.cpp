// SPDX-License-Identifier: MIT
//
// A scalpel goes into a slab from its side and out at the other end. The tissue first goes with the edge; then it
// parts.
#include <phymul/bodies.h>
#include <phymul/phymul.h>

#include <cstdio>

int main() try {
  phymul::Model slab = phymul::make_tetrahedral_block({0.06, 0.04, 0.02}, 12, 8, 4, 0.2, 1);
  set_material(slab, {.young = 10e3, .poisson = 0.45, .density = 1000});
  phymul::SimulationOptions options;
  options.damping.rate = 20.0;
  phymul::Simulation sim(with_spare_particles(std::move(slab), 400), options);
  sim.scene().fix("z0");

  // The edge, 20 mm long, stands upright in the plane y = 20 mm, its lower end 5 mm above the base: it cuts toward -x.
  phymul::Mat3 axes;
  axes << 0, 0, 1, 0, -1, 0, 1, 0, 0;
  phymul::ToolPose pose{.position = {0.062, 0.0205, 0.015},
                        .orientation = phymul::Quaternion(Eigen::Quaterniond(axes))};
  const auto scalpel =
      sim.scene().add_tool("scalpel", {.shape = phymul::Blade{.width = 0.02, .toughness = 20.0}, .pose = pose});
  for (int ms = 1; ms <= 1300; ++ms) {
    pose.position.x() -= 0.05e-3;
    scalpel.move_to(pose);
    const phymul::StepReport report = sim.advance(1e-3);
    if (!report.ok() || report.uncut > 0) return 1;
    if (ms % 130 != 0) continue;
    std::size_t cells = 0;
    for (const auto& cut : sim.cuts()) cells += cut->added.size();
    std::printf("%4.1f mm: %.2f N, %zu cells are cut\n", 1e3 * pose.position.x(), sim.force_on(scalpel).mean_force.x(),
                cells);
  }
  return connected_bodies(sim.model()).size() == 1 ? 0 : 1;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
