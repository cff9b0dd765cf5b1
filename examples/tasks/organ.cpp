// SPDX-License-Identifier: MIT
//
// An organ from an STL file in millimetres, held from below, that a hand presses at 1 kHz through a virtual coupling.
// The hand is a formula here. docs/guide/tutorial.md explains it part by part.
#include <phymul/phymul.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

int main(int argc, char** argv) try {
  phymul::BodyReport report;
  const phymul::Surface surface = phymul::read_surface(argc > 1 ? argv[1] : "organ.stl", 1e-3);  // file in mm
  phymul::Model organ = phymul::make_body(surface, {.spacing = 0.01}, &report);                  // m
  for (const std::string& note : organ.notes) std::puts(note.c_str());
  std::printf("%d particles, %.1f ml\n", report.particles, 1e6 * report.volume);

  phymul::Vec3 low = organ.rest[0], high = low;
  for (const phymul::Vec3& at : organ.rest) low = low.cwiseMin(at), high = high.cwiseMax(at);
  const double fifth = low.z() + 0.2 * (high.z() - low.z());
  organ.add_group("held", organ.particles_in([&](const phymul::Vec3& at) { return at.z() < fifth; }));

  phymul::Simulation sim(organ,
                         {.material = {.young = 5e3, .poisson = 0.45, .density = 1050}, .damping = {.rate = 20}});
  sim.scene().fix("held");

  const phymul::Vec3 start(0.5 * (low.x() + high.x()), 0.5 * (low.y() + high.y()), high.z() + 0.015);
  const auto hand = [&](double time) {  // your device's pose
    return phymul::ToolPose{.position = start - phymul::Vec3(0, 0, 0.01 * time), .velocity = {0, 0, -0.01}};
  };
  phymul::VirtualCoupling coupling({}, hand(0.0));
  const auto probe = sim.scene().add_tool(
      {.shape = phymul::Sphere{.radius = 0.01}, .pose = hand(0.0), .contact = phymul::ToolContact::surface});

  sim.solver();       // made here: in the first tick it would be late
  double felt = 0.0;  // N
  int late = 0;
  auto next = std::chrono::steady_clock::now();
  for (int tick = 1; tick <= 1000; ++tick) {
    coupling.follow(hand(1e-3 * tick), sim.force_on(probe), 1e-3);
    probe.move_to(coupling.pose());
    if (const auto step = sim.advance(1e-3); !step.ok()) return std::puts(step.message().c_str()), 1;
    felt = std::max(felt, coupling.force().norm());  // coupling.force() is for your device's motors
    late += std::chrono::steady_clock::now() > (next += std::chrono::milliseconds(1));
    std::this_thread::sleep_until(next);
  }
  std::printf("at most %.2f N on the hand; %d of 1000 ticks were late\n", felt, late);

  phymul::write_vtu(sim.model(), sim.state(), "pressed.vtu");  // for ParaView
} catch (const phymul::Error& error) {
  return std::puts(error.what()), 1;
}
