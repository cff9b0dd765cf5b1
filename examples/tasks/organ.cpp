// SPDX-License-Identifier: MIT
//
// An organ from an STL file in millimetres: filled, held from below, and pressed by a probe in a loop at 1 kHz.
#include <phymul/phymul.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

int main(int argc, char** argv) try {
  phymul::BodyReport report;
  const phymul::Surface surface = phymul::read_surface(argc > 1 ? argv[1] : "organ.stl", 1e-3);
  phymul::Model organ = phymul::make_body(surface, {.spacing = 0.01}, &report);
  for (const std::string& note : organ.notes) std::puts(note.c_str());
  std::printf("%d particles, %.1f ml\n", report.particles, 1e6 * report.volume);

  std::vector<phymul::Index> held;
  for (const phymul::Index i : organ.group("surface")) {
    if (organ.rest[i].z() < -0.02) held.push_back(i);
  }
  organ.add_group("held", held);
  phymul::Simulation sim(organ,
                         {.material = {.young = 5e3, .poisson = 0.45, .density = 1050}, .damping = {.rate = 20}});
  sim.scene().fix("held");
  const auto probe =
      sim.scene().add_tool({.shape = phymul::Sphere{.radius = 0.01}, .pose = {.position = {0, 0, 0.045}}});
  double felt = 0.0;  // N
  auto next = std::chrono::steady_clock::now();
  for (int tick = 0; tick < 1000; ++tick) {
    probe.move_to({.position = {0, 0, 0.045 - 1e-5 * tick}});
    if (const auto step = sim.advance(1e-3); !step.ok()) return std::puts(step.message().c_str()), 1;
    felt = std::max(felt, sim.force_on(probe).force.norm());
    std::this_thread::sleep_until(next += std::chrono::milliseconds(1));
  }
  std::printf("at most %.2f N on the probe\n", felt);
} catch (const phymul::Error& error) {
  return std::puts(error.what()), 1;
}
