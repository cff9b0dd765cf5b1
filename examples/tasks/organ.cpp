// SPDX-License-Identifier: MIT
//
// An organ from an STL file in millimetres: filled, held from below, and pressed from above in a loop at 1 kHz.
#include <phymul/phymul.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

int main(int argc, char** argv) try {
  phymul::BodyReport report;
  const phymul::Surface surface = phymul::read_surface(argc > 1 ? argv[1] : "organ.stl", 1e-3);  // file in mm
  phymul::Model organ = phymul::make_body(surface, {.spacing = 0.01}, &report);                  // m; suits the file
  for (const std::string& note : organ.notes) std::puts(note.c_str());
  std::printf("%d particles, %.1f ml\n", report.particles, 1e6 * report.volume);

  phymul::Vec3 low = organ.rest[0], high = low;
  for (const phymul::Vec3& at : organ.rest) low = low.cwiseMin(at), high = high.cwiseMax(at);
  std::vector<phymul::Index> held;
  for (const phymul::Index i : organ.group("surface")) {
    if (organ.rest[i].z() < low.z() + 0.2 * (high.z() - low.z())) held.push_back(i);
  }
  if (held.empty()) return std::puts("no particle of the surface is in the body's lowest fifth"), 1;
  organ.add_group("held", held);
  phymul::Simulation sim(organ,
                         {.material = {.young = 5e3, .poisson = 0.45, .density = 1050}, .damping = {.rate = 20}});
  sim.scene().fix("held");
  const phymul::Vec3 start(0.5 * (low.x() + high.x()), 0.5 * (low.y() + high.y()), high.z() + 0.015);
  const auto probe = sim.scene().add_tool({.shape = phymul::Sphere{.radius = 0.01}, .pose = {.position = start}});
  double felt = 0.0;  // N
  int late = 0;
  sim.solver();  // made here: in the first tick it would be late
  auto next = std::chrono::steady_clock::now();
  for (int tick = 0; tick < 1000; ++tick) {
    probe.move_to({.position = start - phymul::Vec3(0, 0, 1e-5 * tick)});
    if (const auto step = sim.advance(1e-3); !step.ok()) return std::puts(step.message().c_str()), 1;
    felt = std::max(felt, sim.force_on(probe).force.norm());
    late += std::chrono::steady_clock::now() > (next += std::chrono::milliseconds(1));
    std::this_thread::sleep_until(next);
  }
  std::printf("at most %.2f N on the probe; %d of 1000 ticks were late\n", felt, late);
} catch (const phymul::Error& error) {
  return std::puts(error.what()), 1;
}
