// SPDX-License-Identifier: MIT
//
// two_organs [--out DIR] [--quick]: a soft round organ lies on a stiffer flat one. A round probe presses it from above,
// a needle goes into it from the side, and both go away again. Writes their forces (two_organs.csv) and pictures.
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>

#include "ellipsoid_body.h"
#include "example_run.h"
#include "scene_picture.h"

namespace {

using phymul::Model;
using phymul::Vec3;

constexpr double radius = 0.012, press = 0.010;  // m
constexpr double tick = 2e-3;                    // s
constexpr double bed = 0.020, high = 0.016;      // m: the flat organ's thickness, the round one's semi-axis

/// Times of what happens, s.
struct Plan {
  explicit Plan(bool quick) : move(quick ? 0.12 : 0.4), settle(quick ? 0.15 : 0.4), hold(quick ? 0.05 : 0.2) {}
  double move, settle, hold;
  double needle() const { return settle + move + hold; }  ///< it starts
  double in() const { return needle() + move; }
  double back() const { return in() + hold; }  ///< both go
  double end() const { return back() + move + hold; }
  /// From 0 to 1 within `move` from `begin` on, and back from back() on.
  double share(double time, double begin) const {
    return std::clamp((time - begin) / move, 0.0, 1.0) - std::clamp((time - back()) / move, 0.0, 1.0);
  }
};

Model flat_organ(bool quick) {
  const int fine = quick ? 1 : 2;
  return phymul::moved(phymul::make_block({0.100, 0.080, bed}, 10 * fine, 8 * fine, 2 * fine), {-0.050, -0.040, -bed});
}

Model round_organ(bool quick) {
  const EllipsoidShape shape{
      .semi_axes = Vec3(0.032, 0.024, high), .core = quick ? 4 : 6, .organ_layers = quick ? 1 : 2};
  return phymul::moved(make_ellipsoid(shape), {0.0, 0.0, high + 0.001});
}

void run(const ExampleOptions& options) {
  const Plan plan(options.quick);
  const double top = 2.0 * high - 0.001, gap = 0.003;  // m, of the round organ once it lies
  const auto probe_at = [&](double time) {
    const double depth = (press + gap) * plan.share(time, plan.settle) - gap;
    return phymul::ToolPose{.position = {-0.006, 0.0, top + radius - depth}};
  };
  const auto turned = phymul::Quaternion(Eigen::AngleAxisd(0.45 * 3.14159265, Vec3::UnitY()));
  const Vec3 outside(0.050, 0.0, 0.018), inward = -(turned * Vec3::UnitZ());
  const auto needle_at = [&](double time) {
    return phymul::ToolPose{.position = outside + 0.045 * plan.share(time, plan.needle()) * inward,
                            .orientation = turned};
  };

  phymul::Simulation sim({{"flat", flat_organ(options.quick), {.young = 25e3, .poisson = 0.4, .density = 1000.0}},
                          {"round", round_organ(options.quick), {.young = 12e3, .poisson = 0.4, .density = 1000.0}}},
                         {.backend = "cpu", .damping = {.rate = 30.0}, .solver = {.threads = 1}});
  const Model& model = sim.model();
  // Neither organ can reach itself.
  phymul::Scene& scene = sim.scene();
  scene.gravity({0, 0, -9.81}).fix("flat/z0").contacts({.friction = 0.4, .self = false});
  const phymul::Needle needle{.length = 0.08, .puncture = 0.4, .cutting = 0.25, .spread = 0.009};
  const auto ball = scene.add_tool({.shape = phymul::Sphere{radius}, .pose = probe_at(0.0), .friction = 0.2});
  const auto shaft = scene.add_tool({.shape = needle, .pose = needle_at(0.0), .friction = 0.3});
  std::printf("%d particles; %s\n", model.particle_count(),
              phymul::describe(phymul::body_limits(model, sim.solver().topology())).c_str());

  const ScenePictures pictures(model, cells_beyond(model, Vec3::Zero(), Vec3::UnitY()));
  ScenePictureOptions sheet;
  sheet.full_scale = press;
  sheet.held = model.group("flat/z0");
  sheet.frame = model.rest;
  sheet.frame.push_back({0.0, 0.0, top + 2.0 * radius + gap});
  sheet.eye = Vec3(0.15, -1.0, 0.35);
  int drawn = 0;
  const auto draw = [&](const std::string& title, const std::string& subtitle) {
    sheet.title = std::to_string(++drawn) + ". " + title;
    sheet.subtitle = subtitle;
    sheet.tools = {{phymul::Sphere{radius}, sim.pose_of(ball), probe_colour, "probe, 24 mm"},
                   {needle, sim.pose_of(shaft), needle_colour, "needle"}};
    pictures.draw(sim.state(), sheet, options.file("two_organs_" + std::to_string(drawn) + ".png"));
  };

  Curve curve(options.file("two_organs.csv"), "time_s,probe_N,needle_N");
  double pressed = 0.0, pushed = 0.0, pulled = 0.0, probe = 0.0, along = 0.0;
  for (double time = 0.0; time < plan.end();) {
    ball.move_to(probe_at(time + tick));
    shaft.move_to(needle_at(time + tick));
    time = advance(sim, tick);
    probe = sim.force_on(ball).mean_force.z();
    along = -sim.force_on(shaft).mean_force.dot(inward);
    curve.add({time, probe, along});
    if (time < plan.back()) pressed = std::max(pressed, probe);
    pushed = std::max(pushed, along);
    pulled = std::min(pulled, along);
    if (drawn == 0 && time > plan.settle - tick)
      draw("One lies on the other", "12 kPa on 25 kPa, under gravity; cut open");
    if (drawn == 1 && time > plan.needle() - tick) draw("A probe presses", text("10 mm deep: %.2f N on it", probe));
    if (drawn == 2 && time > plan.back() - tick) {
      draw("A needle goes in under it", text("%.2f N on the probe, %.2f N on the needle", probe, along));
    }
  }
  draw("Both have gone", "the organs come back");
  std::printf("probe at most %.2f N, needle %.2f N in and %.2f N out\n", pressed, pushed, pulled);
  require(pressed > 0.1 && std::abs(probe) < 0.01, "the probe does not press, or still does when it is away");
  require(pushed > 0.9 * needle.puncture, "the needle's force does not rise to the puncture's");
  require(pulled < -0.02 && std::abs(along) < 0.01, "the needle is not pulled back, or still is when it is out");
}

}  // namespace

int main(int argc, char** argv) {
  return run_example(argc, argv, "A soft organ on a stiffer one, a probe and a needle: forces as CSV, and pictures.",
                     run);
}
