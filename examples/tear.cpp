// SPDX-License-Identifier: MIT
//
// tear [--out DIR] [--quick]: a strip with a slanting notch is drawn until it tears; the tear turns across the pull.
// Writes pictures.
#include <phymul/bodies.h>
#include <phymul/phymul.h>

#include <cmath>

#include "example_run.h"
#include "scene_picture.h"

namespace {

using phymul::Vec3;

constexpr double width = 0.06, depth = 0.012, height = 0.1;  // m
constexpr double slope = 0.785, notch = 0.022;               // rad, m
constexpr double tick = 1e-3;                                // s

void run(const ExampleOptions& options) {
  phymul::Model strip = phymul::make_tetrahedral_block({width, depth, height}, 16, 4, 26, 0.2, 1);
  set_material(strip, {.young = 10e3, .poisson = 0.45, .density = 1000});
  phymul::Simulation sim(with_spare_particles(std::move(strip), 600), {.damping = {.rate = 20.0}});
  phymul::CutSurface cut = phymul::cut_plane({0, 0, 0.042}, {-std::sin(slope), 0, std::cos(slope)});
  cut.front = [](const Vec3& x) { return x.x() - notch * std::cos(slope); };
  sim.cut(cut);
  sim.scene().tear({.toughness = 3.0});  // J/m^2
  phymul::Load pull;
  pull.type = phymul::LoadType::translation;
  pull.particles = sim.model().group("z1");
  pull.direction = {0, 0, 1};
  pull.events = {{0.0, 0.0}, {2.0, 0.04}};  // m at s
  sim.scene().fix("z0").add(pull);

  ScenePictureOptions sheet;
  sheet.eye = Vec3(-0.4, -1.0, 0.25);
  sheet.full_scale = 0.02;
  sheet.frame = sim.model().rest;
  for (std::size_t i = 0; i < sim.model().rest.size(); ++i)
    sheet.frame.push_back(sim.model().rest[i] + Vec3(0, 0, 0.012));
  const auto draw = [&](const char* title, int torn, const char* file) {
    sheet.title = title;
    sheet.subtitle = text("drawn by %.1f mm, ", 20.0 * sim.time()) + text("cells torn: %.0f", torn);
    draw_tissue(sim.model(), sim.state(), sheet, options.file(file));
  };
  int torn = 0;
  bool apart = false;
  while (!apart && sim.time() < 1.5) {
    const phymul::StepReport report = sim.advance(tick);
    require(report.ok(), report.message());
    if (torn == 0 && report.torn > 0) draw("1. A slanting notch begins to tear", report.torn, "tear_1.png");
    const int before = torn;
    torn += report.torn;
    if (before < 120 && torn >= 120) draw("2. The tear turns across the pull", torn, "tear_2.png");
    apart = report.torn > 0 && connected_bodies(sim.model()).size() > 1;
  }
  require(apart, "the strip does not tear through");
  const double end = sim.time();
  while (sim.time() < end + 0.1) advance(sim, tick);
  draw("3. and goes through", torn, "tear_3.png");
  std::printf("%d cells torn, apart at %.1f mm\n", torn, 20.0 * end);
}

}  // namespace

int main(int argc, char** argv) {
  return run_example(argc, argv, "A strip with a notch is drawn until it tears: pictures.", run);
}
