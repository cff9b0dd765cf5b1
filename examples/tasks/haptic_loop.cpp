// SPDX-License-Identifier: MIT
//
// A haptic loop at 1 kHz: a probe on a virtual coupling presses a block of tissue. The device is a formula here.
#include <phymul/phymul.h>

#include <algorithm>
#include <cstdio>

namespace {

struct Device {
  double time = 0.0, felt = 0.0;  // s, N
  phymul::ToolPose pose() const { return {.position = {0.03, 0.03, 0.045 - 0.02 * time}, .velocity = {0, 0, -0.02}}; }
  void send(const phymul::Vec3& force, const phymul::Vec3&) {
    felt = std::max(felt, force.norm());
    time += 1e-3;
  }
};

int fail(const std::string& message) {
  std::puts(message.c_str());
  return 1;
}

}  // namespace

int main() try {
  const phymul::Model model = phymul::make_block({0.06, 0.06, 0.04}, 6, 6, 4);
  const phymul::Material soft{.young = 10e3, .poisson = 0.45, .density = 1000};
  Device device;

  phymul::Simulation sim(model, {.material = soft, .damping = {.rate = 20}});
  sim.scene().fix("z0");
  phymul::VirtualCoupling coupling({}, device.pose());  // CouplingOptions: all defaults
  const auto probe = sim.scene().add_tool({.shape = phymul::Capsule{.radius = 8e-3, .length = 0.1},
                                           .pose = device.pose(),
                                           .contact = phymul::ToolContact::surface});

  while (device.time < 0.5) {  // 1 kHz
    coupling.follow(device.pose(), sim.force_on(probe), 1e-3);
    probe.move_to(coupling.pose());
    if (const auto report = sim.advance(1e-3); !report.ok()) return fail(report.message());
    device.send(coupling.force(), coupling.torque());  // N, N m, limited by CouplingOptions
  }
  std::printf("at most %.2f N on the hand\n", device.felt);
  return device.felt > 0.01 ? 0 : 1;
} catch (const phymul::Error& error) {
  return fail(error.what());
}
