// SPDX-License-Identifier: MIT
//
// gallbladder [--out DIR] [--quick]: a thin bag filled with bile, held at its neck and lying on a liver. A probe
// presses it while its duct is closed, so that its pressure rises; then the duct opens and it empties under the probe.
// In the end a clip closes the neck, a blade cuts it off behind the clip, and a grasper lifts it out. Writes force,
// pressure and volume (gallbladder.csv), and pictures.
#include <phymul/phymul.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "example_run.h"
#include "scene_picture.h"

namespace {

using phymul::Vec3;

constexpr double radius = 0.016, half_length = 0.038;  // m
constexpr double tick = 1e-3;                          // s
constexpr double duct = 6e-8;                          // m^3/(Pa s)
const phymul::Material wall{.young = 50e3, .poisson = 0.45, .density = 1050, .thickness = 2e-3};
const phymul::Sphere tip{0.010};

/// A pear along x, its neck at high x.
phymul::Surface pear(double spacing) {
  const phymul::Model ball = phymul::make_body(phymul::solid_ball({0, 0, 0}, radius), {.spacing = spacing});
  phymul::Surface surface{.vertices = ball.rest, .triangles = phymul::surface_triangles(ball), .notes = {}};
  for (Vec3& place : surface.vertices) {
    const double along = place.x() / radius, narrow = 1.0 - 0.45 * along;
    place = Vec3(half_length * along, narrow * place.y(), narrow * place.z());
  }
  return surface;
}

double enclosed(const std::vector<std::array<phymul::Index, 3>>& triangles, const phymul::VecList& x) {
  double volume = 0.0;
  for (const auto& [a, b, c] : triangles) volume += x[a].dot(x[b].cross(x[c])) / 6.0;
  return volume;
}

void run(const ExampleOptions& options) {
  const phymul::Model bag =
      with_spare_particles(phymul::make_wall(pear(options.quick ? 4.5e-3 : 3e-3), {.material = wall}), 100);
  const auto triangles = phymul::surface_triangles(bag);
  const double full = enclosed(triangles, bag.rest);
  phymul::Simulation sim(bag, {.backend = "cpu", .damping = {.rate = 15}, .solver = {.threads = 1}});
  sim.scene().fix(bag.particles_in([](const Vec3& place) { return place.x() > 0.85 * half_length; }));
  sim.scene().constrain_volume({.triangles = triangles, .volume = full, .applied_to = {}, .name = "bile"});
  double low = 0.0, high = 0.0;
  for (const Vec3& place : bag.rest) {
    low = std::min(low, place.z());
    high = std::max(high, place.z());
  }
  sim.scene().add_tool("liver",
                       {.shape = phymul::HalfSpace{}, .pose = {.position = {0, 0, low - 1e-4}}, .friction = 0.5});
  const Vec3 above(-0.015, 0.0, high + tip.radius + 1e-3);
  const auto probe = sim.scene().add_tool("probe", {.shape = tip, .pose = {.position = above}, .friction = 0.5});
  std::printf("%d particles and %d spare ones, %.1f ml\n", bag.particle_count() - 100, 100, 1e6 * full);

  ScenePictureOptions sheet;
  sheet.full_scale = 0.012;
  sheet.eye = Vec3(-0.3, -1.0, 0.35);
  sheet.frame = bag.rest;
  sheet.frame.push_back(above + Vec3(0, 0, 0.012));
  const auto draw = [&](const char* title, const std::string& subtitle, const char* file) {
    sheet.title = title;
    sheet.subtitle = subtitle;
    sheet.tools = {{tip, sim.pose_of(probe), probe_colour, "probe"}};
    draw_tissue(sim.model(), sim.state(), sheet, options.file(file));
  };
  Curve curve(options.file("gallbladder.csv"), "time_s,probe_N,pressure_Pa,volume_ml");
  const double depth = 0.013, slow = options.quick ? 0.25 : 1.0;
  const auto advance_by = [&](double seconds, const auto& way) {
    for (double time = 0.0; time < seconds; time += tick) {
      probe.move_to({.position = above - Vec3(0, 0, way(time / seconds))});
      const double now = advance(sim, tick);
      const phymul::FluidState& bile = sim.solver().fluid("bile");
      curve.add({now, sim.force_on(probe).mean_force.norm(), bile.pressure, 1e6 * bile.volume});
    }
  };

  advance_by(slow, [&](double share) { return share * (depth + 0.001); });
  advance_by(0.3 * slow, [&](double) { return depth + 0.001; });
  const double pressed = sim.force_on(probe).mean_force.norm(), pressure = sim.solver().fluid("bile").pressure;
  const double change = enclosed(triangles, sim.state().position) / full - 1.0;
  draw("1. A probe presses a full gallbladder", text("%.2f N, %.0f Pa inside", pressed, pressure), "gallbladder_1.png");
  require(pressed > 0.02 && pressure > 20.0, "the bag does not push back");
  require(std::abs(change) < 1e-6, "bile is lost while the duct is closed");

  sim.scene().set_fluid("bile", {.conductance = duct});
  advance_by(2.0 * slow, [&](double) { return depth + 0.001; });
  const double left = sim.solver().fluid("bile").volume, after = sim.solver().fluid("bile").pressure;
  const double remains = sim.force_on(probe).mean_force.norm();
  draw("2. The duct is open: bile flows out", text("%.1f of %.1f ml left, %.2f N", 1e6 * left, 1e6 * full, remains),
       "gallbladder_2.png");
  require(left < 0.99 * full && after < 0.7 * pressure && remains < pressed, "it does not empty");

  sim.scene().set_fluid("bile", {});
  advance_by(0.5 * slow, [&](double share) { return (1.0 - share) * (depth + 0.001); });
  advance_by(0.5 * slow, [](double) { return 0.0; });
  draw("3. The duct is closed, the probe gone", text("%.0f Pa: the wall sucks", sim.solver().fluid("bile").pressure),
       "gallbladder_3.png");
  std::printf("%.2f N and %.0f Pa pressed; %.1f ml flow out; then %.0f Pa\n", pressed, pressure, 1e6 * (full - left),
              sim.solver().fluid("bile").pressure);
  require(sim.solver().fluid("bile").volume == left, "bile is lost after the duct was closed");
  require(sim.solver().fluid("bile").pressure < 0.0, "the wall does not suck");

  // A clip across the neck, from below to above, which its applier closes by and by.
  std::array<std::vector<phymul::Index>, 2> walls;
  for (const int side : {0, 1}) {
    walls[side] = bag.particles_in([&](const Vec3& x) {
      return std::abs(x.x() - 0.6 * half_length) < 2.5e-3 && std::abs(x.y()) < 5e-3 && (x.z() > 0.0) == (side == 1);
    });
  }
  const double open = 0.014, closed = 1e-3, closing = 0.3 * slow;
  const phymul::ThreadHandle clip_of_neck =
      sim.scene().add_clip("clip", {.gap = open, .holding = 6.0}, phymul::at_mean(walls[0]), phymul::at_mean(walls[1]));
  for (double time = 0.0; time < closing; time += tick) {
    for (const phymul::ThreadTip end : {phymul::ThreadTip::first, phymul::ThreadTip::last}) {
      clip_of_neck.clamp(end, 6.0, open + (closed - open) * std::min(1.0, 1.2 * time / closing));
    }
    advance(sim, tick);
  }

  // The blade stands upright, its edge across the neck, and cuts downward.
  const Vec3 over(0.74 * half_length, 0.0, high);
  const phymul::Quaternion across(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitZ()));
  const auto blade = sim.scene().add_tool(
      "blade", {.shape = phymul::Blade{.width = 0.03}, .pose = {.position = over, .orientation = across}});
  const double cutting = 0.4 * slow;
  for (double time = 0.0; time < cutting; time += tick) {
    blade.move_to({.position = over - Vec3(0, 0, 2.5 * high * time / cutting), .orientation = across});
    advance(sim, tick);
  }
  sim.scene().remove_tool("blade");
  int parts = 0;
  for (const phymul::ConnectedBody& part : connected_bodies(sim.model())) {
    constexpr double crumb = 1e-8;  // m^3
    if (part.volume > crumb) ++parts;
    if (part.volume <= crumb) sim.remove_cells(part.cells);
  }
  require(parts == 2, "the blade does not cut the neck through");
  require(sim.scene().any_volume_open(), "a cut bag keeps its bile");

