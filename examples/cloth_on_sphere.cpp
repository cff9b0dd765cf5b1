// SPDX-License-Identifier: MIT
//
// cloth_on_sphere [FOLDER]: a square of cloth falls on a ball and the floor below it. Writes how high its lowest and
// highest particles are and what it presses the ball with (cloth_on_sphere.csv), and three pictures.
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "picture.h"

namespace {

using phymul::Index;
using phymul::Model;
using phymul::Vec3;

constexpr int side = 33;                          // particles
constexpr double spacing = 0.01, ball = 0.06;     // m
constexpr double mass = 0.2 * spacing * spacing;  // kg a particle: 200 g/m^2

Index at(int i, int j) {
  return static_cast<Index>(j * side + i);
}

/// Springs to the eight neighbours and to those two places on, which hold it against bending.
Model cloth() {
  Model model;
  model.name = "cloth";
  const double middle = 0.5 * (side - 1);
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) model.rest.push_back({spacing * (i - middle), spacing * (j - middle), 0.08});
  }
  model.mass.assign(model.rest.size(), mass);
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

void run(const std::string& folder) {
  const Model model = cloth();
  phymul::Scene scene(model);
  scene.gravity({0, 0, -9.81}).contacts({.friction = 0.4, .skin = 0.15 * spacing});
  const double margin = 0.2 * spacing;
  scene.add_tool("ball", {.shape = phymul::Sphere{ball}, .pose = {}, .friction = 0.3, .margin = margin});
  scene.add_tool("floor", {.shape = phymul::HalfSpace{}, .pose = {.position = {0, 0, -0.07}}, .friction = 0.5});
  phymul::TopologyOptions springs;
  springs.law = phymul::Law::springs;
  phymul::SolverOptions options;
  options.damping.rate = 2.0;
  options.threads = 1;
  const auto solver = phymul::make_solver("cpu", model, scene, springs, options);

  BodyPictures pictures(model);
  PictureOptions picture;
  picture.width = 900;
  picture.height = 700;
  picture.full_scale = 0.15;
  picture.frame = {Vec3(-0.17, -0.17, -0.07), Vec3(0.17, 0.17, 0.08)};
  picture.eye = Vec3(0.5, -1.0, 0.5);
  std::ofstream curve(folder + "/cloth_on_sphere.csv");
  curve << "time,lowest,highest,force\n";
  const double dt = 0.4 * solver->stable_step();
  const double moments[] = {0.08, 0.2, 1.5};
  const char* titles[] = {"1. It meets the ball", "2. It hangs over it", "3. It lies on ball and floor"};
  for (int k = 0; k < 3; ++k) {
    for (double time = solver->read().time; time < moments[k];) {
      const phymul::StepReport report = solver->step(std::max(1, static_cast<int>(0.005 / dt)), dt);
      if (!report.ok()) throw phymul::Error(report.message());
      time = report.time;
      const phymul::State state = solver->read();
      double lowest = 1.0, highest = -1.0;
      for (const Vec3& x : state.position) {
        lowest = std::min(lowest, x.z());
        highest = std::max(highest, x.z());
        if (x.norm() < 0.99 * ball) throw phymul::Error("a particle is in the ball");
        if (x.z() < -0.0705) throw phymul::Error("a particle is below the floor");
      }
      curve << time << ',' << lowest << ',' << highest << ',' << -solver->tool_force("ball").mean_force.z() << '\n';
    }
    char text[96];
    std::snprintf(text, sizeof text, "%.2f s, a ball of 12 cm, cloth of 32 cm", solver->read().time);
    picture.title = titles[k];
    picture.subtitle = text;
    const std::string file = folder + "/cloth_on_sphere_" + std::to_string(k + 1) + ".png";
    pictures.draw(solver->read(), picture, file);
    std::printf("%s\n", file.c_str());
  }
  const double weight = mass * side * side * 9.81, force = -solver->tool_force("ball").mean_force.z();
  std::printf("the ball carries %.3f N of %.3f N\n", force, weight);
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string folder = argc > 1 ? argv[1] : ".";
  std::filesystem::create_directories(folder);
  run(folder);
} catch (const phymul::Error& error) {
  std::fprintf(stderr, "cloth_on_sphere: %s\n", error.what());
  return 1;
} catch (const std::filesystem::filesystem_error& error) {
  std::fprintf(stderr, "cloth_on_sphere: %s\n", error.what());
  return 1;
}
