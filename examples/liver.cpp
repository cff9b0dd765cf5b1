// SPDX-License-Identifier: MIT
//
// liver [--out DIR] [--quick]: a liver of 1.5 litres that the program makes itself, with a stiffer tumour, on
// ligaments. A probe presses on the tumour at 1 kHz and slides off. Writes depth, force and the tumour's place
// (liver.csv), and pictures of the visible surface, which is finer than the body, and of the body cut open.
#include <phymul/phymul.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "example_run.h"
#include "liver_shape.h"
#include "scene_picture.h"

namespace {

using phymul::Index;
using phymul::Vec3;

// m; x to the patient's right, y to the front, z to the head (RAS).
constexpr double probe_radius = 0.008, probe_length = 0.12, press = 0.015, slide = 0.025, gap = 0.001,
                 tumour_radius = 0.013;
const Vec3 tumour(0.035, 0.040, 0.022);
constexpr double tick = 1e-3;  // s

void run(const ExampleOptions& options) {
  phymul::BodyReport report;
  phymul::Model model = phymul::make_body(liver(), {.spacing = options.quick ? 0.016 : 0.011}, &report);
  phymul::set_material(model, {.young = 4e3, .poisson = 0.45, .density = 1060});
  const auto in_tumour = [](const Vec3& x) { return (x - tumour).norm() < tumour_radius; };
  const double got = phymul::set_material(model, {.young = 40e3, .poisson = 0.45, .density = 1060}, in_tumour);
  std::printf("%d particles, %.0f ml; tumour %.1f of %.1f ml\n", report.particles, 1e6 * report.volume, 1e6 * got,
              4e6 / 3.0 * std::numbers::pi * std::pow(tumour_radius, 3));
  // Grown to the diaphragm behind and above; a ligament from the front of the right lobe, which only pulls.
  std::vector<Index> bare, front;
  for (const Index i : model.group("surface")) {
    const Vec3& x = model.rest[i];
    if (x.y() < -0.02 && x.z() > 0.0) bare.push_back(i);
    if (std::abs(x.x() + 0.02) < 0.012 && x.y() > 0.02 && x.z() > 0.01) front.push_back(i);
  }
  require(!bare.empty() && !front.empty(), "nothing to attach");
  phymul::Surface surface = liver_surface(options.quick ? 0.010 : 0.004);
  const phymul::Model visible = triangle_body(std::move(surface.vertices), surface.triangles);
  const phymul::Skin skin(model, visible.rest);

  phymul::Simulation sim(model, {.backend = "cpu", .damping = {.rate = 30.0}, .solver = {.threads = 1}});
  sim.scene().attach(bare, phymul::World{}, {.stiffness = 2e6, .damping = 2e3, .name = "diaphragm"});
  const auto ligament = sim.scene().attach(front, phymul::World{.offset = {0.0, 0.02, 0.03}},
                                           {.stiffness = 1e6, .slack = true, .name = "falciform ligament"});
  double top = -HUGE_VAL;  // m, of the surface over the tumour
  for (const Vec3& x : visible.rest) {
    if (std::hypot(x.x() - tumour.x(), x.y() - tumour.y()) < 0.01) top = std::max(top, x.z());
  }
  const Vec3 start(tumour.x(), tumour.y() - 0.004, top + probe_radius + gap);
  const auto pose_at = [&](double time) {
    const double down = std::clamp(time / 0.5, 0.0, 1.0) - std::clamp((time - 1.3) / 0.2, 0.0, 1.0);
    const double aside = std::clamp((time - 0.7) / 0.5, 0.0, 1.0);
    return phymul::ToolPose{.position = start + Vec3(slide * aside, 0.0, -(press + gap) * down),  // lies along y
                            .orientation = phymul::Quaternion(std::sqrt(0.5), -std::sqrt(0.5), 0.0, 0.0)};
  };
  const phymul::Capsule shape{probe_radius, probe_length};
  const auto probe = sim.scene().add_tool(
      {.shape = shape, .pose = pose_at(0.0), .friction = 0.05, .contact = phymul::ToolContact::surface});

  std::vector<Index> of_tumour;
  for (const phymul::Cell& cell : model.cells) {
    if (cell.material == 1) of_tumour.insert(of_tumour.end(), cell.particles.begin(), cell.particles.end());
  }
  const ScenePictures outside(visible), cut(model, cells_beyond(model, tumour, Vec3::UnitX()), of_tumour);
  ScenePictureOptions sheet;
  sheet.full_scale = press;
  sheet.eye = Vec3(-0.45, 1.0, 0.75);
  sheet.mesh = false;
  sheet.frame = visible.rest;
  sheet.frame.push_back(start);
  const auto draw = [&](const std::string& title, const std::string& subtitle, const char* file) {
    sheet.title = title;
    sheet.subtitle = subtitle;
    sheet.tools = {{shape, sim.pose_of(probe), probe_colour, "probe, 16 mm"}};
    phymul::State seen;
    seen.position = skin.deform(sim.state().position);
    seen.velocity.assign(seen.position.size(), Vec3::Zero());
    outside.draw(seen, sheet, options.file(file));
  };
  draw("1. A liver of 4 kPa with a tumour of 40 kPa",
       text("%.0f particles move a surface of %.0f points", report.particles, static_cast<double>(visible.rest.size())),
       "liver_1.png");

  Curve curve(options.file("liver.csv"), "time_s,force_N,tumour_moved_mm,ligament_N");
  const BodyPoint middle(model, tumour);
  double largest = 0.0, over_tumour = 0.0, beside = 0.0, moved = 0.0, work = 0.0, ligament_pull = 0.0;
  int ticks = 0;
  for (double time = 0.0; time < 2.5;) {
    probe.move_to(pose_at(time + tick));
    const auto begin = std::chrono::steady_clock::now();
    time = advance(sim, tick);
    work += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const double force = sim.force_on(probe).mean_force.norm();
    moved = (middle.now(sim.state()) - middle.rest()).norm();
    ligament_pull = sim.report_of(ligament).force.norm();
    curve.add({time, force, 1e3 * moved, ligament_pull});
    largest = std::max(largest, force);
    if (++ticks == 700) {
      over_tumour = force;
      draw("2. The probe is 15 mm in, over the tumour",
           text("%.2f N on it; the tumour has moved %.1f mm; the ligament pulls with %.2f N", force, 1e3 * moved,
                ligament_pull),
           "liver_2.png");
      ScenePictureOptions open = sheet;
      open.title = "3. The same, cut open through the tumour";
      open.subtitle = "the part on the patient's right; cells of the body, not its surface";
      open.eye = Vec3(-1.0, 0.35, 0.3);
      open.mesh = true;
      open.key = {{KeyEntry::Mark::line, organ_colour, "tumour"}};
      open.frame = sim.state().position;
      open.frame.push_back(start);
      cut.draw(sim.state(), open, options.file("liver_3.png"));
    }
    if (ticks == 1300) beside = force;
  }
  const double left = (middle.now(sim.state()) - middle.rest()).norm();
  std::printf(
      "at most %.2f N, %.2f N over the tumour, %.2f N beside it; %.2f mm left at the end; %.0f us a tick of 1 ms\n",
      largest, over_tumour, beside, 1e3 * left, 1e6 * work / ticks);
  require(over_tumour > 1.05 * beside && beside > 0.0, "the tumour is not felt");
  require(left < 0.02 * press, "the body does not come back");
}

}  // namespace

int main(int argc, char** argv) {
  return run_example(argc, argv, "A probe presses on a liver with a tumour: forces as CSV, and pictures.", run);
}