  const phymul::State cut = sim.state();
  Vec3 grasped(-0.015, 0.0, low);
  for (const auto& triangle : triangles) {
    const Vec3& place = cut.position[triangle[0]];
    if (std::hypot(place.x() - grasped.x(), place.y()) < 6e-3) grasped.z() = std::max(grasped.z(), place.z());
  }
  const phymul::Sphere jaw{4e-3};
  grasped.z() += jaw.radius;
  const auto grasper = sim.scene().add_tool("grasper", {.shape = jaw, .pose = {.position = grasped}});
  grasper.grasp(3e-3);
  for (double time = 0.0; time < slow; time += tick) {
    grasper.move_to({.position = grasped + Vec3(0, 0, 0.03 * std::min(1.0, 1.3 * time / slow))});
    advance(sim, tick);
  }
  const phymul::State lifted = sim.state();
  std::array<Vec3, 2> clip{Vec3::Zero(), Vec3::Zero()};
  for (const int side : {0, 1}) {
    for (const phymul::Index i : walls[side])
      clip[side] += lifted.position[i] / static_cast<double>(walls[side].size());
  }
  sheet.title = "4. Clipped, cut off and lifted out";
  sheet.subtitle = text("%.1f mm between the walls under the clip", 1e3 * (clip[1] - clip[0]).norm());
  sheet.full_scale = 0.04;
  sheet.frame.insert(sheet.frame.end(), lifted.position.begin(), lifted.position.end());
  sheet.frame.push_back(sim.pose_of(grasper).position + Vec3(0, 0, 2.0 * jaw.radius));
  const phymul::Quaternion along = phymul::Quaternion::FromTwoVectors(Vec3::UnitZ(), clip[1] - clip[0]);
  sheet.tools = {{jaw, sim.pose_of(grasper), probe_colour, "grasper"},
                 {phymul::Capsule{1.2e-3, 8e-3},
                  {.position = 0.5 * (clip[0] + clip[1]), .orientation = along},
                  {0.3, 0.3, 0.35, 1.0},
                  "clip"}};
  draw_tissue(sim.model(), lifted, sheet, options.file("gallbladder_4.png"));
  require((clip[1] - clip[0]).norm() < 2e-3, "the clip does not hold");
  require(clip[0].z() - cut.position[walls[0].front()].z() > 0.01, "it is not lifted");
}

}  // namespace

int main(int argc, char** argv) {
  return run_example(argc, argv, "A gallbladder is pressed, closed and open: force, pressure, volume; pictures.", run);
}
