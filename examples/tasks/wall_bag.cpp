// SPDX-License-Identifier: MIT
//
// A thin bag of fluid, held below and pressed from above: it bulges, pushes back and keeps its volume.
#include <phymul/phymul.h>

#include <cmath>
#include <cstdio>

int main() try {
  const double radius = 0.03;  // m
  const phymul::Model ball = phymul::make_body(phymul::solid_ball({0, 0, 0}, radius), {.spacing = 5e-3});
  const phymul::Surface surface{.vertices = ball.rest, .triangles = phymul::surface_triangles(ball), .notes = {}};
  const phymul::Material wall{.young = 50e3, .poisson = 0.45, .density = 1050, .thickness = 2e-3};
  phymul::Model bag = phymul::make_wall(surface, {.material = wall});
  bag.add_group("below", bag.particles_in([&](const phymul::Vec3& place) { return place.z() < -0.8 * radius; }));

  const auto triangles = phymul::surface_triangles(bag);
  const auto volume_at = [&](const phymul::VecList& x) {
    double volume = 0.0;
    for (const auto& [a, b, c] : triangles) volume += x[a].dot(x[b].cross(x[c])) / 6.0;
    return volume;
  };
  const double full = volume_at(bag.rest);

  phymul::Simulation sim(bag, {.damping = {.rate = 20}});
  sim.scene().fix("below").constrain_volume({.triangles = triangles, .volume = full, .applied_to = "bag"});
  const auto probe =
      sim.scene().add_tool({.shape = phymul::Sphere{.radius = 0.012}, .pose = {.position = {0, 0, radius + 0.013}}});
  probe.move_to({.position = {0, 0, radius + 0.004}});
  const phymul::StepReport report = sim.advance(0.5);
  if (!report.ok()) {
    std::puts(report.message().c_str());
    return 1;
  }
  const double change = volume_at(sim.state().position) / full - 1.0, force = sim.force_on(probe).force.norm();
  std::printf("%d particles, largest displacement %.1f mm, force on the probe %.2f N, change of volume %.1e\n",
              bag.particle_count(), 1e3 * sim.max_displacement(), force, change);
  return force > 0.02 && std::abs(change) < 1e-6 ? 0 : 1;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
