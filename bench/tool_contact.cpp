// SPDX-License-Identifier: MIT
//
// What a tool feels that is pressed into an organ at places close together, with either ToolContact: how much the force
// depends on the place, how much it jumps as the tool slides, and what a tick costs. Backend cpu, one thread.
//   tool_contact [surface file in mm [spacing in mm [places a side]]]
#include <phymul/phymul.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "stopwatch.h"
#include "usage.h"

namespace {

using namespace phymul;

constexpr double tick = 1e-3;         // s
constexpr double apart = 1e-3;        // m, of places
constexpr double hand_speed = 0.1;    // m/s, down
constexpr double slide_speed = 0.02;  // m/s
const std::array<double, 5> depths{2e-3, 4e-3, 6e-3, 8e-3, 10e-3};

struct Probe {
  const char* name;
  ToolShape shape;
  double radius;
};
const std::array<Probe, 2> probes{
    {{"sphere of 10 mm", Sphere{0.010}, 0.010}, {"capsule of 5 mm", Capsule{0.005, 0.15}, 0.005}}};

/// A body on its flat side, whose lowest 4 mm are held.
struct Organ {
  Model model;
  std::vector<std::array<Index, 3>> triangles;
};

Organ make_organ(const std::string& file, double spacing) {
  const BodyOptions options{.spacing = spacing};
  Organ organ{file.empty() ? make_body(solid_ellipsoid({0, 0, 0}, {0.055, 0.035, 0.03}), options)
                           : make_body(read_surface(file, 1e-3), options),
              {}};
  set_material(organ.model, {.young = 5e3, .poisson = 0.45, .density = 1000});
  double low = HUGE_VAL;
  for (const Vec3& x : organ.model.rest) low = std::min(low, x.z());
  std::vector<Index> held;
  for (Index i = 0; i < organ.model.particle_count(); ++i) {
    if (organ.model.rest[i].z() < low + 4e-3) held.push_back(i);
  }
  organ.model.add_group("held", held);
  organ.triangles = surface_triangles(organ.model);
  return organ;
}

/// z of the lowest point of a ball that first touches the triangles from above, over (x, y).
double first_touch(const Organ& organ, double x, double y, double radius) {
  constexpr int parts = 8;
  double height = -HUGE_VAL;
  for (const auto& [a, b, c] : organ.triangles) {
    const VecList& rest = organ.model.rest;
    for (int i = 0; i <= parts; ++i) {
      for (int j = 0; i + j <= parts; ++j) {
        const Vec3 at = rest[a] + (rest[b] - rest[a]) * (1.0 * i / parts) + (rest[c] - rest[a]) * (1.0 * j / parts);
        const double aside = std::hypot(at.x() - x, at.y() - y);
        if (aside < radius) height = std::max(height, at.z() + std::sqrt(radius * radius - aside * aside) - radius);
      }
    }
  }
  return height;
}

class Hand {
 public:
  Hand(const Organ& organ, const Probe& probe, ToolContact contact) : scene_(organ.model) {
    scene_.fix("held").add_tool(
        "probe", {.shape = probe.shape, .pose = {.position = {0, 0, 1}}, .friction = 0.1, .contact = contact});
    SolverOptions options;
    options.threads = 1;
    options.damping.rate = 60.0;
    solver_ = make_solver("cpu", organ.model, scene_, {}, options);
    steps_ = static_cast<int>(std::ceil(tick / (0.5 * solver_->stable_step())));
  }

  void place(const Vec3& at) {
    solver_->reset();
    scene_.tool("probe").teleport({.position = at});
  }
  /// N, mean over a tick that ends at this place.
  double move(const Vec3& to) {
    scene_.tool("probe").move_to({.position = to});
    const double begin = processor_seconds();
    const StepReport report = solver_->step(steps_, tick / steps_);
    seconds_ += processor_seconds() - begin;
    ++ticks_;
    if (!report.ok()) throw Error(report.message());
    return solver_->tool_force("probe").mean_force.norm();
  }
  double press(Vec3& at, double by, int rest) {
    for (double left = by; left > 0.0; left -= hand_speed * tick) {
      at.z() -= std::min(left, hand_speed * tick);
      move(at);
    }
    double force = 0.0;
    for (int k = 0; k < rest; ++k) force = move(at);
    return force;
  }
  double ms_a_tick() {
    const double mean = 1e3 * seconds_ / ticks_;
    seconds_ = ticks_ = 0.0;
    return mean;
  }
  int steps() const { return steps_; }

