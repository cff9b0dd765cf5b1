// SPDX-License-Identifier: MIT
//
// cloth_on_sphere [--out DIR] [--quick]: a square of cloth falls on a ball and the floor below it. Writes how high its
// lowest and highest particles are and what it presses ball and floor with (cloth_on_sphere.csv), and three pictures.
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>

#include "example_run.h"
#include "scene_picture.h"

namespace {

using phymul::Index;
using phymul::Model;
using phymul::Vec3;

constexpr double width = 0.32, ball = 0.06, below = -0.07;  // m; z of the floor
constexpr double tick = 0.005, averaged = 0.2;              // s
constexpr double surface_mass = 0.2;                        // kg/m^2
constexpr phymul::Colour ball_colour{0.86, 0.55, 0.30, 1.0}, floor_colour{0.90, 0.89, 0.86, 1.0};

/// Springs to the eight neighbours and to those two places on, which hold it against bending.
Model cloth(int side) {
  const double spacing = width / (side - 1);
  const auto at = [side](int i, int j) { return static_cast<Index>(j * side + i); };
  Model model;
  model.name = "cloth";
  const double middle = 0.5 * (side - 1);
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) model.rest.push_back({spacing * (i - middle), spacing * (j - middle), 0.08});
  }
  model.mass.assign(model.rest.size(), surface_mass * spacing * spacing);
  model.stiffness.assign(model.rest.size(), 4.0);  // N/m
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      std::vector<Index> row;
      for (const auto& [di, dj] : {std::pair{1, 0},
                                   {-1, 0},
                                   {0, 1},
                                   {0, -1},
                                   {1, 1},
                                   {-1, -1},
                                   {1, -1},
                                   {-1, 1},
                                   {2, 0},
                                   {-2, 0},
                                   {0, 2},
                                   {0, -2}}) {
        const int x = i + di, y = j + dj;
        if (x >= 0 && x < side && y >= 0 && y < side) row.push_back(at(x, y));
      }
      model.neighbours.push_row(row.begin(), row.end());
    }
  }
  for (int j = 0; j + 1 < side; ++j) {
    for (int i = 0; i + 1 < side; ++i) {
      phymul::Cell cell;
      cell.type = phymul::CellType::quad;
      cell.particles = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
      model.cells.push_back(std::move(cell));
    }
  }
  phymul::validate(model);
  return model;
}

/// Throws phymul::Error where a particle is in the ball or under the floor.
std::pair<double, double> extent(const phymul::State& state) {
  double lowest = HUGE_VAL, highest = -HUGE_VAL;
  for (const Vec3& x : state.position) {
    lowest = std::min(lowest, x.z());
    highest = std::max(highest, x.z());
    require(x.norm() > 0.99 * ball, "a particle is in the ball");
  }
  require(lowest > below - 5e-4, "a particle is below the floor");
  return {lowest, highest};
}

void run(const ExampleOptions& options) {
  const int side = options.quick ? 17 : 33;
  const double spacing = width / (side - 1);
  phymul::Simulation sim(cloth(side), {.backend = "cpu",
                                       .damping = {.rate = 2.0},
                                       .step = 0.4,
                                       .topology = {.law = phymul::Law::springs},
                                       .solver = {.threads = 1}});
  phymul::Scene& scene = sim.scene();
  scene.gravity({0, 0, -9.81}).contacts({.friction = 0.4, .margin = 0.15 * spacing});
  const double margin = 0.2 * spacing;
  const auto sphere = scene.add_tool({.shape = phymul::Sphere{ball}, .friction = 0.3, .margin = margin});
  const auto floor =
      scene.add_tool({.shape = phymul::HalfSpace{}, .pose = {.position = {0, 0, below}}, .friction = 0.5});

  const ScenePictures pictures(sim.model());
  ScenePictureOptions sheet;
  sheet.full_scale = 0.15;
  sheet.frame = {Vec3(-0.17, -0.17, below), Vec3(0.17, 0.17, 0.09), Vec3(0.17, -0.17, below), Vec3(-0.17, 0.17, below)};
  sheet.eye = Vec3(0.5, -1.0, 0.45);
  sheet.tools = {{phymul::Sphere{ball}, {}, ball_colour, "ball, 12 cm"},
                 {phymul::HalfSpace{}, {.position = {0, 0, below - 0.001}}, floor_colour, ""}};
  Curve curve(options.file("cloth_on_sphere.csv"), "time_s,lowest_mm,highest_mm,ball_N,floor_N");
  const double moments[] = {0.09, 0.22, options.quick ? 1.2 : 1.6};
  const char* titles[] = {"1. It meets the ball", "2. It hangs over it", "3. It lies on ball and floor"};
  double on_ball = 0.0, on_floor = 0.0;  // N, means of the last moments: the cloth still swings a little
  for (int k = 0; k < 3; ++k) {
    for (double time = sim.time(); time < moments[k];) {
      time = advance(sim, tick);
      const auto [lowest, highest] = extent(sim.state());
      const Vec3& on_sphere = sim.force_on(sphere).mean_force;
      const Vec3& on_plane = sim.force_on(floor).mean_force;
      curve.add({time, 1e3 * lowest, 1e3 * highest, -on_sphere.z(), -on_plane.z()});
      if (time < moments[2] - averaged) continue;
      on_ball -= on_sphere.z() * tick / averaged;
      on_floor -= on_plane.z() * tick / averaged;
    }
    sheet.title = titles[k];
    sheet.subtitle =
        text("%.2f s; cloth of 32 cm, 200 g/m\u00b2, friction 0.3 on the ball and 0.5 on the floor", sim.time());
    pictures.draw(sim.state(), sheet, options.file(text("cloth_on_sphere_%.0f.png", k + 1.0)));
  }
  const double weight = surface_mass * spacing * spacing * side * side * 9.81;
  std::printf("ball and floor carry %.3f N and %.3f N of %.3f N\n", on_ball, on_floor, weight);
  require(on_ball > 0.3 * weight && on_floor > 0.0, "the cloth does not lie on ball and floor");
  require(std::abs(on_ball + on_floor - weight) < 0.1 * weight, "ball and floor do not carry the cloth's weight");
}

}  // namespace

int main(int argc, char** argv) {
  return run_example(argc, argv, "A cloth falls on a ball and the floor: forces as CSV, and pictures.", run);
}
