// SPDX-License-Identifier: MIT
//
// A probe is pressed into an organ and moved over it by 5 cm. The organ is fine near the probe only: another thread
// fills it anew around the place ahead while it runs, and takes over its state.
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <future>

namespace {

const phymul::Solid organ = phymul::solid_ellipsoid({0, 0, 0}, {0.09, 0.06, 0.04});

phymul::Simulation simulation_around(const phymul::Vec3& place) {
  phymul::Model body =
      phymul::make_body(organ, {.spacing = 0.016, .spacing_at = phymul::fine_near(place, 0.012, 0.004, 0.016)});  // m
  body.add_group("held", body.particles_in([](const phymul::Vec3& x) { return x.z() < -0.02; }));
  phymul::Simulation sim(
      std::move(body),
      {.material = {.young = 5e3, .poisson = 0.45, .density = 1050}, .backend = "cpu", .damping = {.rate = 60}});
  sim.scene().fix("held").add_tool("probe", {.shape = phymul::Sphere{.radius = 0.008}});
  sim.solver();  // made here, in the thread that has time
  return sim;
}

/// Of the probe's middle, pressed in by 3 mm, at a share of the way.
phymul::Vec3 place_at(double share) {
  const double x = -0.025 + 0.05 * share;
  return {x, 0.0, 0.04 * std::sqrt(1.0 - std::pow(x / 0.09, 2)) + 0.005};
}

}  // namespace

int main() try {
  constexpr int ticks = 400, away = 40, ready = 64;  // a new body every 1/4 of the way
  phymul::Simulation sim = simulation_around(place_at(0.0));
  std::future<phymul::Simulation> next;
  double last_force = 0.0, largest_jump = 0.0, largest_change = 0.0;  // N, N, share
  int rebuilds = 0;
  phymul::Index most = sim.model().particle_count();
  sim.scene().tool("probe").teleport({.position = place_at(0.0)});
  if (!sim.advance(0.3).ok()) return 1;
  for (int tick = 1; tick <= ticks; ++tick) {
    const int since = tick % (ticks / 4);
    if (since == away) {
      const double ahead = std::min(1.0, static_cast<double>(tick + 60) / ticks);
      next = std::async(std::launch::async, simulation_around, place_at(ahead));
    }
    if (since == ready) {  // an application would ask next.wait_for(), and go on while it is not ready
      phymul::Simulation finer = next.get();
      finer.set_state(phymul::transfer_state(sim.model(), sim.state(), finer.model()));
      const double before = sim.energy().elastic, after = finer.energy().elastic;
      largest_change = std::max(largest_change, std::abs(after / before - 1.0));
      sim = std::move(finer);
      most = std::max(most, sim.model().particle_count());
      ++rebuilds;
    }
    const auto probe = sim.scene().tool("probe");
    probe.move_to({.position = place_at(static_cast<double>(tick) / ticks)});
    if (const auto step = sim.advance(1e-3); !step.ok()) return std::puts(step.message().c_str()), 1;
    const double force = sim.force_on(probe).force.norm();
    if (since == ready) largest_jump = std::max(largest_jump, std::abs(force - last_force));
    last_force = force;
  }
  std::printf("%d bodies of at most %d particles; %.2f N on the probe at the end\n", rebuilds + 1, most, last_force);
  std::printf("where a body took over: force changed by at most %.3f N, elastic energy by at most %.1f %%\n",
              largest_jump, 100.0 * largest_change);
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