 private:
  Scene scene_;
  std::unique_ptr<Solver> solver_;
  int steps_ = 0;
  double seconds_ = 0.0, ticks_ = 0.0;
};

void compare(const Organ& organ, const Probe& probe, ToolContact contact, int side, double from_x, double from_y) {
  std::printf("%s, %s\n", probe.name, contact == ToolContact::surface ? "surface" : "particles");
  Hand hand(organ, probe, contact);
  for (int k = 0; k < 50; ++k) hand.move({0, 0, 1});
  const double idle = hand.ms_a_tick();
  std::vector<std::array<double, depths.size()>> force;
  for (int place = 0; place < side * side; ++place) {
    const double x = from_x + apart * (place % side), y = from_y + apart * (place / side);
    Vec3 at(x, y, first_touch(organ, x, y, probe.radius) + probe.radius);
    hand.place(at);
    double depth = 0.0;
    force.emplace_back();
    for (std::size_t d = 0; d < depths.size(); ++d) {
      force.back()[d] = hand.press(at, depths[d] - depth, 100);
      depth = depths[d];
    }
  }
  const double pressed = hand.ms_a_tick();
  for (std::size_t d = 0; d < depths.size(); ++d) {
    double mean = 0.0, least = HUGE_VAL, most = 0.0, step = 0.0;
    for (int place = 0; place < side * side; ++place) {
      const double here = force[place][d];
      mean += here / (side * side);
      least = std::min(least, here);
      most = std::max(most, here);
      if (place % side > 0) step = std::max(step, std::abs(here - force[place - 1][d]));
      if (place >= side) step = std::max(step, std::abs(here - force[place - side][d]));
    }
    std::printf("  %4.0f mm deep: mean %.4f N, from %.4f to %.4f N, between places 1 mm apart at most %.1f %%\n",
                1e3 * depths[d], mean, least, most, 100.0 * step / mean);
  }
  Vec3 at(from_x, from_y, first_touch(organ, from_x, from_y, probe.radius) + probe.radius);
  hand.place(at);
  double before = hand.press(at, 4e-3, 100), jump = 0.0;
  for (int k = 1; k <= 120 * side; ++k) {
    const double x = from_x + slide_speed * tick * k;
    const double now = hand.move({x, from_y, at.z()});
    jump = std::max(jump, std::abs(now - before) / before);
    before = now;
  }
  std::printf("  sliding 4 mm deep: at most %.2f %% in a tick; a tick %.2f ms of the processor, pressed %.2f ms\n",
              100.0 * jump, idle, pressed);
  std::fflush(stdout);
}

/// Boxes that come by 3 mm in 30 ticks, and rest for 150. Each on its side of the body.
void press_flat(const char* name, const Model& body, const Vec3& half, const std::vector<double>& heights) {
  std::printf("%s, %d particles\n", name, body.particle_count());
  for (int contact = -1; contact <= 1; ++contact) {  // without tools, ToolContact
    Scene scene(body);
    scene.fix("held");
    const auto place = [](double height, double by) {
      return ToolPose{.position = {0, 0, height - std::copysign(by, height)}};
    };
    for (const double height : contact < 0 ? std::vector<double>{} : heights) {
      scene.add_tool(std::to_string(height), {.shape = Box{half},
                                              .pose = place(height, 0.0),
                                              .friction = 0.3,
                                              .contact = contact == 0 ? ToolContact::particles : ToolContact::surface});
    }
    SolverOptions options;
    options.threads = 1;
    options.damping.rate = 60.0;
    const auto solver = make_solver("cpu", body, scene, {}, options);
    const int steps = static_cast<int>(std::ceil(tick / (0.5 * solver->stable_step())));
    std::vector<double> seconds;
    for (int k = 1; k <= 180; ++k) {
      for (std::size_t row = 0; row < scene.tools().size(); ++row) {
        scene.tool(scene.tools()[row].name).move_to(place(heights[row], 1e-4 * std::min(k, 30)));
      }
      const double begin = processor_seconds();
      const StepReport report = solver->step(steps, tick / steps);
      seconds.push_back(processor_seconds() - begin);
      if (!report.ok()) throw Error(report.message());
    }
    std::printf("  %-9s: a tick %.3f ms",
                contact < 0    ? "no tool"
                : contact == 0 ? "particles"
                               : "surface",
                1e3 * median(seconds));
    if (contact >= 0) {
      std::printf(", force %.4f N", solver->tool_force(scene.tools().front().name).mean_force.norm());
    }
    std::printf("\n");
  }
}

void press_plates_and_jaws() {
  Model slab = make_tetrahedral_block({0.06, 0.06, 0.03}, 13, 13, 4, 0.2, 7);
  Model lobe = make_body(solid_ellipsoid({0, 0, 0}, {0.03, 0.04, 0.01}), {.spacing = 4.9e-3});
  std::vector<Index> bottom, end;
  for (Vec3& x : slab.rest) x -= Vec3(0.03, 0.03, 0.015);
  for (Index i = 0; i < slab.particle_count(); ++i) {
    if (slab.rest[i].z() < -0.0149) bottom.push_back(i);
  }
  for (Index i = 0; i < lobe.particle_count(); ++i) {
    if (lobe.rest[i].y() < -0.033) end.push_back(i);
  }
  slab.add_group("held", bottom);
  lobe.add_group("held", end);
  for (Model* body : {&slab, &lobe}) set_material(*body, {.young = 5e3, .poisson = 0.45, .density = 1000});
  press_flat("plate of 40 mm on a slab", slab, {0.02, 0.02, 0.005}, {0.0205});
  press_flat("plate of 80 mm on a slab", slab, {0.04, 0.04, 0.002}, {0.0175});
  press_flat("two jaws on a lobe", lobe, {0.01, 0.012, 0.002}, {0.0125, -0.0125});
  press_flat("two jaws of 1 mm on it", lobe, {0.01, 0.012, 0.0005}, {0.011, -0.011});
  set_material(lobe, {.young = 5e4, .poisson = 0.45, .density = 1000});
  press_flat("two jaws of 1 mm on ten times as stiff a lobe", lobe, {0.01, 0.012, 0.0005}, {0.011, -0.011});
}

/// Jaws that close on the tip of an ellipsoid for 0.4 s and hold it for 0.2 s.
void hold_with_jaws() {
  Model body = make_body(solid_ellipsoid({0, 0, 0}, {0.06, 0.03, 0.02}), {.spacing = 6.5e-3});
  set_material(body, {.young = 5e3, .poisson = 0.45, .density = 1000});
  std::vector<Index> held;
  for (Index i = 0; i < body.particle_count(); ++i) {
    if (body.rest[i].x() < -0.03) held.push_back(i);
  }
  std::printf("jaws of 20 by 24 mm on the tip of an ellipsoid, %d particles\n", body.particle_count());
  Mat3 axes;  // from the jaws': they come along -x and open along z
  axes << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const ToolPose hinge{.position = {0.068, 0, 0}, .orientation = Quaternion(axes)};
  const auto hold = [&](const char* name, ToolContact contact, double thickness, bool closes) {
    Simulation sim(body, {.backend = "cpu", .damping = {.rate = 50.0}, .solver = {.threads = 1}});
    sim.scene().fix(held);
    Jaws jaws(sim.scene(), "jaws",
              {.length = 0.024,
               .width = 0.02,
               .thickness = thickness,
               .contact = contact,
               .friction = 0.8,
               .grip = 1.0,
               .opening = 1.2,
               .speed = 2.0},
              hinge);
    if (closes) jaws.close();
    std::vector<double> seconds;
    int steps = 0;
    for (int k = 0; k < 600; ++k) {
      jaws.follow(hinge, sim.force_on(jaws.first()), sim.force_on(jaws.second()), tick);
      const double begin = processor_seconds();
      const StepReport report = sim.advance(tick);
      if (!report.ok()) throw Error(report.message());
      if (k < 400) continue;
      seconds.push_back(processor_seconds() - begin);
      steps += report.steps;
    }
    std::printf("  %-22s: a tick %.3f ms, %.1f steps, grip %.3f N\n", name, 1e3 * median(seconds), steps / 200.0,
                jaws.grip());
  };
  hold("open", ToolContact::surface, 0.006, false);
  hold("surface, 1 mm thick", ToolContact::surface, 0.001, true);
  hold("surface, 2 mm", ToolContact::surface, 0.002, true);
  hold("surface, 6 mm", ToolContact::surface, 0.006, true);
  hold("surface, 12 mm", ToolContact::surface, 0.012, true);
  hold("particles, 6 mm", ToolContact::particles, 0.006, true);
}

}  // namespace

int main(int argc, char** argv) try {
  if (bench::prints_usage(
          argc, argv,
          "tool_contact [surface file in mm [spacing in mm [places a side]]], default an ellipsoid, 6 "
          "and 5\nForce on tools at places 1 mm apart, sliding, and the cost of a tick; then plates and jaws.")) {
    return 0;
  }
  const std::string file = argc > 1 ? argv[1] : "";
  const double spacing = argc > 2 ? 1e-3 * std::atof(argv[2]) : 6e-3;
  const int side = argc > 3 ? std::max(1, std::atoi(argv[3])) : 5;
  const Organ organ = make_organ(file, spacing);
  std::printf("%d particles, %zu triangles\n", organ.model.particle_count(), organ.triangles.size());
  for (const Probe& probe : probes) {
    for (const ToolContact contact : {ToolContact::particles, ToolContact::surface}) {
      compare(organ, probe, contact, side, 0.0, 5e-3);
    }
  }
  press_plates_and_jaws();
  hold_with_jaws();
  return 0;
} catch (const phymul::Error& error) {
  std::puts(error.what());
  return 1;
}
