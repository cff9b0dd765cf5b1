// SPDX-License-Identifier: MIT
//
// two_organs [FOLDER]: a soft organ lies on a stiffer one; a round probe presses it, by 12 mm and back. Writes the
// probe's force over its depth (two_organs.csv) and three pictures.
#include <phymul/phymul.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "picture.h"

namespace {

using phymul::Model;
using phymul::State;
using phymul::Vec3;

constexpr double radius = 0.012, press = 0.012;                   // m
constexpr double settle = 0.4, down = 0.5, hold = 0.3, up = 0.5;  // s

Model organ(const Vec3& corner, int nx, int ny, int nz, double young) {
  Model model = phymul::make_block(0.005 * Vec3(nx, ny, nz), nx, ny, nz);
  phymul::set_material(model, {.young = young, .poisson = 0.4, .density = 1000.0});
  return phymul::moved(std::move(model), corner);
}

/// m below where the probe touches at first.
double depth_at(double time) {
  if (time < settle) return -0.002;
  const double pressed = time - settle - down;
  if (pressed < 0.0) return -0.002 + (press + 0.002) * (time - settle) / down;
  return pressed < hold ? press : std::max(press - (press + 0.002) * (pressed - hold) / up, -0.002);
}

class Pictures {
 public:
  Pictures(const Model& model, std::string folder) : pictures_(model), folder_(std::move(folder)) {
    options_.width = 900;
    options_.height = 700;
    options_.full_scale = press;
    options_.fixed = model.group("lower/z0");
    options_.frame = model.rest;
    options_.eye = Vec3(0.4, -1.0, 0.35);
  }

  void draw(const State& state, const std::string& file, const std::string& title, const std::string& subtitle) {
    options_.title = title;
    options_.subtitle = subtitle;
    pictures_.draw(state, options_, folder_ + '/' + file);
    std::printf("%s/%s\n", folder_.c_str(), file.c_str());
  }

 private:
  BodyPictures pictures_;
  PictureOptions options_;
  std::string folder_;
};

void run(const std::string& folder) {
  const Model lower = organ({0, 0, 0}, 16, 12, 4, 12e3), upper = organ({0.013, 0.011, 0.0215}, 10, 8, 5, 3e3);
  const phymul::NamedBody bodies[] = {{"lower", &lower}, {"upper", &upper}};
  const Model model = phymul::merge_models(bodies);
  const double top = 0.0215 + 0.025 - 0.0015;  // m, of the upper organ once it lies
  const auto probe_at = [&](double depth) { return Vec3(0.038, 0.031, top + radius - depth); };

  phymul::Scene scene(model);
  scene.gravity({0, 0, -9.81}).fix("lower/z0").contacts({.friction = 0.4});
  scene.add_tool("probe", {.shape = phymul::Sphere{radius}, .pose = {.position = probe_at(-0.002)}, .friction = 0.2});
  phymul::SolverOptions options;
  options.damping.rate = 20.0;
  options.threads = 1;
  const auto solver = phymul::make_solver("cpu", model, scene, {}, options);
  const auto topology = phymul::describe(phymul::body_limits(model, solver->topology()));
  std::printf("%s\n", topology.c_str());

  Pictures pictures(model, folder);
  std::ofstream curve(folder + "/two_organs.csv");
  curve << "time,depth,force\n";
  const double dt = 0.4 * solver->stable_step();
  const int steps = static_cast<int>(0.01 / dt);
  double largest = 0.0;
  bool settled = false, pressed = false;
  for (double time = 0.0; time < settle + down + hold + up + 0.1; time = solver->read().time) {
    scene.tool("probe").pose({.position = probe_at(depth_at(time + steps * dt))});
    const phymul::StepReport report = solver->step(steps, dt);
    if (!report.ok()) throw phymul::Error(report.message());
    const double force = solver->tool_force("probe").mean_force.z();
    largest = std::max(largest, force);
    curve << report.time << ',' << depth_at(report.time) << ',' << force << '\n';
    if (!settled && report.time >= settle) {
      settled = true;
      pictures.draw(solver->read(), "two_organs_1.png", "1. One lies on the other", "3 kPa on 12 kPa, under gravity");
    }
    if (!pressed && report.time >= settle + down + 0.9 * hold) {
      pressed = true;
      char text[96];
      std::snprintf(text, sizeof text, "a ball of 24 mm, 12 mm deep: %.2f N", force);
      pictures.draw(solver->read(), "two_organs_2.png", "2. A probe presses", text);
    }
  }
  pictures.draw(solver->read(), "two_organs_3.png", "3. It has gone", "the organs come back");
  std::printf("largest force %.3f N; %s/two_organs.csv\n", largest, folder.c_str());
  if (!(largest > 0.0)) throw phymul::Error("the probe felt nothing");
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string folder = argc > 1 ? argv[1] : ".";
  std::filesystem::create_directories(folder);
  run(folder);
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "two_organs: %s\n", error.what());
  return 1;
} catch (const std::filesystem::filesystem_error& error) {
  std::fprintf(stderr, "two_organs: %s\n", error.what());
  return 1;
}
