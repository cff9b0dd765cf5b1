// SPDX-License-Identifier: MIT
//
// phymul-pictures [FOLDER]: draws the pictures of docs/guide/pictures.md anew, three moments each of a tetrahedron and
// of a cylinder, as figures 3.1 to 3.6 of the 2007 thesis show them: at rest, deformed, come back.
#include <phymul/phymul.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "scene_picture.h"

namespace {

using phymul::State;
using phymul::Vec3;
using phymul::VecList;

struct Moment {
  std::string file, title, subtitle;
  State state;
  VecList attractors;  // or empty
  bool driven = false;
};

std::string text(const char* format, double a, double b = 0.0) {
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, format, a, b);
  return buffer;
}

VecList attractors_of(const phymul::Solver& solver, const State& state) {
  VecList attractors(state.position.size());
  phymul::attractors(solver.topology(), state.position, attractors);
  return attractors;
}

/// Runs the body to rest and says how it came there.
State come_to_rest(phymul::Solver& solver, std::string& subtitle) {
  const phymul::RestResult rest = solver.run_to_rest(200'000, 0.5 * solver.stable_step());
  if (!rest.converged()) throw phymul::Error("the body did not come to rest: " + rest.message());
  State state = solver.read();
  const double nanometres = std::ceil(1e9 * displacement_norms(solver.model(), state).max);
  subtitle = text("at rest again after %.0f steps, within %.0f nm of its rest shape", rest.report.steps,
                  std::max(nanometres, 1.0));
  return state;
}

void draw(const phymul::Model& model, const std::vector<Moment>& moments, ScenePictureOptions options,
          const std::string& folder, const std::vector<phymul::Index>& driven) {
  const ScenePictures pictures(model);
  options.frame = model.rest;
  for (const Moment& moment : moments) {
    options.full_scale = std::max(options.full_scale, displacement_norms(model, moment.state).max);
    options.frame.insert(options.frame.end(), moment.state.position.begin(), moment.state.position.end());
    options.frame.insert(options.frame.end(), moment.attractors.begin(), moment.attractors.end());
  }
  for (const Moment& moment : moments) {
    options.title = moment.title;
    options.subtitle = moment.subtitle;
    options.attractors = moment.attractors;
    options.driven = moment.driven ? driven : std::vector<phymul::Index>{};
    pictures.draw(moment.state, options, folder + '/' + moment.file);
    std::printf("%s/%s\n", folder.c_str(), moment.file.c_str());
  }
}

/// One particle is pulled off its place: each attractor shows where a particle belongs, seen from its neighbours.
void draw_tetrahedron(const std::string& folder) {
  constexpr double edge = 0.010;  // m
  phymul::Model model = phymul::make_tetrahedron(edge);
  for (double& mass : model.mass) mass = 1e-4;  // kg
  phymul::Scene scene(model);
  scene.fix("base");
  phymul::SolverOptions options;
  options.damping.rate = 20.0;
  const auto solver = phymul::make_solver("auto", model, scene, {}, options);

  State pulled = phymul::rest_state(model);
  const std::vector<phymul::Index> apex = model.group("apex");
  pulled.position[apex.front()] += edge * Vec3(0.55, 0.15, 0.35);
  solver->reset(pulled);
  std::string how;
  const State back = come_to_rest(*solver, how);

  ScenePictureOptions picture;
  picture.inside = true;
  picture.held = model.group("base");
  picture.eye = Vec3(0.35, -1.0, 0.35);
  picture.width = 760;
  picture.height = 700;
  const State rest = phymul::rest_state(model);
  draw(model,
       {{"tetrahedron_1_rest.png", "1. At rest", "each particle lies where the three others say: no force", rest, {}},
        {"tetrahedron_2_pulled.png", "2. One particle pulled away",
         "each is drawn to its attractor, where the others now say its place is", pulled,
         attractors_of(*solver, pulled), true},
        {"tetrahedron_3_returned.png", "3. Let go", how, back, {}}},
       picture, folder, apex);
}

/// The top of a cylinder of 275 particles is pulled up and aside, then let go.
void draw_cylinder(const std::string& folder) {
  phymul::Model model = phymul::make_cylinder(0.010, 0.040, 3, 8, 11);
  phymul::set_material(model, {.young = 10e3, .poisson = 0.3, .density = 1000.0});
  phymul::Scene scene(model);
  scene.fix("bottom");
  const std::vector<phymul::Index> top = model.group("top");
  phymul::Load pull;
  pull.type = phymul::LoadType::translation;
  pull.particles = top;
  pull.events = {{0.0, 0.0}, {0.5, 0.015}};  // s, m
  pull.direction = Vec3(0.8, 0.0, 0.6);
  scene.add(pull);
  phymul::SolverOptions options;
  options.damping.rate = 20.0;
  const auto solver = phymul::make_solver("auto", model, scene, {}, options);
  const double dt = 0.4 * solver->stable_step();
  const phymul::StepReport report = solver->step(static_cast<int>(0.7 / dt), dt);
  if (!report.ok()) throw phymul::Error(report.message());
  const State pulled = solver->read();
  scene.remove(scene.loads().size() - 1);
  std::string how;
  const State back = come_to_rest(*solver, how);

  ScenePictureOptions picture;
  picture.held = model.group("bottom");
  picture.eye = Vec3(0.35, -1.0, 0.35);
  picture.width = 760;
  picture.height = 900;
  draw(model,
       {{"cylinder_1_rest.png",
         "1. At rest",
         "275 particles, 10 kPa, Poisson's ratio 0.3",
         phymul::rest_state(model),
         {}},
        {"cylinder_2_pulled.png", "2. Its top moved, its bottom held", "12 mm aside and 9 mm up", pulled, {}, true},
        {"cylinder_3_returned.png", "3. Its top let go", how, back, {}}},
       picture, folder, top);
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string folder = argc > 1 ? argv[1] : "docs/pictures";
  if (folder == "--help" || folder == "-h") {
    std::puts("phymul-pictures [FOLDER]\nDraws the pictures of docs/guide/pictures.md, to docs/pictures by default.");
    return 0;
  }
  std::filesystem::create_directories(folder);
  draw_tetrahedron(folder);
  draw_cylinder(folder);
} catch (const std::exception& error) {
  std::fprintf(stderr, "phymul-pictures: %s\n", error.what());
  return 1;
}
