// SPDX-License-Identifier: MIT
//
// The first part of probe_on_prostate: a probe of 2 cm presses by 1 cm, stays and goes back.
#include <algorithm>
#include <cmath>

#include "prostate.h"
#include "scene_picture.h"

namespace {

using phymul::Vec3;

constexpr double radius = 0.010, length = 0.030, press = 0.010, gap = 0.001;  // m
constexpr double tick = 2e-3;                                                 // s

struct Motion {
  double speed, rest;  // m/s, s
  double down() const { return (press + gap) / speed; }
  double all() const { return 2.0 * down() + rest + 0.1; }
  double depth(double time) const {
    const double in = std::min(time, down()), out = std::clamp(time - down() - rest, 0.0, down());
    return speed * (in - out) - gap;
  }
};

}  // namespace

void press_with_probe(const Prostate& prostate, const ExampleOptions& options) {
  const Motion motion{options.quick ? 0.08 : 0.025, options.quick ? 0.05 : 0.3};
  const double skin =
      prostate.shape.shell_shift.y() - prostate.shape.semi_axes.y() - prostate.shape.shell;  // m, y of the outer side
  const auto pose_at = [&](double time) {
    return phymul::ToolPose{.position = Vec3(0.0, skin - radius + motion.depth(time), -0.5 * length)};
  };
  phymul::Simulation sim = prostate.simulation();
  const phymul::Capsule shape{radius, length};
  const auto probe = sim.scene().add_tool({.shape = shape, .pose = pose_at(0.0), .friction = 0.1, .margin = 0.0005});
  const BodyPoint centre(prostate.model, Vec3::Zero());

  const ScenePictures pictures(prostate.model, prostate.half(-Vec3::UnitX()), prostate.model.group("surface"));
  ScenePictureOptions sheet;
  sheet.full_scale = press;
  sheet.eye = Vec3(1.0, -0.25, 0.2);
  sheet.held = prostate.held;
  sheet.frame = prostate.model.rest;
  sheet.frame.push_back({0.0, skin - 2.0 * radius - gap, 0.0});
  sheet.key = {{KeyEntry::Mark::line, organ_colour, "gland"}};
  const auto draw = [&](const std::string& title, const std::string& subtitle, const std::string& file) {
    sheet.title = title;
    sheet.subtitle = subtitle;
    sheet.tools = {{shape, sim.pose_of(probe), probe_colour, "probe, 20 mm"}};
    pictures.draw(sim.state(), sheet, options.file(file));
  };
  draw("1. Gland of 30 kPa in tissue of 4 kPa", "cut open in the middle; front at the right, probe behind",
       "prostate_probe_1.png");

  Curve curve(options.file("prostate_probe.csv"), "time_s,depth_mm,force_N,gland_moved_mm");
  double largest = 0.0, half_way = 0.0, moved = 0.0, force = 0.0;
  bool drawn = false;
  for (double time = 0.0; time < motion.all();) {
    probe.move_to(pose_at(time + tick));
    time = advance(sim, tick);
    force = -sim.force_on(probe).mean_force.y();
    const double gland = (centre.now(sim.state()) - centre.rest()).y();
    curve.add({time, 1e3 * motion.depth(time), force, 1e3 * gland});
    largest = std::max(largest, force);
    if (motion.depth(time) < 0.5 * press && time < motion.down()) half_way = force;
    if (!drawn && time > motion.down() + motion.rest - 0.5 * tick) {
      drawn = true;
      moved = gland;
      draw("2. The probe is 10 mm in",
           text("%.1f N on it; the gland's middle has moved %.1f mm to the front", force, 1e3 * moved),
           "prostate_probe_2.png");
    }
  }
  const double left = (centre.now(sim.state()) - centre.rest()).norm();
  std::printf("probe: %.2f N at 5 mm, at most %.2f N; the gland moved %.2f mm, and %.3f mm are left after it\n",
              half_way, largest, 1e3 * moved, 1e3 * left);
  require(half_way > 0.0 && largest > 1.5 * half_way, "the force does not rise with the depth");
  require(moved > 0.1 * press && moved < press, "the gland does not move along with the probe");
  require(std::abs(force) < 0.01 * largest && left < 0.1 * moved, "the body does not come back");
}
