// SPDX-License-Identifier: MIT
//
// A block of tissue vibrates and falls: what it dissipates is its vibration, not its fall.
#include <phymul/phymul.h>

#include <cmath>
#include <cstdio>
#include <numbers>

int main() try {
  const double loss_factor = 0.3, frequency = 20.0;  // Hz, at which it was measured
  phymul::Material tissue{.young = 5e3, .poisson = 0.45, .density = 1050};
  tissue.retardation_time = loss_factor / (2.0 * std::numbers::pi * frequency);
  tissue.relaxation_strength = 0.5;  // a sudden strain meets 1.5 times the stress that remains,
  tissue.relaxation_time = 1.0;      // s, and the difference decays with this time
  phymul::Simulation sim(phymul::make_block({0.06, 0.03, 0.03}, 6, 3, 3), {.material = tissue, .backend = "cpu"});
  sim.scene().gravity({0, 0, -9.81});

  phymul::State start = phymul::rest_state(sim.model());
  for (std::size_t i = 0; i < start.position.size(); ++i) start.velocity[i].x() = 4.0 * (start.position[i].x() - 0.03);
  sim.set_state(start);
  double mass = 0.0;
  for (const double m : sim.model().mass) mass += m;
  const auto vibration = [&] {  // J: the kinetic energy without that of the fall
    const phymul::State now = sim.state();
    const phymul::Vec3 fall = sim.solver().momentum().linear / mass;
    double energy = 0.0;
    for (std::size_t i = 0; i < now.velocity.size(); ++i) {
      energy += 0.5 * sim.model().mass[i] * (now.velocity[i] - fall).squaredNorm();
    }
    return energy;
  };
  const double before = vibration();
  const phymul::StepReport report = sim.advance(0.5);
  if (!report.ok()) {
    std::puts(report.message().c_str());
    return 1;
  }
  const double left = vibration() / before, fall = -sim.solver().momentum().linear.z() / mass;
  std::printf("after 0.5 s: %.3f %% of the vibration is left; falls at %.3f m/s\n", 100.0 * left, fall);
  return left < 0.01 && std::abs(fall - 0.5 * 9.81) < 0.01 ? 0 : 1;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
