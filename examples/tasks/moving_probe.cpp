// SPDX-License-Identifier: MIT
//
// A probe is pressed into an organ and moved over it by 5 cm, in ticks of 1 ms. The organ is fine near the probe only:
// while it runs, another thread fills it anew around the place ahead, and the new body takes over its state.
#include <phymul/phymul.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <future>
#include <optional>
#include <thread>
#include <utility>

namespace {

const phymul::Solid organ = phymul::solid_ellipsoid({0, 0, 0}, {0.09, 0.06, 0.04});

phymul::Simulation simulation_around(const phymul::Vec3& place) {
  phymul::Model body =
      phymul::make_body(organ, {.spacing = 0.024, .spacing_at = phymul::fine_near(place, 0.012, 0.006, 0.024)});  // m
  body.add_group("held", body.particles_in([](const phymul::Vec3& x) { return x.z() < -0.02; }));
  phymul::Simulation sim(std::move(body), {.material = {.young = 5e3, .poisson = 0.45, .density = 1050},
                                           .backend = "cpu",
                                           .damping = {.rate = 60},
                                           .solver = {.threads = 1}});
  sim.scene().fix("held").add_tool("probe",
                                   {.shape = phymul::Sphere{.radius = 0.008}, .contact = phymul::ToolContact::surface});
  sim.advance(0.0);  // all that a step needs is made here, in the thread that has time
  return sim;
}

struct Next {
  phymul::Simulation sim;
  phymul::StateTransfer transfer;  // from the body before
};

/// Of the probe's middle, pressed in by 3 mm, at a share of the way.
phymul::Vec3 place_at(double share) {
  const double x = -0.025 + 0.05 * share;
  return {x, 0.0, 0.04 * std::sqrt(1.0 - std::pow(x / 0.09, 2)) + 0.005};
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

int main() try {
  constexpr int ticks = 1000;
  constexpr double ahead = 0.15, least_move = 0.25;  // of the way: a new body for every quarter
  phymul::Simulation sim = simulation_around(place_at(0.0));
  std::optional<phymul::Simulation> old;  // until the other thread has time to take it apart
  std::future<Next> next;
  double last_force = 0.0, largest_jump = 0.0, largest_change = 0.0;  // N, N, share
  double longest = 0.0, longest_with_change = 0.0;                    // s, of ticks
  double filled_at = 0.0;                                             // share of the way
  int rebuilds = 0;
  phymul::Index most = sim.model().particle_count();
  sim.scene().tool("probe").teleport({.position = place_at(0.0)});
  if (!sim.advance(0.3).ok()) return 1;
  auto due = std::chrono::steady_clock::now();
  for (int tick = 1; tick <= ticks; ++tick) {
    const double share = static_cast<double>(tick) / ticks, place_ahead = std::min(1.0, share + ahead);
    // A future that is replaced while it is not ready waits for its thread.
    if (!next.valid() && place_ahead - filled_at >= least_move) {
      filled_at = place_ahead;
      next = std::async(std::launch::async, [&model = sim.model(), place_ahead, &old] {
        old.reset();
        phymul::Simulation finer = simulation_around(place_at(place_ahead));
        phymul::StateTransfer transfer(model, finer.model());
        return Next{std::move(finer), std::move(transfer)};
      });
    }
    auto begin = std::chrono::steady_clock::now();
    double seconds = 0.0;
    const bool takes_over = next.valid() && next.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    if (takes_over) {
      Next made = next.get();
      // Velocities of half a step before: state() and set_state() would evaluate the forces for those of the state's
      // time.
      phymul::State state = made.transfer(sim.solver().read());
      // Both bodies have the same spacing below the probe, so the probe keeps pressing.
      for (phymul::ToolState& tool : state.tools) tool.placed = false;
      made.sim.unrecorded_solver().reset(state);
      old = std::exchange(sim, std::move(made.sim));
      ++rebuilds;
      seconds = seconds_since(begin);
      largest_change = std::max(largest_change, std::abs(sim.energy().elastic / old->energy().elastic - 1.0));
      most = std::max(most, sim.model().particle_count());
      begin = std::chrono::steady_clock::now();
    }
    const auto probe = sim.scene().tool("probe");
    probe.move_to({.position = place_at(share)});
    if (const auto step = sim.advance(1e-3); !step.ok()) return std::puts(step.message().c_str()), 1;
    const double force = sim.force_on(probe).force.norm();
    double& longest_so_far = takes_over ? longest_with_change : longest;
    longest_so_far = std::max(longest_so_far, seconds + seconds_since(begin));
    if (takes_over) largest_jump = std::max(largest_jump, std::abs(force - last_force));
    last_force = force;
    due += std::chrono::milliseconds(1);
    std::this_thread::sleep_until(due);
  }
  std::printf("%d bodies of at most %d particles; %.2f N on the probe at the end\n", rebuilds + 1, most, last_force);
  std::printf("where a body took over: force changed by at most %.3f N, elastic energy by at most %.1f %%\n",
              largest_jump, 100.0 * largest_change);
  std::printf("longest tick %.2f ms, with a change of the body %.2f ms\n", 1e3 * longest, 1e3 * longest_with_change);
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
